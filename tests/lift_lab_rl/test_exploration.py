"""The exploration aids do what their formulas say."""

import torch
from torch import nn

from lift_lab_rl.rsl_rl.exploration import add_mean_regularisation, set_initial_mean


def test_a_policy_begins_about_its_initial_mean():
    torch.manual_seed(3)
    mlp = nn.Sequential(nn.Linear(4, 8), nn.ELU(), nn.Linear(8, 2))
    inner = mlp[0].bias.clone()
    set_initial_mean(mlp, [5.0, -1.0])
    assert mlp[2].bias.tolist() == [5.0, -1.0]
    assert torch.equal(mlp[0].bias, inner)


def test_mean_regularisation_is_the_derivative_of_the_squared_length():
    mean = torch.randn(6, 3, dtype=torch.float64, requires_grad=True)
    (0.25 * mean.square().sum()).backward()
    grad = torch.ones(6, 3, dtype=torch.float64)
    add_mean_regularisation(grad, mean.detach(), 0.25)
    torch.testing.assert_close(grad, 1.0 + mean.grad)
    untouched = grad.clone()
    add_mean_regularisation(grad, mean.detach(), 0.0)
    assert torch.equal(grad, untouched)
