"""Frames of an environment for a renderer: state, markers, figures, and the pose of the camera."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import mujoco
import numpy as np
import torch

from lift_lab.drawing.film import Film, model_bytes
from lift_lab.drawing.framing import View, corners, fit, moving_geoms
from lift_lab.drawing.opengl import DrawError
from lift_lab.drawing.scene import Picture, find_camera
from lift_lab.drawing.shapes import Placed
from lift_lab.markers import VisualizationMarkers
from lift_lab.sim.rendering import RenderView
from lift_lab.utils.errors import ConfigError, suggest

from .common import ViewerCfg

if TYPE_CHECKING:
    from .manager_based_env import ManagerBasedEnv

_FREE_CAMERA = "OmniverseKit_Persp"
_WIDER = 1.5
"""How much further the camera stands back for each m that the environments in a frame are spread."""


@dataclass
class Frame:
    """The state at one moment, still on the environment's device: nothing waits for it."""

    qpos: torch.Tensor
    """Joint positions of the environments in the frame, shape (n, nq)."""
    mocap_pos: torch.Tensor
    """Shape (n, nmocap, 3)."""
    mocap_quat: torch.Tensor
    """Shape (n, nmocap, 4)."""
    followed_w: torch.Tensor | None
    """Position of the camera's target in m, shape (3,)."""
    markers: list[tuple[VisualizationMarkers, tuple[torch.Tensor, ...]]]
    """Groups that are shown, with positions, orientations, scales and shape numbers of their instances."""
    figures: torch.Tensor | None
    """Age of the episode in steps, its return, and the value of each reward term, shape (2 + terms,)."""


