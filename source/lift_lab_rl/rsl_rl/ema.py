"""Exponential moving average (EMA) of the policy's weights.

An update moves the policy by a divergence that is chosen for learning. At the end of training this is more than the
remaining error: neighbouring checkpoints differ by millimetres at the hand. Their average does not. The average covers
a fixed share of the training so far (polynomial-decay averaging: Shamir and Zhang, 2013). So it needs no schedule, and
it follows closely while the policy still changes fast.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import torch

from lift_lab.utils.errors import ConfigError

AVERAGE = "actor_average_state_dict"
"""Entry of a checkpoint that holds the averaged policy."""

LAST = "actor_state_dict"
"""Entry of a checkpoint that holds the policy of the last update."""


def acting_policy(content: dict[str, Any], path: str | Path) -> dict[str, torch.Tensor]:
    """The policy of a checkpoint to act with: the averaged one where it holds one, else the last.

    Args:
        content: contents of the checkpoint.
        path: its file, for the message.

    Raises:
        ConfigError: it holds neither.
    """
    for name in (AVERAGE, LAST):
        if name in content:
            return content[name]
    raise ConfigError(f"'{path}' holds no policy: it has neither '{AVERAGE}' nor '{LAST}'")


class PolicyEma:
    """A running average of the parameters of an actor. Training never uses it.

    Attributes:
        actor: the network that learns.
        parameters: name -> averaged parameter.
    """

    def __init__(self, actor: torch.nn.Module, share: float):
        """Start at the actor as it is.

        Args:
            actor: the network that learns.
            share: weight is given to about the last ``share`` of all updates, in (0, 1).
        """
        self.actor = actor
        self._share = share
        self.parameters = {name: value.detach().clone() for name, value in actor.named_parameters()}

    def update(self, iteration: int) -> None:
        """Add the present actor.

        Args:
            iteration: updates done so far, this one included.
        """
        weight = 1.0 / max(1.0, self._share * iteration)
        with torch.no_grad():
            for name, value in self.actor.named_parameters():
                self.parameters[name].lerp_(value.detach(), weight)

    def state_dict(self) -> dict[str, torch.Tensor]:
        """The averaged parameters, with the actor's present buffers (the observations' mean and deviation)."""
        return {**self.actor.state_dict(), **self.parameters}

    def load_state_dict(self, state: dict[str, Any]) -> None:
        """Continue from a saved average."""
        for name, value in self.parameters.items():
            value.copy_(state[name])
