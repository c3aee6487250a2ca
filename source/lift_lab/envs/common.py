"""The camera's config and the types that environments return."""

from __future__ import annotations

from typing import ClassVar, Literal

import torch

from lift_lab.utils import ConfigBase, configclass
from lift_lab.utils.ranges import COUNT, COUNT_OR_ZERO, FINITE, Ranges

__all__ = [
    "VecEnvObs",
    "VecEnvStepReturn",
    "ViewerCfg",
]


@configclass
class ViewerCfg(ConfigBase):
    """Camera of rendered frames.

    If :attr:`eye` and :attr:`lookat` have their defaults (Isaac Lab's), the camera shows all robots and objects of the
    chosen environments, placed once at the first frame. It follows a robot whose base is free. Any other value is used
    as it is.
    """

    eye: tuple[float, float, float] = (7.5, 7.5, 7.5)
    """Position of the camera in m."""
    lookat: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Point that it looks at in m."""
    cam_prim_path: str = "/OmniverseKit_Persp"
    """Prim path of the camera. Isaac Lab's free camera is placed by :attr:`eye` and :attr:`lookat`. A camera of the
    scene is found by the last part of the path, in the environment :attr:`env_index`."""
    resolution: tuple[int, int] = (1280, 720)
    """Width and height of a frame in pixels."""
    origin_type: Literal["world", "env", "asset_root", "asset_body"] = "world"
    """Origin of :attr:`eye` and :attr:`lookat`: the origin of the environment :attr:`env_index` (``world``, ``env``),
    the root of an asset, or one of its bodies."""
    env_index: int = 0
    """The environment that is drawn, in the middle of others if :attr:`num_envs` is more than 1."""
    num_envs: int = 1
    """Environments in a frame: those nearest to the environment :attr:`env_index`. The camera steps back to see all."""
    show_rewards: bool = False
    """Whether the reward terms of the environment :attr:`env_index` are written over the frame."""
    quality: Literal["fast", "fine"] = "fast"
    """``fine``: smooth edges and sharp shadows, at about four times the cost."""
    asset_name: str | None = None
    """The asset, for ``asset_root`` and ``asset_body``."""
    body_name: str | None = None
    """The body, for ``asset_body``."""

    _ranges: ClassVar[Ranges] = {"eye lookat": FINITE, "resolution num_envs": COUNT, "env_index": COUNT_OR_ZERO}


VecEnvObs = dict[str, torch.Tensor | dict[str, torch.Tensor]]
"""Observations by group: a tensor of shape (num_envs, dim), or a dict of terms where the group keeps them apart."""

VecEnvStepReturn = tuple[VecEnvObs, torch.Tensor, torch.Tensor, torch.Tensor, dict]
"""Observations, rewards, terminated, truncated (each of shape (num_envs,)) and extras."""