class FrameCapture:
    """Takes frames of the environments that ``env.cfg.viewer`` names."""

    def __init__(self, env: ManagerBasedEnv, resolution: tuple[int, int] | None = None):
        """Choose environments and camera.

        Args:
            env: the environment.
            resolution: width and height of a frame in pixels; None for the viewer's.

        Raises:
            ConfigError: the viewer names an environment, origin, asset, body or camera that does not exist.
        """
        self._env, self._viewer = env, env.cfg.viewer.copy()
        viewer = self._viewer
        viewer.resolution = viewer.resolution if resolution is None else resolution
        if not 0 <= viewer.env_index < env.num_envs:
            raise ConfigError(f"viewer.env_index {viewer.env_index} is not within the {env.num_envs} environments")
        if not 1 <= viewer.num_envs <= env.num_envs:
            raise ConfigError(f"viewer.num_envs {viewer.num_envs} is not within the {env.num_envs} environments")
        self._centre_w = env.scene.env_origins[viewer.env_index]
        """The origin of the frame."""
        offsets = (env.scene.env_origins - self._centre_w).cpu()
        distances = offsets.norm(dim=1)
        distances[viewer.env_index] = -1.0  # the one that the viewer names comes first
        chosen = distances.argsort(stable=True)[: viewer.num_envs]
        self.env_ids: tuple[int, ...] = tuple(chosen.tolist())
        self.origins: np.ndarray = offsets[chosen].numpy()
        """Where each environment stands in the frame in m, shape (n, 3)."""
        self._half_cell = _half_cell(offsets, chosen)
        self._middle = self.origins.mean(axis=0)
        self._spread = float(np.linalg.norm(self.origins - self._middle, axis=1).max())
        default = ViewerCfg()
        self._frames_scene = (*viewer.eye, *viewer.lookat) == (*default.eye, *default.lookat)
        self._framed: tuple[View, np.ndarray] | None = None
        self._follow = _followed(env) or (_floating_robot(env) if self._frames_scene else None)
        self._rows: dict[tuple[int, int], torch.Tensor] = {}
        if math.dist(viewer.eye, viewer.lookat) == 0.0:
            raise ConfigError(f"viewer.eye and viewer.lookat are the same point {tuple(viewer.eye)}")
        leaf = viewer.cam_prim_path.rstrip("/").rsplit("/", 1)[-1]
        self.camera: str | None = None if leaf in ("", _FREE_CAMERA) else leaf
        """Name of the model's camera that sees, or None."""
        try:
            find_camera(env.sim.model, self.camera)
        except DrawError as error:
            raise ConfigError(f"viewer.cam_prim_path: {error}") from error

    def fits(self, viewer: ViewerCfg) -> bool:
        """Whether frames are taken as a config says."""
        return self._viewer == viewer

    def frame(self) -> Frame:
        """The current frame."""
        env = self._env
        update_markers(env)
        ids = list(self.env_ids)
        state = (env.sim.physics.field(name)[ids] for name in ("qpos", "mocap_pos", "mocap_quat"))
        markers = []
        for group in VisualizationMarkers.of(env.sim):
            if group.is_visible() and group.count:
                rows = self._rows_of(group)
                fields = (group.positions_w, group.quats_w, group.scales, group.marker_indices)
                markers.append((group, tuple(values[rows.to(values.device)] for values in fields)))
        followed = None if self._follow is None else self._follow() - self._centre_w
        return Frame(*state, followed_w=followed, markers=markers, figures=self._figures())

    def picture(self, frame: Frame) -> Picture:
        """The picture of a frame, on the CPU."""
        placed = []
        centre = self._centre_w.cpu().numpy()
        for group, fields in frame.markers:
            positions, quats, scales, numbers = (values.cpu().numpy() for values in fields)
            for number, shape in enumerate(group.primitives):
                here = numbers == number
                if shape and here.any():
                    placed.append(Placed(shape, positions[here] - centre, quats[here], scales[here]))
        return Picture(
            frame.qpos.cpu().numpy(),
            frame.mocap_pos.cpu().numpy(),
            frame.mocap_quat.cpu().numpy(),
            self._view(frame),
            placed,
            self._lines(frame),
        )

    def film(self, frames: list[Frame], fps: float) -> Film:
        """A film of frames."""
        width, height = self._viewer.resolution
        return Film(
            model_bytes(self._env.sim.model),
            width,
            height,
            fps,
            self.origins,
            self.camera,
            self._viewer.quality == "fine",
            [self.picture(frame) for frame in frames],
        )

    def _view(self, frame: Frame) -> View:
        return self._framing_view(frame) if self._frames_scene else self._given_view(frame)

    def _framing_view(self, frame: Frame) -> View:
        """The view that shows robots and objects as they stand in the first frame; it moves on with what it follows."""
        followed = np.zeros(3) if frame.followed_w is None else frame.followed_w.cpu().numpy()
        if self._framed is None:
            width, height = self._viewer.resolution
            visual: Any = self._env.sim.model.vis
            view = fit(self._points(frame), width / height, visual.global_.fovy)
            self._framed = view, followed
        view, start = self._framed
        x, y, z = np.asarray(view.lookat) + followed - start
        return dataclasses.replace(view, lookat=(float(x), float(y), float(z)))

    def _points(self, frame: Frame) -> np.ndarray:
        """Corners of the boxes around what the camera frames, in the frame's coordinates in m, shape (n, 3)."""
        model = self._env.sim.model
        data, geoms = mujoco.MjData(model), moving_geoms(model)
        qpos, mocap_pos, mocap_quat = (t.cpu().numpy() for t in (frame.qpos, frame.mocap_pos, frame.mocap_quat))
        points = []
        for k, origin in enumerate(self.origins):
            data.qpos[:], data.mocap_pos[:], data.mocap_quat[:] = qpos[k], mocap_pos[k], mocap_quat[k]
            mujoco.mj_kinematics(model, data)
            mujoco.mj_flex(model, data)
            points.append(corners(model, data, geoms) + origin)
        return np.concatenate(points) if points[0].size else np.array([[-0.5, -0.5, 0.0], [0.5, 0.5, 0.5]])

    def _given_view(self, frame: Frame) -> View:
        viewer = self._viewer
        origin = (0.0, 0.0, 0.0) if frame.followed_w is None else frame.followed_w.tolist()
        lookat = [o + p + float(m) for o, p, m in zip(origin, viewer.lookat, self._middle, strict=True)]
        ahead = [p - e for e, p in zip(viewer.eye, viewer.lookat, strict=True)]
        distance = math.hypot(*ahead)
        return View(
            lookat=(lookat[0], lookat[1], lookat[2]),
            distance=distance + _WIDER * self._spread,
            azimuth_deg=math.degrees(math.atan2(ahead[1], ahead[0])),
            elevation_deg=math.degrees(math.asin(ahead[2] / distance)),
        )

    # -- figures over the picture

    def _figures(self) -> torch.Tensor | None:
        env: Any = self._env
        if not self._viewer.show_rewards or not hasattr(env, "reward_manager"):
            return None
        index, manager = self._viewer.env_index, env.reward_manager
        head = torch.stack((env.episode_length_buf[index].float(), manager.term_sums[:, index].sum()))
        return torch.cat((head, manager.term_values[:, index]))

    def _lines(self, frame: Frame) -> list[tuple[str, str]]:
        if frame.figures is None:
            return []
        env: Any = self._env
        (age, total), values = frame.figures[:2].tolist(), frame.figures[2:].tolist()
        manager = env.reward_manager
        lines = [("time", f"{age * env.step_dt:.2f} s"), ("return", f"{total:.2f}")]
        for name, value in zip(manager.active_terms, values, strict=True):
            lines.append((name, f"{value * manager.get_term_cfg(name).weight:.3f}"))
        return lines

    # -- which markers belong to the frame

    def _rows_of(self, group: VisualizationMarkers) -> torch.Tensor:
        """Instances of a group that belong to the environments in the frame.

        One for each environment: by its number. Else those that stand in the environments' cells when this group is
        first seen.
        """
        key = id(group), group.count
        if key not in self._rows:
            if group.count == self._env.num_envs:
                self._rows[key] = torch.tensor(self.env_ids)
            else:
                origins = torch.from_numpy(self.origins)
                offsets = (group.positions_w - self._centre_w).cpu().unsqueeze(1) - origins
                near = (offsets[..., :2].abs() <= self._half_cell).all(dim=2).any(dim=1)
                self._rows[key] = near.nonzero().flatten()
        return self._rows[key]


