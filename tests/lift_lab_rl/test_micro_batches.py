"""Gradients and outputs over micro-batches are those of the whole, with the same bits on any number of threads."""

import copy

import pytest
import torch
from torch import nn

from lift_lab_rl.rsl_rl.micro_batches import MicroBatches

ROWS = 103


@pytest.fixture
def networks():
    torch.manual_seed(1)
    return [nn.Sequential(nn.Linear(4, 8), nn.ELU(), nn.Linear(8, outputs)).double() for outputs in (3, 1)]


@pytest.fixture
def samples():
    """Inputs and targets of each network."""
    generator = torch.Generator().manual_seed(2)
    return [
        (torch.randn(ROWS, 4, generator=generator).double(), torch.randn(ROWS, outputs, generator=generator).double())
        for outputs in (3, 1)
    ]


def made(networks, threads=1):
    parts = MicroBatches(networks, "cpu", threads)
    parts.rows, parts.acting_rows, parts.block_rows = 20, 10, 7
    return parts


def gradients(networks, samples, threads=1):
    """Gradients of squared errors, whose sums are counted beside them."""

    def loss(targets):
        def of_rows(outputs, rows):
            error = outputs - targets[rows]
            return 2.0 * error, error.square().sum().view(1)

        return of_rows

    parts = made(networks, threads)
    return parts.gradients([x for x, _ in samples], [loss(y) for _, y in samples], [1, 1])


def test_gradients_are_means_over_the_samples(networks, samples):
    for network, sums, (inputs, targets) in zip(networks, gradients(networks, samples), samples, strict=True):
        reference = copy.deepcopy(network)
        loss = (reference(inputs) - targets).square().sum() / ROWS
        loss.backward()
        torch.testing.assert_close(sums.extra, loss.detach().view(1))
        for mine, theirs in zip(sums.grads, reference.parameters(), strict=True):
            torch.testing.assert_close(mine, theirs.grad)


@pytest.mark.parametrize("threads", [2, 5])
def test_threads_change_no_bit(networks, samples, threads):
    for one, many in zip(gradients(networks, samples), gradients(networks, samples, threads), strict=True):
        assert torch.equal(one.vector, many.vector)


def test_a_smaller_minibatch_leaves_nothing_of_a_larger_one_behind(networks, samples):
    parts, (inputs, _) = made(networks), samples[0]
    losses = [lambda outputs, rows: (torch.ones_like(outputs), torch.ones(1).double())] * 2
    for rows in (ROWS, 30):
        one, _ = parts.gradients([inputs[:rows]] * 2, losses, [1, 1])
    (last_bias,) = one.grads[-1:]
    torch.testing.assert_close(last_bias, torch.ones(3).double())


def test_outputs_are_those_of_the_network_on_normalised_inputs(networks, samples):
    parts, (inputs, _) = made(networks, 2), samples[0]
    outputs = parts.outputs(1, inputs, nn.Hardtanh(), parts.acting_rows)
    torch.testing.assert_close(outputs, networks[1](inputs.clamp(-1.0, 1.0)).detach())
