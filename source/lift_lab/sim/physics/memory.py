"""Whether a number of environments fits into memory, asked before anything is allocated.

The estimates are lower bounds, so only sizes that cannot run are refused. Measured on the shipped tasks, an environment
takes 1.1 times the estimate on ``native`` and 1.3 to 1.5 times on ``warp``.
"""

from __future__ import annotations

import contextlib
import os
from pathlib import Path

import mujoco
import torch

from lift_lab.utils.errors import ConfigError

LEAST_BYTES = 1024
"""Bytes that an environment of any scene takes."""

_CGROUP = Path("/sys/fs/cgroup")


def native_bytes(model: mujoco.MjModel) -> int:
    """Bytes of an environment on the native engine, which keeps less than one ``mjData`` of it."""
    return LEAST_BYTES // 2 + int(0.4 * mujoco.MjData(model).nbuffer)


def warp_bytes(model: mujoco.MjModel, nconmax: int, njmax: int) -> int:
    """Bytes of an environment on the warp engine: float32 state, contacts, and constraint rows with their Jacobian."""
    return mujoco.MjData(model).nbuffer // 2 + 250 * nconmax + 4 * njmax * (model.nv + 10)


def check_fits(what: str, count: int, bytes_each: int, device: str | torch.device) -> None:
    """Refuse what cannot fit.

    Args:
        what: name of the setting, for the message.
        count: its value.
        bytes_each: bytes of memory for each.
        device: where.

    Raises:
        ConfigError: it needs more than the free memory; says how many fit.
    """
    free = free_bytes(device)
    if free is not None and count * bytes_each > free:
        raise ConfigError(
            f"{what} is {count}: that needs at least {count * bytes_each / 2**30:.3g} GiB of memory, but {device} has "
            f"{free / 2**30:.3g} GiB free; at most {free // bytes_each} fit"
        )


def free_bytes(device: str | torch.device) -> int | None:
    """Free memory of a device, within the limit of this process's container; None where the system does not tell."""
    device = torch.device(device)
    if device.type == "cuda":
        return torch.cuda.mem_get_info(device)[0] if torch.cuda.is_available() else None
    found = []
    with contextlib.suppress(OSError, ValueError, StopIteration):
        lines = Path("/proc/meminfo").read_text().splitlines()
        found.append(1024 * int(next(line for line in lines if line.startswith("MemAvailable")).split()[1]))
    with contextlib.suppress(OSError, ValueError):  # "max" is no number
        limit = int((_CGROUP / "memory.max").read_text())
        found.append(limit - int((_CGROUP / "memory.current").read_text()))
    if not found:
        with contextlib.suppress(OSError, ValueError, AttributeError):
            found.append(os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE"))
    return max(0, min(found)) if found else None
