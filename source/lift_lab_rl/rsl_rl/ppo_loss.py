"""The loss of proximal policy optimization and its derivatives (Schulman et al. 2017, arXiv:1707.06347, Eqs. 7 and 9).

Sums over samples, not means, so that a batch may come in parts. The policy is a Gaussian whose standard deviation does
not depend on the observation. The derivatives are written out: they take a third of the operations that automatic
differentiation records, and samples are few enough for the number of operations to count.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import torch


class PolicyTerms(NamedTuple):
    """What a batch adds to the policy's loss."""

    surrogate: torch.Tensor
    """Clipped surrogate loss, a scalar."""
    drift: torch.Tensor
    """Squared distance between the new and the old mean action, shape (num_actions,)."""
    grad_std: torch.Tensor
    """Derivative of the surrogate loss by the standard deviation, shape (num_actions,)."""
    grad_mean: torch.Tensor
    """Derivative of surrogate loss and penalty by the mean action, shape (rows, num_actions)."""


def log_normaliser(std: torch.Tensor) -> torch.Tensor:
    """What makes a Gaussian's density integrate to one, as a logarithm; a scalar.

    Args:
        std: standard deviations, shape (num_actions,).
    """
    return (std.log() + 0.5 * math.log(2 * math.pi)).sum()


def policy_terms(
    mean: torch.Tensor,
    std: torch.Tensor,
    *,
    actions: torch.Tensor,
    old_mean: torch.Tensor,
    old_log_prob: torch.Tensor,
    advantages: torch.Tensor,
    clip_param: float,
    mean_reg_coef: float,
) -> PolicyTerms:
    """Surrogate loss, and a penalty of ``mean_reg_coef`` times the squared length of the mean action.

    Args:
        mean: mean actions of the policy that learns, shape (rows, num_actions).
        std: its standard deviations, shape (num_actions,).
        actions: actions that were taken, shape (rows, num_actions).
        old_mean: mean actions of the policy that took them, shape (rows, num_actions).
        old_log_prob: logarithm of their probability under it, shape (rows,).
        advantages: how much better than expected they were, shape (rows,).
        clip_param: how far the ratio of probabilities may leave 1 with profit.
        mean_reg_coef: weight of the penalty.
    """
    z = (actions - mean).div_(std)
    squares = z.square()
    ratio = squares.sum(-1).mul_(-0.5).sub_(log_normaliser(std)).sub_(old_log_prob).exp_()
    gain = advantages * ratio
    limited = ratio.clamp_(1.0 - clip_param, 1.0 + clip_param).mul_(advantages)
    surrogate = -torch.minimum(gain, limited).sum()
    # d ratio = ratio d log_prob, and nothing where the limit holds
    by_log_prob = gain.masked_fill_(limited < gain, 0.0).neg_()
    grad_std = (by_log_prob @ squares - by_log_prob.sum()) / std
    grad_mean = z.mul_(by_log_prob.unsqueeze(-1)).div_(std)
    if mean_reg_coef:
        grad_mean.add_(mean, alpha=2.0 * mean_reg_coef)
    return PolicyTerms(surrogate, (mean - old_mean).square_().sum(0), grad_std, grad_mean)


def value_terms(
    values: torch.Tensor, *, old_values: torch.Tensor, returns: torch.Tensor, clip_param: float | None
) -> tuple[torch.Tensor, torch.Tensor]:
    """Squared errors of the values.

    Args:
        values: of the critic that learns, shape (rows,).
        old_values: of the critic that the advantages were computed with, shape (rows,).
        returns: what they should be, shape (rows,).
        clip_param: how far a value may leave the old one with profit; None for any distance.

    Returns:
        The loss, a scalar, and its derivative by ``values``, shape (rows,).
    """
    error = values - returns
    if clip_param is None:
        return error.square().sum(), 2.0 * error
    step = values - old_values
    limited = step.clamp(-clip_param, clip_param)
    limited_error = old_values + limited - returns
    loss = torch.maximum(error.square(), limited_error.square()).sum()
    counts = (step == limited) | (error.abs() >= limited_error.abs())
    return loss, 2.0 * error * counts


def divergence(std: torch.Tensor, old_std: torch.Tensor, drift: torch.Tensor) -> torch.Tensor:
    """Kullback-Leibler divergence of the new policy from the old one, averaged over samples; a scalar.

    Args:
        std: standard deviations of the new policy, shape (num_actions,).
        old_std: of the old policy, shape (num_actions,).
        drift: mean squared distance between their mean actions, shape (num_actions,).
    """
    ratio = old_std / std
    # In this order a distance that is nothing but rounding vanishes, and a policy does not diverge from itself.
    return ((ratio.square() + drift / std.square() - 1.0) * 0.5 - ratio.log()).sum()
