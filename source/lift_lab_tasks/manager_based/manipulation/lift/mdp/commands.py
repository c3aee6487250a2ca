"""The lift task's command: a pose for the object, with success and smoothness as metrics."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import torch

from lift_lab.envs.mdp import UniformPoseCommand, UniformPoseCommandCfg
from lift_lab.envs.mdp._tensors import block, compact_index, range_limits, sample_ranges
from lift_lab.managers import SceneEntityCfg
from lift_lab.utils import configclass
from lift_lab.utils.rows import fill_rows

if TYPE_CHECKING:
    from lift_lab.envs import ManagerBasedRLEnv
    from lift_lab.managers.manager_base import Foretold


_NEVER = 2**31


class ObjectPoseCommand(UniformPoseCommand):
    """A uniform pose command that also measures how the object follows it, and how smoothly the robot moves.

    Metrics beside those of the base class, each of one episode:

    - ``success``: 1 once the object came within :attr:`ObjectPoseCommandCfg.success_distance`.
    - ``time_to_success_s``: when it first did, in s. Only episodes that succeeded count; absent if none did.
    - ``object_position_error``: distance in m at the last step.
    - ``first_pick_drop``: 1 if the object was held up and then fell back
      (:attr:`ObjectPoseCommandCfg.pick_heights_m`).
    - ``squared_action_change``: mean over the steps of ``|a_t - a_(t-1)|^2``, raw actions (the study's Eq. (5)).
    - ``squared_joint_acceleration``: mean over steps and joints of the squared acceleration in (rad/s^2)^2, from the
      joint velocities of one environment step to the next.
    """

    cfg: ObjectPoseCommandCfg

    def __init__(self, cfg: ObjectPoseCommandCfg, env: ManagerBasedRLEnv):
        super().__init__(cfg, env)
        self._robot_cfg = SceneEntityCfg(cfg.asset_name)
        self._object_cfg = SceneEntityCfg(cfg.object_name)
        joint_ids, _ = self.robot.find_joints(cfg.smoothness_joint_names)
        self._joint_ids = compact_index(joint_ids, self.robot.num_joints, self.device)
        zeros = torch.zeros(self.num_envs, device=self.device)
        for name in ("success", "object_position_error", "first_pick_drop"):
            self.metrics[name] = zeros.clone()
        self._success_step = torch.full((self.num_envs,), _NEVER, device=self.device)
        self._held = torch.zeros(self.num_envs, dtype=torch.bool, device=self.device)
        self._steps = zeros.clone()
        self._is_smoothness_current = False
        self._joint_vel = torch.zeros(self.num_envs, len(joint_ids), device=self.device)
        self._smoothness = torch.zeros(2, self.num_envs, device=self.device)
        names = ("squared_action_change", "squared_joint_acceleration")
        self.metrics.update(zip(names, self._smoothness, strict=True))
        # from sums of squared changes of actions and of joint velocities to what is measured
        acceleration_per_change = 1.0 / (len(joint_ids) * env.step_dt**2)
        self._per_change = torch.tensor([[1.0], [acceleration_per_change]], device=self.device)
        self._missed_goals: tuple[torch.Tensor, torch.Tensor] | None = None
        self._practice_share, self._practice_spread_m = 0.0, 0.0
        self._practised = torch.zeros(self.num_envs, dtype=torch.bool, device=self.device)
        self._succeeded_ids: torch.Tensor | None = None

    def practise(self, goals_b: torch.Tensor, missed: torch.Tensor, share: float, spread_m: float) -> None:
        """Let a share of the coming goals be near one of these.

        The others are uniform, and all of them while none was missed. The command's ranges hold for every goal. Means
        of the metrics leave out the episodes that practise, so that they say how the task itself is done.

        Args:
            goals_b: positions in the robot's root frame in m, shape (n, 3); kept, not copied, as is the next.
            missed: 1 for a goal that was missed and 0 for one that was reached, shape (n,).
            share: of the coming goals, within [0, 1]; with 0 nothing more is drawn than without this call.
            spread_m: how far a practised goal may lie from the missed one along each axis.
        """
        self._missed_goals = (goals_b, missed)
        self._practice_share, self._practice_spread_m = share, spread_m

    def _choose_positions(self, env_ids: torch.Tensor, uniform_b: torch.Tensor) -> torch.Tensor:
        if self._missed_goals is None or self._practice_share == 0.0:
            return uniform_b
        goals_b, missed = self._missed_goals
        count, r, furthest = len(env_ids), self.cfg.ranges, self._practice_spread_m
        picked = torch.multinomial(missed + 1e-6, count, replacement=True)
        spread = sample_ranges([(-furthest, furthest)] * 3, count, self.device)
        low, high = range_limits((r.pos_x, r.pos_y, r.pos_z), self.device)
        again = torch.clamp(goals_b[picked] + spread, low, high)
        taken = (torch.rand(count, device=self.device) < self._practice_share) & (missed[picked] > 0)
        self._practised[env_ids] = taken
        return torch.where(taken.unsqueeze(1), again, uniform_b)

    @property
    def counts(self) -> torch.Tensor | None:
        """Whether each environment's present goal is uniform; None while no share practises."""
        return None if self._practice_share == 0.0 else ~self._practised

    def reset(self, env_ids: Any = None) -> dict[str, torch.Tensor]:
        """Start an episode; returns the mean of each metric over the episodes that end."""
        extras = super().reset(env_ids)
        self._succeeded_ids = None
        fill_rows(self._success_step, env_ids, _NEVER)
        fill_rows(self._steps, env_ids, 0.0)
        fill_rows(self._held, env_ids, False)
        ids = slice(None) if env_ids is None else env_ids
        self._joint_vel[ids] = block(self.robot.data.joint_vel, ids, self._joint_ids)
        return extras

    def finish_episodes(self, env_ids: torch.Tensor) -> None:
        """Count the last step of the episodes that end; where its action was no number, its smoothness is left out."""
        self._measure_once()
        before = self._smoothness[:, env_ids]
        self._update_smoothness()
        after = self._smoothness[:, env_ids]
        self._smoothness[:, env_ids] = torch.where(after.isfinite(), after, before)
        self._is_smoothness_current = True

    def _foretell_counted(self, ended: torch.Tensor) -> list[Foretold]:
        self._measure_once()  # a success of the last step counts
        succeeded = ended & (self.metrics["success"] > 0)
        counts = self.counts
        if counts is not None:
            succeeded = succeeded & counts
        return [*super()._foretell_counted(ended), (succeeded, self._take_succeeded_ids)]

    def _take_succeeded_ids(self, env_ids: torch.Tensor) -> None:
        self._succeeded_ids = env_ids

    def _episode_means(self, env_ids: torch.Tensor) -> dict[str, torch.Tensor]:
        means = super()._episode_means(env_ids)
        succeeded = self._succeeded_ids
        if succeeded is None:
            succeeded = env_ids[self.metrics["success"][env_ids] > 0]
        if len(succeeded):
            self.log_counts["time_to_success_s"] = len(succeeded)
            means["time_to_success_s"] = self._success_step[succeeded].float().mean() * self._env.step_dt
        return means

    def _update_metrics(self) -> None:
        self._succeeded_ids = None
        super()._update_metrics()
        if not self._is_smoothness_current:
            self._update_smoothness()
        self._is_smoothness_current = False

    def _measure(self) -> None:
        super()._measure()
        metrics = self.metrics
        pos_w = self._env.scene[self.cfg.object_name].data.root_pos_w
        distance = torch.linalg.vector_norm(pos_w - self.goal_pos_w, dim=1)
        metrics["object_position_error"] = distance
        reached = distance < self.cfg.success_distance
        metrics["success"].masked_fill_(reached, 1.0)
        earliest = torch.minimum(self._success_step, self._env.episode_length_buf)
        self._success_step = torch.where(reached, earliest, self._success_step)
        low_m, high_m = self.cfg.pick_heights_m
        height_m = pos_w[:, 2]
        metrics["first_pick_drop"].masked_fill_(self._held & (height_m < low_m), 1.0)
        self._held |= height_m > high_m

    def _update_smoothness(self) -> None:
        """Running means over the steps of the episode."""
        manager, joint_vel = self._env.action_manager, block(self.robot.data.joint_vel, None, self._joint_ids)
        changes = (manager.action - manager.prev_action, joint_vel - self._joint_vel)
        self._joint_vel = joint_vel
        squares = torch.stack([change.square_().sum(dim=1) for change in changes])
        self._steps += self._env.episode_length_buf > 0
        share = self._steps.clamp(min=1.0).reciprocal_()
        self._smoothness.lerp_(squares.mul_(self._per_change), share)


@configclass
class ObjectPoseCommandCfg(UniformPoseCommandCfg):
    """Config of :class:`ObjectPoseCommand`."""

    class_type: type = ObjectPoseCommand
    object_name: str = "object"
    """Scene entity that is to reach the pose."""
    success_distance: float = 0.02
    """Distance in m below which the object has reached the commanded position (the study's Eq. (7))."""
    pick_heights_m: tuple[float, float] = (0.03, 0.06)
    """An object above the second height (m, world) is held; below the first one after that, it was dropped."""
    smoothness_joint_names: list[str] = [".*"]
    """Joints whose accelerations are measured."""
