"""Actions and parts of configs that the tests of reinforcement learning environments share."""

import torch

from lift_lab.managers import ObservationGroupCfg
from lift_lab.utils import configclass


def zero_action(env) -> torch.Tensor:
    return torch.zeros(env.num_envs, env.single_action_space.shape[0])


def group_of(**terms) -> dict:
    """An observation config with one group ``policy``."""

    @configclass
    class _Policy(ObservationGroupCfg):
        pass

    group = _Policy()
    for name, term in terms.items():
        setattr(group, name, term)
    return {"policy": group}
