"""Curricula of the lift task."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated

import torch

from lift_lab.envs.mdp.actions.binary_joint_actions import BinaryJointAction
from lift_lab.envs.mdp.metric_level import MetricLevel, check_metric, metric_level
from lift_lab.managers import ManagerTermBase
from lift_lab.utils.errors import ConfigError
from lift_lab.utils.ranges import COUNT_OR_ZERO, FINITE, FRACTION, NOT_NEGATIVE, POSITIVE

from .commands import ObjectPoseCommand

if TYPE_CHECKING:
    from lift_lab.envs import ManagerBasedRLEnv
    from lift_lab.managers import CurriculumTermCfg


class hold_gripper_while_hovering(ManagerTermBase):
    """Let a close command last while a policy has learned to reach the object and not yet to lift it.

    A gripper that stays near the object is a local optimum. Exploration noise is independent at every step, and closing
    for one step earns nothing; a lift takes several steps. While a close command lasts for ``close_time_s``, a single
    sample below zero is a grasp.

    The aid looks at the last episodes that ended, as many as there are environments. It starts when they earned the
    share ``reached`` of the largest reaching reward. It ends for good when they earn the share ``lifted`` of the
    largest lifting reward. So the final policy is trained with the unchanged actions. Rewards do not change.

    An aid of exploration: set ``training_only`` of its config. It never begins where one of the two terms is
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
        close_time_s: Annotated[float, NOT_NEGATIVE],
        reached: Annotated[float, FRACTION],
        lifted: Annotated[float, FRACTION],
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
                    earned = env.reward_manager.episode_sum(term)[env_ids]
                    mean.lerp_(earned.mean() / most, min(1.0, len(earned) / env.num_envs))
        self._begun |= self._reached >= reached
        self._found |= self._lifted >= lifted
        seconds = (self._begun > self._found) * close_time_s  # of booleans, > is "and not"
        self._gripper.set_min_close_time(seconds)
        return seconds


class practise_missed_goals(ManagerTermBase):
    """Give a share of the episodes a goal near one that an environment has just missed.

    Failed-goal replay. A policy that reaches nearly every goal stops short of those at the corners of their range,
    where samples are few. Each environment remembers the goal of its last episode if ``metric`` says that it had no
    success. From ``start_step`` on, ``share`` of the new episodes draw one of these goals, with an offset of up to
    ``spread_m`` along each axis and within the command's ranges. The other episodes draw uniform goals; all do if none
    was missed. Rewards and success do not change.

    With ``level``, ``start_step`` counts from the step at which the running mean of ``metric`` first reaches it. The
    mean is over the last episodes that ended, as many as there are environments.

    An aid of training: set ``training_only`` of its config. Rewards in the logs of a training include the replayed
    goals, which are harder. The metrics leave them out.

    Params:
        share: share of episodes that replay a failed goal, within [0, 1].
        start_step: first environment step of the replay.
        spread_m: largest distance of a replayed goal from the missed one along each axis, in m.
        command_name: the command, an :class:`ObjectPoseCommand`.
        metric: the metrics term that is 1 for an episode with success, else 0.
        level: mean of the metric from which on steps count; None counts from the start of the training.

    Returns:
        Share of the environments whose last episode missed its goal, for the log.
    """

    _level: MetricLevel | None = None

    def __init__(self, cfg: CurriculumTermCfg, env: ManagerBasedRLEnv):
        super().__init__(cfg, env)
        params, name = cfg.params, type(self).__name__
        self._command = env.command_manager.get_term(params.get("command_name", "object_pose"))
        if not isinstance(self._command, ObjectPoseCommand):
            raise ConfigError(f"{name}: command_name must name a command of mdp.ObjectPoseCommandCfg")
        if not 0.0 <= params["share"] <= 1.0:
            raise ConfigError(f"{name}: share is {params['share']}; it must be within [0, 1]")
        self._goals_b = torch.zeros(env.num_envs, 3, device=env.device)
        self._missed = torch.zeros(env.num_envs, device=env.device)
        self._command.replay_missed_goals(self._goals_b, self._missed, share=0.0, spread_m=0.0)
        check_metric(self, env)
        level = metric_level(self, env)
        if level is not None:
            self._level = level

    def __call__(
        self,
        env: ManagerBasedRLEnv,
        env_ids: Sequence[int] | torch.Tensor,
        share: Annotated[float, FRACTION],
        start_step: Annotated[int, COUNT_OR_ZERO] = 0,
        spread_m: Annotated[float, NOT_NEGATIVE] = 0.02,
        command_name: str = "object_pose",
        metric: str = "success",
        level: Annotated[float | None, FINITE] = None,
    ) -> torch.Tensor:
        command = self._command
        if env.common_step_counter > 0:  # at 0 no episode has ended
            self._goals_b[env_ids] = command.pose_command_b[env_ids, :3]
            self._missed[env_ids] = 1.0 - env.metrics_manager.episode_value(metric)[env_ids]
        steps = env.common_step_counter if self._level is None else self._level.elapsed(env, env_ids)
        begun = steps >= start_step
        command.replay_missed_goals(self._goals_b, self._missed, share if begun else 0.0, spread_m)
        return self._missed.mean()


class reach_from_afar(ManagerTermBase):
    """Let the reaching reward be felt from farther away while a policy has not yet come near the object.

    Its scale of 0.1 m pays a thousandth at the start of an episode. Where exploration does not carry the tool to the
    object by itself, a new critic's errors are larger than that, and nothing is learned. Up to ``num_steps`` the
    scale is ``std``, then the term's own.

    An aid of exploration: set ``training_only`` of its config. Rewards in the logs of a training are those of
    the wider scale meanwhile.

    Params:
        std: the wider scale in m.
        num_steps: environment step from which on the term's own scale holds.
        term_name: the reward term, with a parameter ``std``.

    Returns:
        The scale in m that holds now, for the log.
    """

    def __init__(self, cfg: CurriculumTermCfg, env: ManagerBasedRLEnv):
        super().__init__(cfg, env)
        term_name = cfg.params.get("term_name", "reaching_object")
        self._params = env.reward_manager.get_term_cfg(term_name).params
        if "std" not in self._params:
            raise ConfigError(f"{type(self).__name__}: reward term '{term_name}' has no parameter 'std'")
        self._own_std = self._params["std"]
        if not cfg.params["std"] >= self._own_std:
            raise ConfigError(
                f"{type(self).__name__}: std is {cfg.params['std']}; it must be at least '{term_name}''s own "
                f"{self._own_std}"
            )

    def __call__(
        self,
        env: ManagerBasedRLEnv,
        env_ids: Sequence[int] | torch.Tensor,
        std: Annotated[float, POSITIVE],
        num_steps: Annotated[int, COUNT_OR_ZERO],
        term_name: str = "reaching_object",
    ) -> float:
        self._params["std"] = std if env.common_step_counter < num_steps else self._own_std
        return self._params["std"]
