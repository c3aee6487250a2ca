"""Threads of the learner on the CPU. Their number never changes a result.

Torch's own thread pool is limited to one thread. Its sums and matrix products change in the last bit with the number of
threads. Its spinning barriers also cost more than they save when the physics pool needs the same cores. Work for
several cores is divided into parts of a fixed size instead. Threads take the parts in any order, and results are
combined in the order of the parts. One thread or twenty give the same bits.
"""

from __future__ import annotations

import itertools
import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

import torch

T = TypeVar("T")


def available_cpus() -> int:
    """Number of CPUs this process may run on."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def use_one_torch_thread() -> None:
    """Hold torch's intra-operation pool to one thread in this process."""
    if torch.get_num_threads() != 1:
        torch.set_num_threads(1)


class WorkerPool:
    """Runs the parts of a job on the calling thread and on ``num_threads - 1`` helpers."""

    def __init__(self, num_threads: int | None = None):
        """Start no thread yet; helpers start with the first job that can use them.

        Args:
            num_threads: threads including the caller's; None takes every CPU this process may run on.
        """
        self.num_threads = max(1, num_threads if num_threads is not None else available_cpus())
        self._helpers: ThreadPoolExecutor | None = None

    def map(self, func: Callable[[int], T], count: int) -> list[T]:
        """Call ``func(0) ... func(count - 1)``, each once, in any order and on any thread.

        Returns:
            The results in the order of the parts.

        Raises:
            BaseException: the first error of ``func`` in the order of the threads.
        """
        results: list[T | None] = [None] * count
        numbers = itertools.count()

        def work() -> None:
            # next() on a counter is one atomic step: no part is taken twice
            while (part := next(numbers)) < count:
                results[part] = func(part)

        helpers = min(self.num_threads, count) - 1
        if helpers > 0 and self._helpers is None:
            self._helpers = ThreadPoolExecutor(self.num_threads - 1, thread_name_prefix="worker")
        futures = [self._helpers.submit(work) for _ in range(helpers)] if self._helpers is not None else []
        try:
            work()
        finally:
            for future in futures:
                future.exception()
        for future in futures:
            future.result()
        return results  # type: ignore[return-value]

    def close(self) -> None:
        """Stop the helpers. May be called again."""
        if self._helpers is not None:
            self._helpers.shutdown()
            self._helpers = None


def split_evenly(total: int, size: int) -> list[tuple[int, int]]:
    """Cut ``range(total)`` into spans (first, last) of about ``size``, as even as possible."""
    count = max(1, round(total / size))
    return [(total * k // count, total * (k + 1) // count) for k in range(count)]
