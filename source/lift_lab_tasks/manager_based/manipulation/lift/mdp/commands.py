"""The lift task's command: a pose for the object, near goals that were missed where a curriculum asks for it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import torch

from lift_lab.envs.mdp import UniformPoseCommand, UniformPoseCommandCfg
from lift_lab.envs.mdp.sampling import range_limits, sample_ranges
from lift_lab.utils import configclass

if TYPE_CHECKING:
    from lift_lab.envs import ManagerBasedRLEnv


class ObjectPoseCommand(UniformPoseCommand):
    """A uniform pose command, which can replay goals that were missed."""

    cfg: ObjectPoseCommandCfg

    def __init__(self, cfg: ObjectPoseCommandCfg, env: ManagerBasedRLEnv):
        super().__init__(cfg, env)
        self._missed_goals: tuple[torch.Tensor, torch.Tensor] | None = None
        self._replay_share, self._replay_spread_m = 0.0, 0.0

    def replay_missed_goals(self, goals_b: torch.Tensor, missed: torch.Tensor, share: float, spread_m: float) -> None:
        """Let a share of the coming goals be near one of these.

        The others are uniform, and all of them while none was missed. The command's ranges hold for every goal. The
        means of the metrics leave out the episodes with such a goal: they are of the task itself.

        Args:
            goals_b: positions in the robot's root frame in m, shape (n, 3); kept, not copied, as is the next.
            missed: 1 for a goal that was missed and 0 for one that was reached, shape (n,).
            share: of the coming goals, within [0, 1]; with 0 nothing more is drawn than without this call.
            spread_m: how far a goal may lie from the missed one along each axis.
        """
        self._missed_goals = (goals_b, missed)
        self._replay_share, self._replay_spread_m = share, spread_m

    def _choose_positions(self, env_ids: torch.Tensor, uniform_b: torch.Tensor) -> torch.Tensor:
        if self._missed_goals is None or self._replay_share == 0.0:
            return uniform_b
        goals_b, missed = self._missed_goals
        count, r, furthest = len(env_ids), self.cfg.ranges, self._replay_spread_m
        picked = torch.multinomial(missed + 1e-6, count, replacement=True)
        spread = sample_ranges([(-furthest, furthest)] * 3, count, self.device)
        low, high = range_limits((r.pos_x, r.pos_y, r.pos_z), self.device)
        again = torch.clamp(goals_b[picked] + spread, low, high)
        taken = (torch.rand(count, device=self.device) < self._replay_share) & (missed[picked] > 0)
        self._env.metrics_manager.leave_out(env_ids, taken)
        return torch.where(taken.unsqueeze(1), again, uniform_b)


@configclass
class ObjectPoseCommandCfg(UniformPoseCommandCfg):
    """Config of :class:`ObjectPoseCommand`."""

    class_type: type = ObjectPoseCommand
