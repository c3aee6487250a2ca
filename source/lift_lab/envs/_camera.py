"""From an environment's viewer config to what the renderer draws."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import torch

from lift_lab.sim.rendering import RenderView
from lift_lab.utils.errors import ConfigError, suggest

if TYPE_CHECKING:
    from .manager_based_env import ManagerBasedEnv

_GOAL_RADIUS_M = 0.015
_GOAL_RGBA = (0.1, 0.8, 0.2, 0.6)


def render_view(env: ManagerBasedEnv) -> RenderView:
    """The view that ``env.cfg.viewer`` asks for, with the goals of commands that have ``debug_vis``.

    Raises:
        ConfigError: the viewer names an environment, origin, asset or body that does not exist.
    """
    viewer = env.cfg.viewer
    if not 0 <= viewer.env_index < env.num_envs:
        raise ConfigError(f"viewer.env_index {viewer.env_index} is not within the {env.num_envs} environments")
    origin_e = _origin_e(env)
    lookat = [o + p for o, p in zip(origin_e, viewer.lookat, strict=True)]
    ahead = [p - e for e, p in zip(viewer.eye, viewer.lookat, strict=True)]
    distance = math.hypot(*ahead)
    if distance == 0.0:
        raise ConfigError(f"viewer.eye and viewer.lookat are the same point {tuple(viewer.eye)}")
    width, height = viewer.resolution
    return RenderView(
        env_ids=(viewer.env_index,),
        lookat=(lookat[0], lookat[1], lookat[2]),
        distance=distance,
        azimuth_deg=math.degrees(math.atan2(ahead[1], ahead[0])),
        elevation_deg=math.degrees(math.asin(ahead[2] / distance)),
        width=width,
        height=height,
        markers=[(_to_env(env, goal).numpy(), _GOAL_RADIUS_M, _GOAL_RGBA) for goal in _goals_w(env)],
    )


def _to_env(env: ManagerBasedEnv, position_w: torch.Tensor) -> torch.Tensor:
    """Position of the drawn environment, shape (3,), without the environment's origin."""
    index = env.cfg.viewer.env_index
    return (position_w[index] - env.scene.env_origins[index]).cpu()


def _goals_w(env: ManagerBasedEnv) -> list[torch.Tensor]:
    """Goal positions to draw, each of shape (num_envs, 3)."""
    commands = getattr(env, "command_manager", None)
    if commands is None:
        return []
    terms = [commands.get_term(name) for name in commands.active_terms]
    return [term.goal_pos_w for term in terms if term.cfg.debug_vis and hasattr(term, "goal_pos_w")]


def _origin_e(env: ManagerBasedEnv) -> list[float]:
    """What eye and lookat are relative to, in the drawn environment."""
    viewer = env.cfg.viewer
    kinds = ("world", "env", "asset_root", "asset_body")
    if viewer.origin_type not in kinds:
        raise ConfigError(f"viewer.origin_type: unknown '{viewer.origin_type}': {suggest(viewer.origin_type, kinds)}")
    if viewer.origin_type in ("world", "env"):
        return [0.0, 0.0, 0.0]
    assets = {**env.scene.articulations, **env.scene.rigid_objects}
    if viewer.asset_name not in assets:
        name = str(viewer.asset_name)
        raise ConfigError(f"viewer.asset_name: the scene has no moving asset '{name}': {suggest(name, assets)}")
    asset = assets[viewer.asset_name]
    if viewer.origin_type == "asset_root":
        return _to_env(env, asset.data.root_pos_w).tolist()
    if viewer.body_name not in asset.body_names:
        name = str(viewer.body_name)
        raise ConfigError(
            f"viewer.body_name: '{viewer.asset_name}' has no body '{name}': {suggest(name, asset.body_names)}"
        )
    return _to_env(env, asset.data.body_pos_w[:, asset.body_names.index(viewer.body_name)]).tolist()
