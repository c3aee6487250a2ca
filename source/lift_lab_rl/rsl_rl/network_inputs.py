"""Observations that actor and critic see, and their normalisation."""

from __future__ import annotations

from typing import Any

import torch
from rsl_rl.models import MLPModel
from tensordict import TensorDict

from lift_lab_rl import distributed


def network_input(model: Any, obs: TensorDict) -> torch.Tensor:
    """Return the observations that a network sees, not normalised, shape (samples, inputs)."""
    groups = [obs[group] for group in model.obs_groups]
    return groups[0] if len(groups) == 1 else torch.cat(groups, dim=-1)


def inputs_are_shared(actor: MLPModel, critic: MLPModel) -> bool:
    """Return whether both see the same numbers: the same groups of observations, normalised alike."""
    ours, theirs = actor.obs_normalizer, critic.obs_normalizer
    return (
        actor.obs_groups == critic.obs_groups
        and type(ours) is type(theirs)
        and ours.training == theirs.training
        and all(torch.equal(a, b) for a, b in zip(ours.buffers(), theirs.buffers(), strict=True))
    )


def update_normalization(actor: MLPModel, critic: MLPModel, obs: TensorDict) -> None:
    """Add observations to the networks' normalisation, once where both are the same.

    Args:
        actor: policy network.
        critic: value network.
        obs: of a rollout, batch size (samples,).
    """
    shared = inputs_are_shared(actor, critic)
    with distributed.answers():  # rsl_rl's normalisation takes the samples of all processes
        actor.update_normalization(obs)
        if shared:
            critic.obs_normalizer.load_state_dict(actor.obs_normalizer.state_dict())
        else:
            critic.update_normalization(obs)
