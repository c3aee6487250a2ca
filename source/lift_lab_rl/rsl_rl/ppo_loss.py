"""The loss of proximal policy optimization and its derivatives (Schulman et al. 2017, arXiv:1707.06347, Eqs. 7 and 9).

All values are sums over samples, not means, so that a minibatch may come in micro-batches. The policy is a Gaussian
whose standard deviation does not depend on the observation. The derivatives are written out. This takes a third of the
operations of automatic differentiation. With so few samples the number of operations decides the time.
"""

from __future__ import annotations

from typing import NamedTuple

import torch

from .gaussian import log_normaliser
from .torchscript import compiled


class PolicyTerms(NamedTuple):
    """Terms that a batch adds to the policy's loss."""

    surrogate: torch.Tensor
    """Clipped surrogate loss, a scalar."""
    drift: torch.Tensor
    """Squared distance between the new and the old mean action, shape (num_actions,)."""
    grad_std: torch.Tensor
    """Derivative of the surrogate loss by the standard deviation, shape (num_actions,)."""
    grad_mean: torch.Tensor
    """Derivative of the surrogate loss by the mean action, shape (rows, num_actions)."""


@compiled
def policy_terms(
    mean: torch.Tensor,
    std: torch.Tensor,
    *,
    actions: torch.Tensor,
    old_mean: torch.Tensor,
    old_log_prob: torch.Tensor,
    advantages: torch.Tensor,
    clip_param: float,
) -> PolicyTerms:
    """Clipped surrogate loss.

    Args:
        mean: mean actions of the policy that learns, shape (rows, num_actions).
        std: its standard deviations, shape (num_actions,).
        actions: actions that were taken, shape (rows, num_actions).
        old_mean: mean actions of the policy that took them, shape (rows, num_actions).
        old_log_prob: logarithm of their probability under it, shape (rows,).
        advantages: how much better than expected they were, shape (rows,).
        clip_param: how far the ratio of probabilities may leave 1 with profit.
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
    return PolicyTerms(surrogate, (mean - old_mean).square_().sum(0), grad_std, grad_mean)


@compiled
def value_terms(
    values: torch.Tensor, *, old_values: torch.Tensor, returns: torch.Tensor, clip_param: float | None
) -> tuple[torch.Tensor, torch.Tensor]:
    """Squared errors of the values.

    Args:
        values: of the critic that learns, shape (rows,).
        old_values: of the critic that the advantages were computed with, shape (rows,).
        returns: their targets, shape (rows,).
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
