"""Event terms that push assets while they move."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Annotated

from lift_lab.managers import SceneEntityCfg
from lift_lab.utils import math as math_utils
from lift_lab.utils.indexing import EnvIds, block, num_rows
from lift_lab.utils.ranges import SPAN

from ..sampling import axis_ranges, sample_ranges

if TYPE_CHECKING:
    from lift_lab.assets import Articulation, RigidObject
    from lift_lab.envs import ManagerBasedEnv

__all__ = [
    "apply_external_force_torque",
    "push_by_setting_velocity",
]


def apply_external_force_torque(
    env: ManagerBasedEnv,
    env_ids: EnvIds,
    force_range: Annotated[tuple[float, float], SPAN],
    torque_range: Annotated[tuple[float, float], SPAN],
    asset_cfg: SceneEntityCfg = SceneEntityCfg("robot"),
) -> None:
    """Set external forces and torques on the chosen bodies, each component drawn uniformly.

    They stay until they are set again or the asset is reset, and act from the next physics step on.

    Args:
        env: the environment.
        env_ids: environments to push.
        force_range: (low, high) of each force component in N, body frame.
        torque_range: (low, high) of each torque component in N m, body frame.
        asset_cfg: the asset and which of its bodies.
    """
    asset: RigidObject | Articulation = env.scene[asset_cfg.name]
    body_ids = asset_cfg.body_ids
    num_bodies = asset.num_bodies if isinstance(body_ids, slice) else len(body_ids)
    count = num_rows(env_ids, env.num_envs)
    size = (count, num_bodies, 3)
    forces = math_utils.sample_uniform(*force_range, size, env.device)
    torques = math_utils.sample_uniform(*torque_range, size, env.device)
    asset.set_external_force_and_torque(forces, torques, body_ids=body_ids, env_ids=env_ids)


def push_by_setting_velocity(
    env: ManagerBasedEnv,
    env_ids: EnvIds,
    velocity_range: Annotated[Mapping[str, Sequence[float]], SPAN],
    asset_cfg: SceneEntityCfg = SceneEntityCfg("robot"),
) -> None:
    """Add a uniformly drawn velocity to the asset's root, as a push would.

    Args:
        env: the environment.
        env_ids: environments to push.
        velocity_range: (low, high) for any of ``x, y, z`` (m/s) and ``roll, pitch, yaw`` (rad/s), world frame.
        asset_cfg: the asset.

    Raises:
        ConfigError: the range names an axis that does not exist.
    """
    asset: RigidObject | Articulation = env.scene[asset_cfg.name]
    velocity = block(asset.data.root_vel_w, env_ids)
    ranges = axis_ranges(velocity_range, "push_by_setting_velocity: velocity_range")
    velocity += sample_ranges(ranges, len(velocity), env.device)
    asset.write_root_velocity_to_sim(velocity, env_ids=env_ids)
