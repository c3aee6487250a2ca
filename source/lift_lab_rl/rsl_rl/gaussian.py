"""The Gaussian policy whose standard deviations do not depend on the observation, as rsl_rl parameterises it."""

from __future__ import annotations

import math
from typing import Any

import torch
from rsl_rl.models import MLPModel
from rsl_rl.modules.distribution import GaussianDistribution
from torch import nn


def action_std(policy: MLPModel) -> float:
    """Standard deviation of the actions of any rsl_rl policy, averaged over actions (and the last samples it saw)."""
    distribution: Any = policy.distribution
    with torch.no_grad():
        std = standard_deviation(distribution) if type(distribution) is GaussianDistribution else distribution.std
        return float(std.mean())


def standard_deviation(distribution: Any) -> torch.Tensor:
    """Standard deviation of every action, within its bounds, shape (num_actions,).

    Args:
        distribution: rsl_rl's ``GaussianDistribution``.
    """
    if distribution.std_type == "log":
        return distribution.log_std_param.clamp(*distribution.log_std_range).exp()
    return distribution.std_param.clamp(*distribution.std_range)


def to_parameter_gradient(distribution: Any, grad: torch.Tensor) -> nn.Parameter:
    """Turn a derivative by the standard deviations into the one by their parameter, in place.

    Args:
        distribution: rsl_rl's ``GaussianDistribution``.
        grad: derivative, shape (num_actions,).

    Returns:
        The parameter.
    """
    in_log = distribution.std_type == "log"
    param = distribution.log_std_param if in_log else distribution.std_param
    limited = param.clamp(*(distribution.log_std_range if in_log else distribution.std_range))
    grad *= param == limited
    if in_log:
        grad *= limited.exp()
    return param


def log_normaliser(std: torch.Tensor) -> torch.Tensor:
    """Logarithm of the factor by which a Gaussian's density integrates to one; a scalar.

    Args:
        std: standard deviations, shape (num_actions,).
    """
    return (std.log() + 0.5 * math.log(2 * math.pi)).sum()


def entropy(std: torch.Tensor) -> torch.Tensor:
    """Entropy of the policy, a scalar.

    Args:
        std: standard deviations, shape (num_actions,).
    """
    return log_normaliser(std) + 0.5 * len(std)


def divergence(std: torch.Tensor, old_std: torch.Tensor, drift: torch.Tensor) -> torch.Tensor:
    """Kullback-Leibler divergence of the new policy from the old one, averaged over samples; a scalar.

    Args:
        std: standard deviations of the new policy, shape (num_actions,).
        old_std: standard deviations of the old policy, shape (num_actions,).
        drift: mean squared distance between their mean actions, shape (num_actions,).
    """
    ratio = old_std / std
    # In this order a distance that is nothing but rounding vanishes, and a policy does not diverge from itself.
    return ((ratio.square() + drift / std.square() - 1.0) * 0.5 - ratio.log()).sum()
