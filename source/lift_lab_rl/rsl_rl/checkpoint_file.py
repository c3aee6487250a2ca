"""Read ``model_N.pt`` and check it: that it is a checkpoint, that its numbers are finite, that it fits the networks.

Everything is checked before anything is loaded, so a checkpoint that is refused changes nothing.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import torch
from torch import nn

from lift_lab.utils.errors import ConfigError, quote
from lift_lab_rl.files import load_torch
from lift_lab_rl.library_files import RSL_RL, refuse_other_library

_NETWORKS = ("actor_state_dict", "critic_state_dict", "rnd_state_dict", "actor_average_state_dict")
"""Entries of a checkpoint that hold the parameters of a network."""

_OPTIMIZERS = ("optimizer_state_dict", "rnd_optimizer_state_dict")
"""Entries of a checkpoint that hold the state of an optimizer."""


class _WrongContent(Exception):
    """What is wrong with a checkpoint, without the name of its file."""


def read_checkpoint(path: str | Path, map_location: str | None = "cpu") -> dict[str, Any]:
    """Read a checkpoint and check its contents.

    Args:
        path: ``model_N.pt``.
        map_location: device of the tensors.

    Returns:
        The entries: ``iter``, ``infos``, and the states of networks and optimizers.

    Raises:
        FileError: there is no such file, it is damaged, or it is no torch file.
        ConfigError: it is no checkpoint of a training, it is one of another library, an entry is of the wrong type, or
            a number is not finite.
    """
    refuse_other_library(path, RSL_RL)
    content = load_torch(path, map_location)
    refuse_other_library(path, RSL_RL, content)
    if not isinstance(content, dict) or "iter" not in content:
        raise ConfigError(f"'{path}' is no checkpoint of a training: it {_described(content)} (take a model_*.pt)")
    try:
        _check_content(content)
    except _WrongContent as error:
        raise ConfigError(f"'{path}' is no valid checkpoint: {error}") from error
    return content


def check_fit(alg: Any, content: dict[str, Any], parts: Mapping[str, bool] | None, strict: bool = True) -> None:
    """Check that a checkpoint is of an algorithm's networks and optimizers.

    Args:
        alg: rsl_rl's PPO.
        content: what :func:`read_checkpoint` returned.
        parts: parts to be loaded, as :meth:`LiftLabRunner.load` takes them; None for all.
        strict: whether parameters may neither be missing nor be left over.

    Raises:
        ValueError: it is not; names the first parameter that differs.
    """
    networks: dict[str, tuple[str, nn.Module]] = {
        "actor": ("actor_state_dict", alg.actor),
        "critic": ("critic_state_dict", alg.critic),
    }
    optimizers = {"optimizer": ("optimizer_state_dict", alg.optimizer)}
    if alg.rnd:
        networks["rnd"] = ("rnd_state_dict", alg.rnd)
        optimizers["rnd"] = ("rnd_optimizer_state_dict", alg.rnd.optimizer)
    try:
        for part, (name, network) in networks.items():
            if parts is None or parts.get(part):
                _check_network(name, _entry(content, name), network.state_dict(), strict)
                if part == "actor" and "actor_average_state_dict" in content:
                    average = content["actor_average_state_dict"]
                    _check_network("actor_average_state_dict", average, network.state_dict(), strict)
        for part, (name, optimizer) in optimizers.items():
            if parts is None or parts.get(part):
                _check_optimizer(name, _entry(content, name), optimizer)
    except _WrongContent as error:
        raise ValueError(str(error)) from error


# -- form


def _described(content: Any) -> str:
    if not isinstance(content, dict):
        return f"holds {_kind(content)}"
    return f"has no entry 'iter', it holds {quote([str(key) for key in content][:8])}" if content else "is empty"


def _kind(value: Any) -> str:
    """The type of a value, for a message."""
    if isinstance(value, torch.Tensor):
        return f"a tensor of shape {tuple(value.shape)}"
    return "None" if value is None else f"a value of type {type(value).__name__}"


def _check_content(content: dict[Any, Any]) -> None:
    """Raise _WrongContent for the first entry that is of the wrong type or not finite."""
    if not _is_count(content["iter"]):
        raise _WrongContent(f"'iter' has to be a number of iterations, it is {_shown(content['iter'])}")
    begun = content.get("anneal_from", 0)
    if not _is_count(begun) or begun > content["iter"]:
        raise _WrongContent(f"'anneal_from' has to be an iteration that is over, it is {_shown(begun)}")
    for name in _NETWORKS:
        if name in content:
            _check_tensors(name, content[name])
    for name in _OPTIMIZERS:
        if name in content:
            _check_optimizer_form(name, content[name])
    infos = _mapping("infos", content.get("infos") or {})
    _check_counters("infos.env_state", _mapping("infos.env_state", infos.get("env_state") or {}))
    _mapping("infos.solved", infos.get("solved") or {})
    rnd = _mapping("infos.rnd", infos.get("rnd") or {})
    for name in rnd:
        _check_number(f"infos.rnd.{name}", rnd[name])
        if name not in ("update_counter", "weight"):
            raise _WrongContent(f"'infos.rnd' has an unknown entry '{name}'")


def _check_counters(path: str, counters: dict[str, Any]) -> None:
    """What :func:`lift_lab_rl.counters.counters` returns."""
    steps = counters.get("common_step_counter", 0)
    if not _is_count(steps):
        raise _WrongContent(f"'{path}.common_step_counter' has to be a number of steps, it is {_shown(steps)}")
    for name in ("reward_weights", "configured_weights"):
        for term, weight in _mapping(f"{path}.{name}", counters.get(name, {})).items():
            _check_number(f"{path}.{name}.{term}", weight)
    if "reward_weights" in counters and "configured_weights" not in counters:
        raise _WrongContent(f"'{path}' has 'reward_weights' but no 'configured_weights'")


def _check_tensors(path: str, state: Any) -> None:
    """The state of a network: names of parameters and finite tensors."""
    for name, value in _mapping(path, state).items():
        if not isinstance(value, torch.Tensor) or value.layout != torch.strided:
            raise _WrongContent(f"'{path}.{name}' has to be a tensor, it is {_kind(value)}")
        _check_finite(f"{path}.{name}", value)


def _check_optimizer_form(path: str, state: Any) -> None:
    """The state of an optimizer as torch writes it."""
    content = _mapping(path, state, str)
    groups = content.get("param_groups")
    if not isinstance(groups, list) or not all(isinstance(group, dict) for group in groups):
        raise _WrongContent(f"'{path}.param_groups' has to be a list of dictionaries, it is {_kind(groups)}")
    for number, values in _mapping(f"{path}.state", content.get("state"), int).items():
        for name, value in _mapping(f"{path}.state.{number}", values).items():
            if isinstance(value, torch.Tensor):
                _check_finite(f"{path}.state.{number}.{name}", value)
            elif value is not None:
                _check_number(f"{path}.state.{number}.{name}", value)
    for number, group in enumerate(groups):
        for name, value in group.items():
            for entry in value if isinstance(value, (list, tuple)) else (value,):
                if isinstance(entry, torch.Tensor):
                    _check_finite(f"{path}.param_groups.{number}.{name}", entry)
                elif isinstance(entry, float) and not math.isfinite(entry):
                    raise _WrongContent(f"'{path}.param_groups.{number}.{name}' is {entry}, not a finite number")


def _mapping(path: str, value: Any, keys: type = str) -> dict[Any, Any]:
    if not isinstance(value, dict):
        raise _WrongContent(f"'{path}' has to be a dictionary, it is {_kind(value)}")
    wrong = [key for key in value if type(key) is not keys]
    if wrong:
        raise _WrongContent(f"'{path}' has the key {wrong[0]!r}, which is no {keys.__name__}")
    return value


def _check_number(path: str, value: Any) -> None:
    if not isinstance(value, (int, float)) or not math.isfinite(value):
        raise _WrongContent(f"'{path}' has to be a finite number, it is {_shown(value)}")


def _check_finite(path: str, value: torch.Tensor) -> None:
    if value.is_floating_point() and not bool(torch.isfinite(value).all()):
        raise _WrongContent(f"'{path}' holds numbers that are not finite (NaN or infinity)")


def _is_count(value: Any) -> bool:
    return type(value) is int and value >= 0


def _shown(value: Any) -> str:
    return repr(value) if isinstance(value, (int, float, str)) and len(repr(value)) < 40 else _kind(value)


# -- fit


def _entry(content: dict[str, Any], name: str) -> Any:
    if name not in content:
        raise _WrongContent(f"it has no '{name}'")
    return content[name]


def _check_network(path: str, saved: dict[str, torch.Tensor], live: dict[str, torch.Tensor], strict: bool) -> None:
    missing = [name for name in live if name not in saved]
    surplus = [name for name in saved if name not in live]
    if strict and (missing or surplus):
        names = f"has no '{missing[0]}'" if missing else f"has '{surplus[0]}', which the network does not have"
        raise _WrongContent(f"'{path}' {names}")
    for name in live.keys() & saved.keys():
        ours, theirs = live[name], saved[name]
        if ours.shape != theirs.shape:
            shapes = f"shape {tuple(theirs.shape)}, the network needs {tuple(ours.shape)}"
            raise _WrongContent(f"'{path}.{name}' has {shapes}")
        if ours.dtype != theirs.dtype:
            raise _WrongContent(f"'{path}.{name}' is of type {theirs.dtype}, the network needs {ours.dtype}")


def _check_optimizer(path: str, saved: dict[str, Any], optimizer: torch.optim.Optimizer) -> None:
    """The state has to be of an optimizer of this class and of these parameters."""
    groups, live = saved["param_groups"], optimizer.param_groups
    sizes = [[len(group.get("params", ())) for group in side] for side in (groups, live)]
    if sizes[0] != sizes[1]:
        raise _WrongContent(f"'{path}' is of {sum(sizes[0])} parameters, the networks have {sum(sizes[1])}")
    numbers: list[Any] = []
    for number, (theirs, ours) in enumerate(zip(groups, live, strict=True)):
        numbers += theirs["params"]
        for name in ("lr", "betas", "eps", "weight_decay", "momentum", "alpha"):
            if name in ours and not _is_like(theirs.get(name), ours[name]):
                found = _shown(theirs[name]) if name in theirs else "missing"
                raise _WrongContent(f"'{path}.param_groups.{number}.{name}' is {found}")
    params = [param for group in live for param in group["params"]]
    state = saved["state"]
    if len(set(map(repr, numbers))) != len(params) or not state.keys() <= set(map(_plain_int, numbers)):
        raise _WrongContent(f"'{path}' numbers its parameters in another way")
    needed = (
        {"step", "exp_avg", "exp_avg_sq"} if isinstance(optimizer, (torch.optim.Adam, torch.optim.AdamW)) else set()
    )
    for number, param in zip(numbers, params, strict=True):
        entries = state.get(number, {})
        missing = sorted(needed - entries.keys()) if entries else []
        if missing:
            raise _WrongContent(f"'{path}.state.{number}' has no '{missing[0]}'")
        for name, value in entries.items():
            wanted = torch.Size() if name == "step" else param.shape
            if isinstance(value, torch.Tensor) and value.shape != wanted:
                shapes = f"shape {tuple(value.shape)}, its parameter needs {tuple(wanted)}"
                raise _WrongContent(f"'{path}.state.{number}.{name}' has {shapes}")


def _plain_int(value: Any) -> int | None:
    return value if type(value) is int else None


def _is_like(value: Any, example: Any) -> bool:
    """Whether a setting of an optimizer is of the type of another: a number, or as many numbers."""
    if isinstance(example, (tuple, list)):
        return isinstance(value, (tuple, list)) and len(value) == len(example) and all(map(_is_like, value, example))
    if isinstance(value, torch.Tensor):
        return value.numel() == 1
    return isinstance(value, (int, float)) and not isinstance(value, bool)
