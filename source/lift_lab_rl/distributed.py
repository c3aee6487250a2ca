"""Training with several processes: their ranks, the values they share, and the end of one of them.

torchrun starts the processes and gives each its rank in environment variables. Every process has its own environments
and seed; they share the gradients. Settings and signals to stop go over gloo on the CPU, tensors on a GPU over nccl.
Without a group every function here does nothing and costs nothing.
"""

from __future__ import annotations

import contextlib
import dataclasses
import hashlib
import os
from collections.abc import Iterable, Iterator
from datetime import timedelta
from typing import Any

import torch
import torch.distributed as dist

from lift_lab.utils.errors import ConfigError, LiftLabError

from .threads import available_cpus

TIMEOUT_S = 600.0
"""Longest wait for another process, in s. One that ended is noticed at once; this is for one that hangs."""

_VARIABLES = ("RANK", "LOCAL_RANK", "WORLD_SIZE", "LOCAL_WORLD_SIZE", "MASTER_ADDR", "MASTER_PORT")
_LAUNCH = "torchrun --nproc_per_node=2 -m lift_lab_cli train --distributed ..."


class PeerError(LiftLabError, RuntimeError):
    """Another process of the group ended or does not answer."""


@dataclasses.dataclass(frozen=True)
class Place:
    """A process's place in its group."""

    rank: int = 0
    """Number among all processes; 0 writes logs and checkpoints."""
    local_rank: int = 0
    """Number on this machine."""
    world_size: int = 1
    """Processes in all."""
    local_world_size: int = 1
    """Processes on this machine."""

    @property
    def is_main(self) -> bool:
        """Whether this process writes logs and checkpoints."""
        return self.rank == 0

    @property
    def is_distributed(self) -> bool:
        """Whether there are others."""
        return self.world_size > 1

    def multi_gpu_cfg(self) -> dict[str, int] | None:
        """Settings of the other processes for rsl_rl's algorithms; None without others."""
        if not self.is_distributed:
            return None
        return {"global_rank": self.rank, "local_rank": self.local_rank, "world_size": self.world_size}

    def device(self, kind: str) -> str:
        """The device of this process.

        Args:
            kind: "cpu", "cuda" or "cuda:N"; the number is not used where there are other processes.

        Raises:
            ConfigError: this machine has fewer GPUs than processes.
        """
        if not self.is_distributed or not kind.startswith("cuda"):
            return kind
        count = torch.cuda.device_count()
        if count < self.local_world_size:
            raise ConfigError(
                f"{self.local_world_size} processes on this machine but {count} GPUs: "
                f"start torchrun with --nproc_per_node={max(1, count)}, or give --device cpu"
            )
        return f"cuda:{self.local_rank}"

    def num_threads(self) -> int:
        """This process's share of the CPUs, at least one."""
        return max(1, available_cpus() // self.local_world_size)


def place(distributed: bool) -> Place:
    """Return this process's place, as torchrun gives it.

    Args:
        distributed: whether the user asked for several processes.

    Raises:
        ConfigError: they were asked for and torchrun did not start this process, or the other way round.
    """
    missing = [name for name in _VARIABLES if name not in os.environ]
    if not distributed:
        if not missing and int(os.environ["WORLD_SIZE"]) > 1 and "TORCHELASTIC_RUN_ID" in os.environ:
            raise ConfigError(f"torchrun started {os.environ['WORLD_SIZE']} processes: add --distributed")
        return Place()
    if missing:
        raise ConfigError(f"--distributed needs torchrun, which sets {', '.join(missing)}: {_LAUNCH}")
    names = ("RANK", "LOCAL_RANK", "WORLD_SIZE", "LOCAL_WORLD_SIZE")
    return Place(*(int(os.environ[name]) for name in names))


@contextlib.contextmanager
def group(where: Place, device: str, timeout_s: float = TIMEOUT_S) -> Iterator[None]:
    """Be in the group of all processes; leave it when the body ends without an error.

    Args:
        where: this process's place; alone there is no group.
        device: device of the learner.
        timeout_s: longest wait for another process.

    Raises:
        PeerError: the others did not come.
    """
    if not where.is_distributed:
        yield
        return
    on_gpu = torch.device(device).type == "cuda"
    if on_gpu:
        torch.cuda.set_device(torch.device(device))
    with answers():
        dist.init_process_group("cpu:gloo,cuda:nccl" if on_gpu else "gloo", timeout=timedelta(seconds=timeout_s))
    yield
    # after an error the others may be gone: the process ends, and its connections with it
    with answers():
        stop_number(None)
    dist.destroy_process_group()


def is_active() -> bool:
    """Whether this process is in a group."""
    return dist.is_available() and dist.is_initialized()


@contextlib.contextmanager
def answers() -> Iterator[None]:
    """Turn the failure of a collective call into one line.

    Raises:
        PeerError: another process ended or does not answer.
    """
    try:
        yield
    except RuntimeError as error:
        if isinstance(error, LiftLabError):
            raise
        rank = dist.get_rank() if is_active() else os.environ.get("RANK", "?")
        reason = " ".join(str(error).split())[:160]
        raise PeerError(f"process {rank} lost another process of this training ({reason})") from error


def from_main(value: Any) -> Any:
    """The main process's ``value`` (plain, picklable), on every process."""
    if not is_active():
        return value
    box = [value]
    with answers():
        dist.broadcast_object_list(box, src=0, device=torch.device("cpu"))
    return box[0]


def average_(tensors: Iterable[torch.Tensor]) -> None:
    """Replace tensors by their means over all processes, in one call: the same bits everywhere.

    Args:
        tensors: of one dtype and device, the same shapes on every process.
    """
    if not is_active():
        return
    parts = list(tensors)
    packed = torch.cat([part.reshape(-1) for part in parts])
    with answers():
        dist.all_reduce(packed)
    packed /= dist.get_world_size()
    sizes = [part.numel() for part in parts]
    values = [new.view_as(old) for new, old in zip(packed.split(sizes), parts, strict=True)]
    torch._foreach_copy_(parts, values)  # pyright: ignore[reportPrivateImportUsage]


def standardise(values: torch.Tensor) -> torch.Tensor:
    """``values`` less their mean and over their standard deviation, both of all processes together.

    Args:
        values: the same shape on every process.
    """
    mean = values.mean()
    average_([mean])
    deviations = values - mean
    variance = deviations.square().mean()
    average_([variance])
    count = values.numel() * (dist.get_world_size() if is_active() else 1)
    return deviations / ((variance * (count / (count - 1))).sqrt() + 1e-8)


def copy_from_main(tensors: Iterable[torch.Tensor]) -> None:
    """Overwrite tensors by those of the main process."""
    if is_active():
        with answers():
            for tensor in tensors:
                dist.broadcast(tensor, src=0)


def stop_number(number: int | None) -> int | None:
    """The greatest of all processes' signal numbers, None when no process has one; waits for all of them."""
    if not is_active():
        return number
    box = torch.tensor([number or 0])
    with answers():
        dist.all_reduce(box, op=dist.ReduceOp.MAX)
    return int(box.item()) or None


def first_problem(problem: str | None) -> str | None:
    """The first of all processes' problems, None when no process has one; waits for all of them."""
    if not is_active():
        return problem
    everyone: list[str | None] = [None] * dist.get_world_size()
    with answers():
        dist.all_gather_object(everyone, problem)
    return next((text for text in everyone if text is not None), None)


def check_equal(tensors: Iterable[torch.Tensor], what: str) -> None:
    """Compare tensors between the processes, bit by bit; waits for all of them.

    Args:
        tensors: the same everywhere, if all is well.
        what: names them in the message.

    Raises:
        LiftLabError: a process has others.
    """
    if not is_active():
        return
    digest = hashlib.sha256()
    for tensor in tensors:
        digest.update(tensor.detach().cpu().contiguous().numpy().tobytes())
    mine = torch.frombuffer(bytearray(digest.digest()), dtype=torch.uint8)
    everyone = [torch.empty_like(mine) for _ in range(dist.get_world_size())]
    with answers():
        dist.all_gather(everyone, mine)
    other = [rank for rank, theirs in enumerate(everyone) if not torch.equal(theirs, everyone[0])]
    if other:
        raise LiftLabError(
            f"{what} of process {other[0]} is not that of process 0: all machines of a group must be of one kind"
        )
