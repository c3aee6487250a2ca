"""Policies as files that run without this project: TorchScript and ONNX, observation normaliser included.

Every file is read back and compared with the policy before it counts as written.
"""

from __future__ import annotations

import contextlib
import copy
import io
import json
import logging
import os
import warnings
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import torch
from rsl_rl.models import MLPModel
from tensordict import TensorDict
from torch import nn

from lift_lab.utils.errors import FileError, LiftLabError
from lift_lab.utils.io import temporary_path

TOLERANCE = 1e-4
"""Largest difference allowed between exported policy and policy, relative to the largest action (at least 1)."""


JIT_METADATA = "metadata.json"
"""Name of the metadata in a TorchScript file: ``torch.jit.load(path, _extra_files={"metadata.json": ""})``."""


class ExportError(LiftLabError, RuntimeError):
    """The outputs of an exported policy differ from those of the policy."""


def export_policy_as_jit(
    policy: MLPModel,
    normalizer: nn.Module | None,
    path: str | Path,
    filename: str = "policy.pt",
    metadata: Mapping[str, str] | None = None,
) -> Path:
    """Write a policy as TorchScript: ``policy(obs) -> actions`` with obs of shape (batch, num_obs).

    Args:
        policy: the actor.
        normalizer: what normalises observations; None for the policy's own.
        path: folder.
        filename: name of the file.
        metadata: texts by key, such as :func:`policy_metadata` gives; they go into the file as ``metadata.json``.

    Returns:
        Path of the file.

    Raises:
        ExportError: the file's actions differ from the policy's.
    """
    target = _target(path, filename)
    model = _with_normalizer(policy.as_jit(), normalizer)
    extra = {} if metadata is None else {JIT_METADATA: json.dumps(dict(metadata), indent=2)}
    with _quiet():
        scripted: Any = torch.jit.script(model)
        _write(target, lambda temporary: scripted.save(str(temporary), _extra_files=extra))
        loaded = torch.jit.load(str(target))
    loaded.reset()
    check_export("TorchScript", policy, normalizer, loaded)
    loaded.reset()
    return target


def export_policy_as_onnx(
    policy: MLPModel,
    path: str | Path,
    normalizer: nn.Module | None = None,
    filename: str = "policy.onnx",
    verbose: bool = False,
    metadata: Mapping[str, str] | None = None,
) -> Path:
    """Write a policy as ONNX with input ``obs`` and output ``actions`` (recurrent: with their states beside them).

    It takes one observation at a time, of shape (1, num_obs).

    Args:
        policy: the actor.
        path: folder.
        normalizer: what normalises observations; None for the policy's own.
        filename: name of the file.
        verbose: whether torch's exporter may report.
        metadata: texts by key, such as :func:`policy_metadata` gives; they become the file's ``metadata_props``.

    Returns:
        Path of the file.

    Raises:
        ExportError: the file's actions differ from the policy's.
    """
    target = _target(path, filename)
    model: Any = _with_normalizer(policy.as_onnx(verbose=verbose), normalizer)
    inputs = model.get_dummy_inputs()
    quiet = contextlib.nullcontext() if verbose else _quiet()

    def write(temporary: Path) -> None:
        with quiet:
            torch.onnx.export(
                model,
                inputs,
                str(temporary),
                input_names=model.input_names,
                output_names=model.output_names,
                opset_version=18,
                external_data=False,
                verbose=verbose,
            )
        _finish_onnx(temporary, metadata or {})

    _write(target, write)
    from onnx.reference import ReferenceEvaluator

    session: Any = ReferenceEvaluator(str(target))
    memory = [value.numpy() for value in inputs[1:]]  # as after a reset; none of a policy without

    def run(obs: torch.Tensor) -> torch.Tensor:
        rows = []
        with np.errstate(over="ignore"):
            for row in obs:
                given = dict(zip(model.input_names, (row[None].numpy(), *memory), strict=True))
                action, *memory[:] = session.run(None, given)
                rows.append(torch.as_tensor(action))
        return torch.cat(rows)

    check_export("ONNX", policy, normalizer, run)
    return target


def _finish_onnx(path: Path, metadata: Mapping[str, str]) -> None:
    """Put metadata into a file, and take out the lines of source code, with their folders on this machine, that torch
    notes at every node."""
    import onnx

    model = onnx.load(str(path))
    graph = model.graph
    for part in (model, graph, *graph.node, *graph.input, *graph.output, *graph.value_info, *graph.initializer):
        part.ClearField("metadata_props")
    onnx.helper.set_model_props(model, dict(metadata))
    onnx.save(model, str(path))


def check_export(
    kind: str,
    policy: MLPModel,
    normalizer: nn.Module | None,
    exported: Callable[[torch.Tensor], torch.Tensor],
    samples: int = 16,
) -> None:
    """Compare an exported policy with the policy on random observations.

    Args:
        kind: of the file, for the message.
        policy: the actor; its memory is not changed.
        normalizer: what normalises observations; None for the policy's own.
        exported: actions of observations, of shape (n, num_obs). One that remembers gets them one after the other.
        samples: how many observations.

    Raises:
        ExportError: they differ by more than :data:`TOLERANCE`.
    """
    generator = torch.Generator().manual_seed(0)
    obs = torch.randn(samples, policy.obs_dim, generator=generator) * 2.0
    steps = list(obs.split(1)) if policy.is_recurrent else [obs]
    own, memory, training = policy.obs_normalizer, policy.get_hidden_state(), policy.training
    device = next(policy.parameters()).device
    own_or_given: Any = own if normalizer is None else copy.deepcopy(normalizer)
    policy.obs_normalizer = own_or_given.to(device)
    policy.eval()
    policy.reset()
    try:
        with torch.no_grad():
            expected = torch.cat([policy(_as_groups(policy, step.to(device))).cpu() for step in steps])
            found = torch.cat([exported(step) for step in steps])
    finally:
        policy.obs_normalizer = own
        policy.reset(hidden_state=memory)
        policy.train(training)
    difference = (expected - found).abs().max().item()
    if not difference <= TOLERANCE * max(1.0, expected.abs().max().item()):
        raise ExportError(f"the exported {kind} policy differs from the policy by {difference:.3g}")


def _as_groups(policy: MLPModel, obs: torch.Tensor) -> TensorDict:
    """Observations of the policy's groups that are together ``obs``."""
    first, *others = policy.obs_groups
    return TensorDict({first: obs, **dict.fromkeys(others, obs[:, :0])}, batch_size=len(obs))


def _with_normalizer(model: nn.Module, normalizer: nn.Module | None) -> nn.Module:
    if normalizer is not None:
        model.obs_normalizer = copy.deepcopy(normalizer)
    return model.to("cpu").eval()


def _target(path: str | Path, filename: str) -> Path:
    folder = Path(path)
    folder.mkdir(parents=True, exist_ok=True)
    return folder / filename


def _write(target: Path, write: Callable[[Path], None]) -> None:
    temporary = temporary_path(target)
    try:
        write(temporary)
        os.replace(temporary, target)
    except OSError as error:
        raise FileError(f"cannot write '{target}': {error.strerror or error}") from error
    finally:
        temporary.unlink(missing_ok=True)


@contextlib.contextmanager
def _quiet():
    """Torch's exporter narrates; keep what it says to ourselves."""
    logger = logging.getLogger("torch.onnx")
    level = logger.level
    logger.setLevel(logging.ERROR)
    try:
        with warnings.catch_warnings(), contextlib.redirect_stdout(io.StringIO()):
            warnings.simplefilter("ignore")
            yield
    finally:
        logger.setLevel(level)