def _floating_robot(env: ManagerBasedEnv) -> Any:
    """Where the first robot is that is not fixed to the world: a function that returns its position, or None."""
    for robot in env.scene.articulations.values():
        if not robot.is_fixed_base:
            return lambda: robot.data.root_pos_w[env.cfg.viewer.env_index]
    return None


def render_view(env: ManagerBasedEnv, capture: FrameCapture) -> RenderView:
    """The view of an environment's current state, with the markers of everything that has ``debug_vis``."""
    picture = capture.picture(capture.frame())
    width, height = env.cfg.viewer.resolution
    return RenderView(
        **vars(picture.view),
        env_ids=capture.env_ids,
        origins=capture.origins,
        camera=capture.camera,
        width=width,
        height=height,
        fine=env.cfg.viewer.quality == "fine",
        markers=picture.markers,
        lines=picture.lines,
    )


def update_markers(env: Any) -> None:
    """Move the markers of commands, actions, sensors and terrain to the current state."""
    with env.sim.as_current():  # terms make their markers in the current simulation
        for name in ("command_manager", "action_manager"):
            if hasattr(env, name):
                getattr(env, name).update_debug_vis()
        for sensor in env.scene.sensors.values():
            sensor.update_debug_vis()
        if env.scene.terrain is not None:
            env.scene.terrain.update_debug_vis()


def _half_cell(offsets: torch.Tensor, chosen: torch.Tensor) -> float:
    """Half the distance in m from the environments in the frame to their nearest neighbour."""
    apart = torch.cdist(offsets[chosen], offsets).flatten()
    apart = apart[apart > 1e-6]
    return float(apart.min()) / 2 if len(apart) else math.inf


def _followed(env: ManagerBasedEnv) -> Any:
    """What eye and lookat are relative to: a function that returns its position in the world, or None."""
    viewer = env.cfg.viewer
    kinds = ("world", "env", "asset_root", "asset_body")
    if viewer.origin_type not in kinds:
        raise ConfigError(f"viewer.origin_type: unknown '{viewer.origin_type}': {suggest(viewer.origin_type, kinds)}")
    if viewer.origin_type in ("world", "env"):
        return None
    assets = {**env.scene.articulations, **env.scene.rigid_objects}
    if viewer.asset_name not in assets:
        name = str(viewer.asset_name)
        raise ConfigError(f"viewer.asset_name: the scene has no moving asset '{name}': {suggest(name, assets)}")
    asset, index = assets[viewer.asset_name], viewer.env_index
    if viewer.origin_type == "asset_root":
        return lambda: asset.data.root_pos_w[index]
    if viewer.body_name not in asset.body_names:
        name = str(viewer.body_name)
        raise ConfigError(
            f"viewer.body_name: '{viewer.asset_name}' has no body '{name}': {suggest(name, asset.body_names)}"
        )
    body = asset.body_names.index(viewer.body_name)
    return lambda: asset.data.body_pos_w[index, body]
