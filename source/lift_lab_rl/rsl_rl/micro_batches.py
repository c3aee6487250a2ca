"""Networks over micro-batches of fixed size that threads share (gradient accumulation).

The gradient of a minibatch is the sum of the gradients of its micro-batches. Threads take micro-batches in any order;
sums are added in the order of the micro-batches. So the number of threads never changes a result.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import torch
from torch import nn

from lift_lab_rl import distributed
from lift_lab_rl.threads import WorkerPool, split_evenly

from .mlp_gradients import BLOCK_ROWS, DEVICE_BLOCK_ROWS, GradientSums, MlpPerThread

ROWS = 1536
"""Samples in a micro-batch on a CPU. Another device takes a minibatch at once."""

ACTING_ROWS = 256
"""Environments in a micro-batch when the policy acts, on a CPU."""

Loss = Callable[[torch.Tensor, slice], tuple[torch.Tensor, torch.Tensor]]
"""Function ``loss(outputs, rows)`` of a network's outputs for some rows of the minibatch. It returns the derivative of
the loss by these outputs, in their shape, and numbers to sum over the minibatch, shape (count,)."""


class MicroBatches:
    """Runs multi-layer perceptrons over micro-batches.

    Attributes:
        rows: samples in a micro-batch.
        acting_rows: environments in a micro-batch when the policy acts.
        block_rows: samples that go through a network at once.
    """

    def __init__(self, networks: Sequence[nn.Sequential], device: str, num_threads: int | None = None):
        """Start no thread yet.

        Args:
            networks: multi-layer perceptrons.
            device: device of the networks.
            num_threads: threads on the CPU; None takes every CPU this process may run on.
        """
        on_cpu = torch.device(device).type == "cpu"
        self._pool = WorkerPool(num_threads if on_cpu else 1)
        self.rows, self.acting_rows = (ROWS, ACTING_ROWS) if on_cpu else (1 << 40, 1 << 40)
        self.block_rows = BLOCK_ROWS if on_cpu else DEVICE_BLOCK_ROWS
        self._networks = list(networks)
        self._per_thread = [MlpPerThread(network) for network in networks]
        self._sums: list[list[GradientSums]] = [[] for _ in networks]

    def outputs(self, network: int, inputs: torch.Tensor, normalise: nn.Module, rows: int) -> torch.Tensor:
        """Outputs of a network for many samples, without gradients.

        Args:
            network: number of the network.
            inputs: shape (samples, inputs).
            normalise: maps a block of inputs to the network's inputs.
            rows: samples in a micro-batch.

        Returns:
            Shape (samples, outputs).
        """
        bounds = split_evenly(len(inputs), rows)

        def job(number: int) -> torch.Tensor:
            with torch.no_grad():
                mlp = self._per_thread[network].here()
                return torch.cat([mlp.forward(normalise(inputs[block])) for block in self._blocks(bounds[number])])

        return torch.cat(self._pool.map(job, len(bounds)))

    def gradients(
        self,
        inputs: Sequence[torch.Tensor],
        losses: Sequence[Loss],
        counts: Sequence[int],
        together: Sequence[int] = (1, 1),
    ) -> list[GradientSums]:
        """Gradients of a minibatch, averaged over its samples and over all processes.

        Args:
            inputs: inputs of each network, shape (samples, inputs).
            losses: the loss of each network; called by several threads.
            counts: how many numbers each loss sums.
            together: rows of each network's inputs that are never cut apart.

        Returns:
            Of each network; overwritten by the next call.
        """
        bounds = [_split(len(rows), self.rows, unit) for rows, unit in zip(inputs, together, strict=True)]
        for network, parts, sums, count in zip(self._networks, bounds, self._sums, counts, strict=True):
            while len(sums) < len(parts):
                sums.append(GradientSums(list(network.parameters()), count))
        jobs = sorted((part, network) for network, parts in enumerate(bounds) for part in range(len(parts)))

        def job(number: int) -> None:
            part, network = jobs[number]
            blocks = self._blocks(bounds[network][part], together[network])
            self._accumulate(network, inputs[network], blocks, losses[network], self._sums[network][part])

        self._pool.map(job, len(jobs))
        totals = []
        for rows, parts, sums in zip(inputs, bounds, self._sums, strict=True):
            for other in sums[1 : len(parts)]:
                sums[0].vector += other.vector
            sums[0].vector /= len(rows)
            totals.append(sums[0])
        distributed.average_([sums.vector for sums in totals])
        return totals

    @torch.no_grad()
    def _accumulate(
        self, network: int, inputs: torch.Tensor, blocks: list[slice], loss: Loss, sums: GradientSums
    ) -> None:
        """Sum a micro-batch's gradients into ``sums``."""
        mlp = self._per_thread[network].here()
        sums.vector.zero_()
        for block in blocks:
            grad, numbers = loss(mlp.forward(inputs[block]), block)
            sums.extra += numbers
            mlp.backward(grad, sums.grads)

    def _blocks(self, bounds: tuple[int, int], together: int = 1) -> list[slice]:
        """A micro-batch in blocks."""
        start, end = bounds
        return [slice(start + first, start + last) for first, last in _split(end - start, self.block_rows, together)]


def _split(rows: int, size: int, together: int) -> list[tuple[int, int]]:
    """Spans of about ``size`` rows that keep each ``together`` rows in one span."""
    spans = split_evenly(rows // together, max(1, size // together))
    return [(first * together, last * together) for first, last in spans]
