"""The lift task's command: a pose for the object, with success and smoothness as metrics."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, ClassVar

import torch

from lift_lab.envs.mdp import UniformPoseCommand, UniformPoseCommandCfg
from lift_lab.envs.mdp.sampling import range_limits, sample_ranges
from lift_lab.utils import configclass
from lift_lab.utils.indexing import block, columns, compact_index, fill_rows
from lift_lab.utils.ranges import POSITIVE, SPAN, Ranges
from lift_lab.utils.versions import version_of

if TYPE_CHECKING:
    from lift_lab.assets import DeformableObject, RigidObject
    from lift_lab.envs import ManagerBasedRLEnv
    from lift_lab.managers.manager_base import Foretold


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

    unsaved_attributes: ClassVar[frozenset[str]] = frozenset({"_cache"})

    cfg: ObjectPoseCommandCfg

    def __init__(self, cfg: ObjectPoseCommandCfg, env: ManagerBasedRLEnv):
        super().__init__(cfg, env)
        joint_ids, _ = self.robot.find_joints(cfg.smoothness_joint_names)
        self._joint_ids = compact_index(joint_ids, self.robot.num_joints, self.device)
        self._num_joints = len(joint_ids)
        own = ("success", "object_position_error", "first_pick_drop")
        smoothness = ("squared_action_change", "squared_joint_acceleration")
        rows = self._in_rows((*self.metrics, *own, *smoothness), more=2)
        self._smoothness, self._steps, self._held = rows[-4:-2], rows[-2], rows[-1]
        self._success_step = torch.zeros(self.num_envs, dtype=torch.long, device=self.device)
        self._cache: tuple[torch.Tensor, int | None, torch.Tensor] | None = None
        self._missed_goals: tuple[torch.Tensor, torch.Tensor] | None = None
        self._practice_share, self._practice_spread_m = 0.0, 0.0
        self._practised = torch.zeros(self.num_envs, dtype=torch.bool, device=self.device)
        self._succeeded_ids: torch.Tensor | None = None

    def on_state_loaded(self) -> None:
        """Forget what was computed before a saved state was loaded."""
        super().on_state_loaded()
        self._cache = None

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

    @property
    def object(self) -> RigidObject | DeformableObject:
        """The object that is to reach the pose."""
        return self._env.scene[self.cfg.object_name]

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
        self._succeeded_ids = self._cache = None
        if not hasattr(self, "_moves"):
            self._make_moves()
        fill_rows(self._moves, env_ids, 0.0)
        ids = slice(None) if env_ids is None else env_ids
        self._moves[ids, -self._num_joints :] = block(self.robot.data.joint_vel, ids, self._joint_ids)
        return extras

    def _make_moves(self) -> None:
        """Room for action and joint velocities of the last step, once the action manager is there."""
        num_joints, num_actions = self._num_joints, self._env.action_manager.total_action_dim
        self._moves = torch.zeros(self.num_envs, num_actions + num_joints, device=self.device)
        # from their squared changes to what is measured
        self._per_change = torch.zeros(2, num_actions + num_joints, device=self.device)
        self._per_change[0, :num_actions] = 1.0
        self._per_change[1, num_actions:] = 1.0 / (num_joints * self._env.step_dt**2)

    def finish_episodes(self, env_ids: torch.Tensor) -> None:
        """Count the last step of the episodes that end; where the physics failed, its smoothness is left out."""
        self._measure_once()

    def _foretell_counted(self, ended: torch.Tensor) -> list[Foretold]:
        self._measure_once()  # a success of the last step counts, and a GPU is busy until the answer comes
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
        if succeeded is None:  # nothing had to be foretold: the host may ask
            succeeded = env_ids[self.metrics["success"][env_ids] > 0] if bool(means["success"] > 0) else env_ids[:0]
        if len(succeeded):
            self.log_counts["time_to_success_s"] = len(succeeded)
            means["time_to_success_s"] = self._success_step[succeeded].float().mean() * self._env.step_dt
        return means

    def _update_metrics(self) -> None:
        self._succeeded_ids = None
        super()._update_metrics()

    @property
    def object_distance(self) -> torch.Tensor:
        """Distance in m from the object to the commanded position at the present state, shape (num_envs,)."""
        self._place_commands()
        pos_w = self.object.data.root_pos_w
        version = version_of(self.pose_command_w)
        if self._cache is not None and version is not None:
            of_pos_w, at_version, distance = self._cache
            if of_pos_w is pos_w and at_version == version:
                return distance
        distance = torch.linalg.vector_norm(pos_w - self.pose_command_w[:, :3], dim=1)
        self._cache = (pos_w, version, distance)
        return distance

    def _measure(self) -> None:
        super()._measure()
        metrics, distance, pos_w = self.metrics, self.object_distance, self.object.data.root_pos_w
        metrics["object_position_error"].copy_(distance)
        self._success_step = torch.where(metrics["success"] > 0, self._success_step, self._env.episode_length_buf)
        metrics["success"].masked_fill_(distance < self.cfg.success_distance, 1.0)
        low_m, high_m = self.cfg.pick_heights_m
        height_m = pos_w[:, 2]
        dropped, held = metrics["first_pick_drop"], self._held
        torch.maximum(dropped, held * (height_m < low_m), out=dropped)
        held.masked_fill_(height_m > high_m, 1.0)
        self._update_smoothness()

    def _update_smoothness(self) -> None:
        """Running means over the steps of the episode, without steps in which the physics failed."""
        joint_vel = columns(self.robot.data.joint_vel, self._joint_ids)
        moves = torch.cat((self._env.action_manager.action, joint_vel), dim=1)
        squares = torch.mm(self._per_change, (moves - self._moves).square_().t())
        self._moves.copy_(moves)
        share = self._steps.add_(1.0).reciprocal()
        failed = self._env.physics_failed
        if failed is None:
            self._smoothness.lerp_(squares, share)
        else:
            self._smoothness.copy_(torch.where(failed, self._smoothness, self._smoothness.lerp(squares, share)))


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

    _ranges: ClassVar[Ranges] = {"success_distance": POSITIVE, "pick_heights_m": SPAN}
