"""The numbers of a Gaussian policy are torch's, and its bounds are rsl_rl's."""

import math

import pytest
import torch
from rsl_rl.modules.distribution import GaussianDistribution

from lift_lab_rl.rsl_rl.gaussian import divergence, entropy, standard_deviation, to_parameter_gradient

STD = torch.tensor([0.3, 1.0, 0.7], dtype=torch.float64)


def test_the_divergence_is_that_of_the_two_gaussians_averaged_over_samples():
    generator = torch.Generator().manual_seed(4)
    old_mean, mean = (torch.randn(400, 3, generator=generator, dtype=torch.float64) for _ in range(2))
    old, new = torch.distributions.Normal(old_mean, STD), torch.distributions.Normal(mean, 1.1 * STD)
    expected = torch.distributions.kl_divergence(old, new).sum(-1).mean()
    drift = (mean - old_mean).square().mean(0)
    torch.testing.assert_close(divergence(1.1 * STD, STD, drift), expected)


def test_a_policy_does_not_diverge_from_itself_however_its_mean_was_rounded():
    std = STD.float()
    assert divergence(std, std.clone(), torch.full((3,), 1e-13)).item() == 0.0


def test_the_entropy_is_that_of_independent_gaussians():
    expected = torch.distributions.Normal(torch.zeros(3), STD).entropy().sum()
    torch.testing.assert_close(entropy(STD), expected)


@pytest.mark.parametrize("kind", ["log", "scalar"])
def test_deviations_and_their_derivatives_are_rsl_rls_also_at_the_bounds(kind):
    distribution = GaussianDistribution(3, init_std=1.0, std_range=(0.5, 2.0), std_type=kind)
    param = distribution.log_std_param if kind == "log" else distribution.std_param
    values = torch.tensor([0.1, 1.5, 3.0])
    param.data.copy_(values.log() if kind == "log" else values)
    distribution.update(torch.zeros(4, 3))
    torch.testing.assert_close(standard_deviation(distribution), distribution.std[0])
    weight = torch.tensor([2.0, 3.0, 4.0])
    (distribution.std[0] * weight).sum().backward()
    grad = weight.clone()
    with torch.no_grad():
        assert to_parameter_gradient(distribution, grad) is param
    torch.testing.assert_close(grad, param.grad)
    assert grad.tolist() == pytest.approx([0.0, 3.0 * (1.5 if kind == "log" else 1.0), 0.0])
    assert math.isfinite(grad.sum())
