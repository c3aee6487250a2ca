"""Policies that ship: the actor of a run's checkpoint alone, as a small file, as ONNX, and with a card.

``policy.pt`` is a checkpoint that :meth:`LiftLabRunner.load_policy` reads: the policy to act with (the averaged one
where the run's checkpoint holds one) and the curriculum's counters. ``policy.onnx`` is the same policy for other
programs, and ``card.json`` says where it comes from and what it can do.
"""

from __future__ import annotations

import json
import tempfile
from pathlib import Path
from typing import Any

import torch

from lift_lab.utils.errors import ConfigError, FileError
from lift_lab_rl.files import canonical, save_torch, write_atomically
from lift_lab_rl.run_params import read_params

from .checkpoint_file import read_checkpoint
from .ema import AVERAGE, LAST, acting_policy
from .exporter import export_policy_as_onnx
from .runner import LiftLabRunner

MAX_BYTES = 300_000
"""Most that a shipped file may take: the repository holds them."""

_MEASURES = (
    *("episodes", "seed", "success_rate", "success_rate_interval", "mean_reward", "std_reward"),
    *("time_to_success_s", "mean_episode_length", "terminations", "logs"),
)
"""What a card takes from the results of ``lift-lab evaluate``."""


def write_pretrained(
    runner: LiftLabRunner, checkpoint: str | Path, folder: str | Path, task: str, results: dict[str, Any] | None = None
) -> list[Path]:
    """Write ``policy.pt``, ``policy.onnx`` and ``card.json``.

    Args:
        runner: of an environment of the task; its policy is replaced by the shipped one.
        checkpoint: ``model_N.pt`` of a run.
        folder: where to; made if need be.
        task: id of the task, for the card.
        results: what ``lift-lab evaluate --json`` wrote about this checkpoint; None leaves the card without.

    Returns:
        The files.

    Raises:
        FileError: the checkpoint cannot be read.
        ConfigError: it holds no policy or does not fit the task, the results are of something else, or a file grows
            too large.
        ExportError: the ONNX file does not act as the policy does.
    """
    checkpoint, folder = Path(checkpoint), Path(folder)
    content = read_checkpoint(checkpoint)
    actor = acting_policy(content, checkpoint)
    card = _card(checkpoint, content, task, results)
    counters = (content.get("infos") or {}).get("env_state", {})
    small = {"iter": content["iter"], LAST: actor, "infos": {"env_state": counters}}
    with tempfile.TemporaryDirectory() as temporary:
        path = Path(temporary) / "policy.pt"
        save_torch(path, canonical(small))
        _check_same_actions(runner, checkpoint, path)
        metadata = runner.policy_metadata(checkpoint)
        onnx = export_policy_as_onnx(runner.alg.get_policy(), temporary, metadata=metadata)
        files = {"policy.pt": path.read_bytes(), "policy.onnx": onnx.read_bytes()}
    for name, data in files.items():
        if len(data) > MAX_BYTES:
            raise ConfigError(f"{name} takes {len(data)} bytes; a policy that ships may take {MAX_BYTES}")
    files["card.json"] = (json.dumps(card, indent=2) + "\n").encode()
    for name, data in files.items():
        write_atomically(folder / name, data)
    return [folder / name for name in files]


def _check_same_actions(runner: LiftLabRunner, checkpoint: Path, small: Path) -> None:
    """Both files must act alike on the environment's observations; leaves the small one's policy loaded."""
    obs = runner.env.get_observations().to(runner.device)
    actions = []
    for path in (checkpoint, small):
        runner.load_policy(str(path))
        with torch.inference_mode():
            actions.append(runner.get_inference_policy(device=runner.device)(obs).clone())
    if not torch.equal(*actions):
        raise ConfigError(f"the policy written from '{checkpoint}' does not act as it does")


def _card(checkpoint: Path, content: dict[str, Any], task: str, results: dict[str, Any] | None) -> dict[str, Any]:
    card: dict[str, Any] = {
        "task": task,
        "iterations": content["iter"],
        "averaged": AVERAGE in content,
        "training_seed": read_params(checkpoint.parent, "agent").get("seed"),
    }
    if results is None:
        return card
    wrong = [key for key in ("task", "checkpoint") if not isinstance(results, dict) or key not in results]
    if wrong:
        raise FileError(f"these are no results of lift-lab evaluate: no '{wrong[0]}'")
    if results["task"].removesuffix("-Play") != task or Path(results["checkpoint"]).resolve() != checkpoint.resolve():
        raise ConfigError(f"the results are of '{results['task']}', '{results['checkpoint']}', not of '{checkpoint}'")
    if results.get("perturb"):
        raise ConfigError(f"the results are of a changed task ({', '.join(results['perturb'])})")
    card["evaluation"] = {name: results[name] for name in _MEASURES if name in results}
    return card
