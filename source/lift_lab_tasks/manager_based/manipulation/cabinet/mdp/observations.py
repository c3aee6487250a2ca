"""Observations of the cabinet task."""

from __future__ import annotations

from typing import TYPE_CHECKING

import torch

from lift_lab.utils.io_descriptors import generic_io_descriptor
from lift_lab.utils.math import quat_unique

if TYPE_CHECKING:
    from lift_lab.envs import ManagerBasedRLEnv
    from lift_lab.sensors import FrameTransformer


_XYZ = ["X", "Y", "Z"]


@generic_io_descriptor(units="m", axes=_XYZ, observation_type="Sensor")
def rel_ee_drawer_distance(env: ManagerBasedRLEnv) -> torch.Tensor:
    """Way from the tool centre to the handle in m, world axes, shape (num_envs, 3)."""
    tool: FrameTransformer = env.scene["ee_frame"]
    handle: FrameTransformer = env.scene["cabinet_frame"]
    return handle.data.target_pos_w[:, 0] - tool.data.target_pos_w[:, 0]


@generic_io_descriptor(units="m", observation_type="Sensor")
def fingertips_pos(env: ManagerBasedRLEnv) -> torch.Tensor:
    """Positions of the fingertips in the environment's frame in m, shape (num_envs, 3 * fingertips)."""
    tool: FrameTransformer = env.scene["ee_frame"]
    return (tool.data.target_pos_w[:, 1:] - env.scene.env_origins[:, None]).flatten(start_dim=1)


@generic_io_descriptor(units="m", axes=_XYZ, observation_type="Sensor")
def ee_pos(env: ManagerBasedRLEnv) -> torch.Tensor:
    """Position of the tool centre in the environment's frame in m, shape (num_envs, 3)."""
    tool: FrameTransformer = env.scene["ee_frame"]
    return tool.data.target_pos_w[:, 0] - env.scene.env_origins


@generic_io_descriptor(units="unit", axes=["W", "X", "Y", "Z"], observation_type="Sensor")
def ee_quat(env: ManagerBasedRLEnv, make_quat_unique: bool = True) -> torch.Tensor:
    """Orientation of the tool centre (w, x, y, z), with a real part >= 0 if so asked. Shape (num_envs, 4)."""
    tool: FrameTransformer = env.scene["ee_frame"]
    quat = tool.data.target_quat_w[:, 0]
    return quat_unique(quat) if make_quat_unique else quat
