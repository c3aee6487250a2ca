"""The written-out derivatives of the PPO loss are those that automatic differentiation finds."""

import pytest
import torch

from lift_lab_rl.rsl_rl.exploration import add_mean_regularisation
from lift_lab_rl.rsl_rl.ppo_loss import policy_terms, value_terms

ROWS, ACTIONS, CLIP = 400, 3, 0.2


@pytest.fixture
def batch():
    """Samples in double precision; in a third of them the new policy is further from the old one than the limit."""
    generator = torch.Generator().manual_seed(4)

    def normal(*shape):
        return torch.randn(*shape, generator=generator, dtype=torch.float64)

    old_mean, old_std = normal(ROWS, ACTIONS), torch.tensor([0.5, 1.0, 2.0], dtype=torch.float64)
    actions = old_mean + old_std * normal(ROWS, ACTIONS)
    old_log_prob = torch.distributions.Normal(old_mean, old_std).log_prob(actions).sum(-1)
    return {
        "mean": old_mean + 0.1 * normal(ROWS, ACTIONS),
        "std": old_std * 1.1,
        "old_std": old_std,
        "policy": {
            "actions": actions,
            "old_mean": old_mean,
            "old_log_prob": old_log_prob,
            "advantages": normal(ROWS),
        },
        "values": normal(ROWS),
        "old_values": normal(ROWS),
        "returns": normal(ROWS),
    }


@pytest.mark.parametrize("coef", [0.0, 0.25])
def test_the_policys_derivatives_are_those_of_the_clipped_surrogate_and_the_regularisation(batch, coef):
    mean, std = batch["mean"].requires_grad_(), batch["std"].requires_grad_()
    samples = batch["policy"]
    log_prob = torch.distributions.Normal(mean, std).log_prob(samples["actions"]).sum(-1)
    ratio = torch.exp(log_prob - samples["old_log_prob"])
    limited = ratio.clamp(1 - CLIP, 1 + CLIP)
    surrogate = torch.max(-samples["advantages"] * ratio, -samples["advantages"] * limited).sum()
    expected = torch.autograd.grad(surrogate + coef * mean.square().sum(), [mean, std])
    assert 0.1 < (ratio != limited).double().mean() < 0.9
    with torch.no_grad():
        terms = policy_terms(mean, std, **samples, clip_param=CLIP)
        add_mean_regularisation(terms.grad_mean, mean, coef)
    torch.testing.assert_close(terms.surrogate, surrogate.detach())
    torch.testing.assert_close(terms.grad_mean, expected[0])
    torch.testing.assert_close(terms.grad_std, expected[1])


@pytest.mark.parametrize("clip", [None, 0.5])
def test_the_values_derivatives_are_those_of_the_squared_error_clipped_or_not(batch, clip):
    values, old, returns = batch["values"].requires_grad_(), batch["old_values"], batch["returns"]
    errors = (values - returns).square()
    if clip is not None:
        errors = torch.max(errors, (old + (values - old).clamp(-clip, clip) - returns).square())
    expected = torch.autograd.grad(errors.sum(), values)[0]
    with torch.no_grad():
        loss, grad = value_terms(values, old_values=old, returns=returns, clip_param=clip)
    torch.testing.assert_close(loss, errors.sum().detach())
    torch.testing.assert_close(grad, expected)
