"""Two exploration aids: the mean action that a new policy begins with, and mean-action regularisation."""

from __future__ import annotations

from collections.abc import Sequence

import torch
from torch import nn


def set_initial_mean(mlp: nn.Module, mean: Sequence[float]) -> None:
    """Let a new policy begin near a mean action: its last layer's bias becomes this mean.

    Args:
        mlp: the actor's multi-layer perceptron.
        mean: one number for each action.
    """
    *_, last = (layer for layer in mlp.modules() if isinstance(layer, nn.Linear))
    with torch.no_grad():
        last.bias.copy_(torch.tensor(mean))


def add_mean_regularisation(grad_mean: torch.Tensor, mean: torch.Tensor, coef: float) -> None:
    """Add the derivative of ``coef`` times the squared length of the mean action, in place.

    Where an action has no effect, as beyond a joint's limit, nothing else brings the policy back
    (rlkit's SAC: ``policy_mean_reg_weight``).

    Args:
        grad_mean: derivative of the loss by the mean action, shape (rows, num_actions).
        mean: mean actions, shape (rows, num_actions).
        coef: weight; 0 adds nothing.
    """
    if coef:
        grad_mean.add_(mean, alpha=2.0 * coef)
