"""The passes of a network through blocks of samples agree with torch's own, whatever came before them."""

import copy
from concurrent.futures import ThreadPoolExecutor

import pytest
import torch
from torch import nn

from lift_lab_rl.rsl_rl.mlp_gradients import AutogradMlp, EluMlp, GradientSums, MlpPerThread


def network(activation=nn.ELU, **settings):
    torch.manual_seed(1)
    layers = [nn.Linear(5, 7), activation(**settings), nn.Linear(7, 6), activation(**settings), nn.Linear(6, 2)]
    return nn.Sequential(*layers).double()


@pytest.mark.parametrize("activation", [nn.ELU, nn.Tanh], ids=["by hand", "by autograd"])
def test_gradients_are_those_that_autograd_finds_summed_over_blocks(activation):
    ours = network(activation)
    reference = copy.deepcopy(ours)
    x, weight = torch.randn(23, 5).double(), torch.randn(23, 2).double()
    (reference(x) * weight).sum().backward()
    passes, sums = MlpPerThread(ours).here(), GradientSums(list(ours.parameters()), 3)
    sums.vector.zero_()
    with torch.no_grad():
        for rows in (slice(0, 4), slice(4, 15), slice(15, 23)):  # growing and shrinking blocks
            torch.testing.assert_close(passes.forward(x[rows]), reference(x[rows]).detach())
            passes.backward(weight[rows], sums.grads)
    for mine, theirs in zip(sums.grads, reference.parameters(), strict=True):
        torch.testing.assert_close(mine, theirs.grad)
    assert sums.extra.tolist() == [0.0] * 3


def test_a_network_without_hidden_layers_is_one_matrix_product():
    layer = nn.Linear(4, 3)
    passes, x = EluMlp([layer]), torch.randn(6, 4)
    with torch.no_grad():
        torch.testing.assert_close(passes.forward(x), layer(x))


def test_arrays_of_a_rollout_serve_the_update_too():
    net = network().float()
    passes, sums = EluMlp([net[0], net[2], net[4]]), GradientSums(list(net.parameters()), 1)
    with torch.inference_mode():
        passes.forward(torch.randn(9, 5))
    with torch.no_grad():
        passes.backward(torch.ones_like(passes.forward(torch.randn(9, 5))), sums.grads)
    assert sums.vector.abs().sum() > 0


@pytest.mark.parametrize(
    ("net", "by_hand"),
    [
        (network(), True),
        (network(nn.ELU, alpha=0.5), False),
        (network(nn.ReLU), False),
        (nn.Sequential(nn.Linear(3, 2), nn.ELU()), False),
        (nn.Sequential(nn.Linear(3, 4, bias=False), nn.ELU(), nn.Linear(4, 2)), False),
    ],
    ids=["elu", "elu of another alpha", "relu", "elu at the end", "no bias"],
)
def test_only_networks_with_plain_elu_are_passed_by_hand(net, by_hand):
    assert isinstance(MlpPerThread(net).here(), EluMlp if by_hand else AutogradMlp)


def test_every_thread_has_arrays_of_its_own():
    passes = MlpPerThread(network())
    with ThreadPoolExecutor(1) as other:
        assert other.submit(passes.here).result() is not passes.here()
    assert passes.here() is passes.here()
