"""Curricula of the lift task."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import torch

from lift_lab.envs.mdp.actions.binary_joint_actions import BinaryJointAction
from lift_lab.managers import ManagerTermBase
from lift_lab.utils.errors import ConfigError

if TYPE_CHECKING:
    from lift_lab.envs import ManagerBasedRLEnv
    from lift_lab.managers import CurriculumTermCfg


class hold_gripper_while_hovering(ManagerTermBase):
    """Let a close command last while a policy has learned to reach the object and not yet to lift it.

    A gripper that hovers about the object is a local optimum. Exploration noise is drawn anew at every step, and to
    close for one step earns nothing; a lift takes several. While closing lasts for ``close_time_s``, a single sample
    below zero is a grasp. The hold begins when the episodes that ended of late (as many as there are environments)
    earned ``reached`` of what the reaching term can pay, and ends for good once they earn ``lifted`` of what the
    lifting term can pay, so that a policy is trained and judged by the task's own actions. What is rewarded does not
    change.

    An aid of exploration: ``evaluate.py`` and ``play.py`` leave it out. It never begins where one of the two terms is
    missing or weighs nothing.

    Params:
        close_time_s: how long a close command lasts meanwhile, in s.
        reached: share of the reaching term's largest episode sum, within (0, 1).
        lifted: share of the lifting term's, within (0, 1).
        action_name: the gripper's action term, a binary one.
        reach_term: reward term of the reach; it pays at most its weight a second, as does the next.
        lift_term: reward term of the lift.

    Returns:
        The time in s that a close command lasts now, for the log.
    """

    exploration_only = True

    def __init__(self, cfg: CurriculumTermCfg, env: ManagerBasedRLEnv):
        super().__init__(cfg, env)
        params = cfg.params
        name = type(self).__name__
        self._gripper = env.action_manager.get_term(params.get("action_name", "gripper_action"))
        if not isinstance(self._gripper, BinaryJointAction):
            raise ConfigError(f"{name}: action_name must name a binary joint action")
        for share in ("reached", "lifted"):
            if not 0.0 < params[share] < 1.0:
                raise ConfigError(f"{name}: {share} is {params[share]}; it must be within (0, 1)")
        self._reached, self._lifted = (torch.zeros((), device=env.device) for _ in range(2))
        self._begun, self._found = (torch.zeros((), dtype=torch.bool, device=env.device) for _ in range(2))

    def __call__(
        self,
        env: ManagerBasedRLEnv,
        env_ids: Sequence[int] | torch.Tensor,
        close_time_s: float,
        reached: float,
        lifted: float,
        action_name: str = "gripper_action",
        reach_term: str = "reaching_object",
        lift_term: str = "lifting_object",
    ) -> torch.Tensor:
        if env.common_step_counter > 0:  # at 0 no episode has ended
            for mean, term in ((self._reached, reach_term), (self._lifted, lift_term)):
                if term not in env.reward_manager.active_terms:
                    continue
                most = env.reward_manager.get_term_cfg(term).weight * env.max_episode_length_s
                if most > 0.0:
                    earned = env.reward_manager.episode_sum(term)[env_ids] / most
                    mean += (earned.mean() - mean) * min(1.0, len(earned) / env.num_envs)
        self._begun |= self._reached >= reached
        self._found |= self._lifted >= lifted
        seconds = torch.where(self._begun & ~self._found, close_time_s, 0.0)
        self._gripper.set_min_close_time(seconds)
        return seconds
