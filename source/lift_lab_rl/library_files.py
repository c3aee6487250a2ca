"""Checkpoints of the learning libraries, read without running code that is in them.

A pickle can run any code while it is read, and skrl and Stable-Baselines3 read their files as pickles. The functions
here read tensors and plain values only. They distinguish the libraries' files, so that the scripts of one library
refuse a file of another.
"""

from __future__ import annotations

import io
import warnings
import zipfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import torch
from torch.serialization import get_unsafe_globals_in_checkpoint

from lift_lab.utils.errors import ConfigError, FileError

from .digest import damage

RSL_RL, SKRL, SB3 = "rsl_rl", "skrl", "sb3"
"""The libraries, by the names that ``--library`` takes."""

_NAMES = {RSL_RL: "rsl_rl", SKRL: "skrl", SB3: "Stable-Baselines3"}


def read_states(path: str | Path, trust: bool = False, map_location: Any = "cpu") -> Any:
    """Read a torch file of tensors and plain values.

    Args:
        path: the file.
        trust: whether to read other objects, too, which runs code that is in the file.
        map_location: device of the tensors.

    Returns:
        What the file holds.

    Raises:
        FileError: there is no such file, it is damaged, it is no torch file, or it holds other objects and is not
            trusted.
    """
    return parse_states(read_whole(path), str(path), trust, map_location)


def read_whole(path: str | Path) -> bytes:
    """Bytes of a file.

    Raises:
        FileError: there is no such file, it cannot be read, or it is a damaged archive.
    """
    try:
        data = Path(path).read_bytes()
    except FileNotFoundError as error:
        raise FileError(f"no file '{path}'") from error
    except OSError as error:
        raise FileError(f"cannot read '{path}': {error.strerror or error}") from error
    problem = damage(data)
    if problem is not None:
        raise FileError(f"cannot read '{path}': {problem}")
    return data


def parse_states(data: bytes, name: str, trust: bool = False, map_location: Any = "cpu") -> Any:
    """Return the same as :func:`read_states`, from the bytes of a file.

    Args:
        data: the bytes.
        name: what to call the file in errors.
        trust: as there.
        map_location: as there.

    Raises:
        FileError: as there, and where a number is not finite.
    """
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of other kinds of files, which end in an error anyway
            states = torch.load(io.BytesIO(data), map_location=map_location, weights_only=True)
    except Exception as error:  # of a file that is something else, anything can be wrong
        objects = _objects(data)
        if objects is None:
            raise FileError(f"cannot read '{name}': it is no checkpoint, or not a whole one") from error
        if not trust:
            raise FileError(refusal(name, objects)) from error
        try:
            states = torch.load(io.BytesIO(data), map_location=map_location, weights_only=False)
        except Exception as problem:  # the file's own code runs here
            reason = " ".join(f"{type(problem).__name__}: {problem}".split())[:200]
            raise FileError(f"cannot read '{name}': {reason}") from problem
    for where, tensor in _tensors(states):
        if tensor.is_floating_point() and not bool(torch.isfinite(tensor).all()):
            raise FileError(f"'{name}' holds numbers that are not finite, in '{where}': take another checkpoint")
    return states


def refusal(name: str, objects: str = "") -> str:
    """One line that says why a file is not read without ``--trust``."""
    which = f" ({objects})" if objects else ""
    return (
        f"'{name}' holds pickled Python objects{which}: reading it runs code that is in the file; add --trust if you "
        "trust its author"
    )


def read_skrl(path: str | Path, trust: bool = False, map_location: Any = "cpu") -> dict[str, Any]:
    """States of the modules of an agent that skrl's ``agent.save`` wrote, by name.

    Args:
        path: the file.
        trust: as in :func:`read_states`.
        map_location: as there.

    Raises:
        FileError: as there.
        ConfigError: the file is no agent of skrl; says of which library it is.
    """
    refuse_other_library(path, SKRL)
    states = read_states(path, trust, map_location)
    refuse_other_library(path, SKRL, states)
    if _library_of(states) != SKRL:
        raise ConfigError(f"'{path}' is no agent of skrl: take an agent_N.pt")
    return states


def read_sb3(path: str | Path, trust: bool = False, map_location: Any = "cpu") -> dict[str, Any]:
    """States of the networks and the optimiser of a model that Stable-Baselines3's ``agent.save`` wrote, by name.

    The entry ``data`` of such a file holds pickled Python objects. It is for Stable-Baselines3's ``PPO.load``, which
    runs code that is in it; here it is never read.

    Args:
        path: the file.
        trust: as in :func:`read_states`.
        map_location: as there.

    Raises:
        FileError: as there.
        ConfigError: the file is no model of Stable-Baselines3; says of which library it is.
    """
    data = read_whole(path)
    if not is_sb3_model(path):
        try:
            states = parse_states(data, str(path))
        except FileError:
            states = None
        refuse_other_library(path, SB3, states)
        raise ConfigError(f"'{path}' is no model of Stable-Baselines3: take a model*.zip")
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        parts = [name for name in archive.namelist() if name.endswith(".pth") and name != "pytorch_variables.pth"]
        return {
            name.removesuffix(".pth"): parse_states(archive.read(name), f"{path}: {name}", trust, map_location)
            for name in parts
        }


def refuse_other_library(path: str | Path, library: str, states: Any = None) -> None:
    """Check that a file is not one of another library.

    Args:
        path: the file.
        library: library whose scripts read it.
        states: contents of the file, where known.

    Raises:
        ConfigError: it is of another library; says which scripts read it.
    """
    found = SB3 if is_sb3_model(path) else _library_of(states)
    if found is not None and found != library:
        raise ConfigError(
            f"'{path}' is a checkpoint of {_NAMES[found]}, not of {_NAMES[library]}: use lift-lab train or play with "
            f"--library {found}"
        )


def is_sb3_model(path: str | Path) -> bool:
    """Whether a file is a model of Stable-Baselines3; nothing in it is read but its table of contents."""
    try:
        with zipfile.ZipFile(path) as archive:
            return {"data", "policy.pth"} <= set(archive.namelist())
    except Exception:  # no zip archive, or a damaged one
        return False


def _library_of(states: Any) -> str | None:
    if not isinstance(states, dict):
        return None
    if "actor_state_dict" in states or "model_state_dict" in states or {"env", "rng"} <= states.keys():
        return RSL_RL
    if "policy" in states and "optimizer" in states:
        return SKRL
    return None


def _objects(data: bytes) -> str | None:
    """Names of the objects in a file besides tensors and plain values; None if there are none that can be told."""
    if data.startswith(b"\x80"):  # a pickle, also torch's older form of a file
        return ""
    try:
        names = get_unsafe_globals_in_checkpoint(io.BytesIO(data))
    except Exception:  # of a file that is something else, anything can be wrong
        return None
    return ", ".join(names[:3]) if names else None


def _tensors(value: Any, where: str = "") -> Iterator[tuple[str, torch.Tensor]]:
    if isinstance(value, torch.Tensor):
        yield where, value
    elif isinstance(value, dict):
        for key, entry in value.items():
            yield from _tensors(entry, f"{where}.{key}" if where else str(key))
    elif isinstance(value, (list, tuple)):
        for number, entry in enumerate(value):
            yield from _tensors(entry, f"{where}[{number}]")
