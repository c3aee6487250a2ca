"""Frame transformer.

Each frame is a site of the model, so that the engine's own kinematics place it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, ClassVar

import mujoco
import numpy as np
import torch

from lift_lab.markers import VisualizationMarkers
from lift_lab.utils import math as math_utils
from lift_lab.utils.attributes import EntityData
from lift_lab.utils.errors import ConfigError
from lift_lab.utils.string import resolve_matching_names

from ..sensor_base import SensorBase, body_prim_path, find_bodies_by_prim_path, has_engine_order

if TYPE_CHECKING:
    from lift_lab.sim.physics.base import Physics

    from .frame_transformer_cfg import FrameTransformerCfg, OffsetCfg


class FrameTransformerData(EntityData):
    """Readings. F is the number of target frames; computed on demand from the current kinematics."""

    unsaved_attributes: ClassVar[frozenset[str]] = frozenset(
        {"_origins_w", "_source", "_target_origins_w", "_targets", "target_frame_names"}
    )

    def __init__(self, physics: Physics, origins_w: torch.Tensor, source: int, targets: list[int], names: list[str]):
        self._physics = physics
        self._origins_w = origins_w
        self._target_origins_w = origins_w[:, None]
        self._source = source
        contiguous = targets == list(range(targets[0], targets[0] + len(targets)))
        self._targets: slice | torch.Tensor = torch.tensor(targets, device=physics.device)
        if contiguous:
            self._targets = slice(targets[0], targets[0] + len(targets))
        self.target_frame_names = names
        """Names of the target frames, in the order of all readings of them."""

    @property
    def source_pos_w(self) -> torch.Tensor:
        """Position of the source frame in m, shape (num_envs, 3)."""
        return self._physics.current("site_xpos")[:, self._source] + self._origins_w

    @property
    def source_quat_w(self) -> torch.Tensor:
        """Orientation of the source frame (w, x, y, z), shape (num_envs, 4)."""
        return self._quat(self._physics.current("site_xmat")[:, self._source])

    @property
    def target_pos_w(self) -> torch.Tensor:
        """Positions of the target frames in m, shape (num_envs, F, 3)."""
        return self._physics.current("site_xpos")[:, self._targets] + self._target_origins_w

    @property
    def target_quat_w(self) -> torch.Tensor:
        """Orientations of the target frames (w, x, y, z), shape (num_envs, F, 4)."""
        return self._quat(self._physics.current("site_xmat")[:, self._targets])

    @property
    def target_pos_source(self) -> torch.Tensor:
        """Positions of the target frames in the source frame in m, shape (num_envs, F, 3)."""
        offset_w = self.target_pos_w - self.source_pos_w[:, None]
        quat = self.source_quat_w[:, None].expand(-1, offset_w.shape[1], -1)
        return math_utils.quat_apply_inverse(quat, offset_w)

    @property
    def target_quat_source(self) -> torch.Tensor:
        """Orientations of the target frames in the source frame (w, x, y, z), shape (num_envs, F, 4)."""
        target = self.target_quat_w
        source = self.source_quat_w[:, None].expand_as(target)
        return math_utils.quat_mul(math_utils.quat_inv(source), target)

    @staticmethod
    def _quat(mat: torch.Tensor) -> torch.Tensor:
        return math_utils.quat_from_matrix(mat.reshape(*mat.shape[: mat.ndim - (1 if mat.shape[-1] == 9 else 2)], 3, 3))


class FrameTransformer(SensorBase):
    """Poses of target frames relative to a source frame (Isaac Lab's ``FrameTransformer``).

    As in Isaac Lab, target frames are sorted by the prim paths of their bodies. Frames of one body keep the order of
    the config, and all do where the articulation of the source frame has ``index_order="engine"``.
    """

    unsaved_attributes: ClassVar[frozenset[str]] = frozenset({"_names"})

    cfg: FrameTransformerCfg

    @property
    def data(self) -> FrameTransformerData:
        """The readings."""
        return self._data

    @property
    def num_bodies(self) -> int:
        """Number of target frames."""
        return len(self._names)

    @property
    def body_names(self) -> list[str]:
        """Names of the target frames."""
        return self._names

    def find_bodies(self, name_keys: str | Sequence[str], preserve_order: bool = False) -> tuple[list[int], list[str]]:
        """Indices and names of the target frames that match regular expressions."""
        return resolve_matching_names(name_keys, self._names, preserve_order)

    def build(self, spec: mujoco.MjSpec, name: str, prim_paths: Mapping[str, str]) -> None:
        """Add a site for the source frame and one for each target frame.

        Raises:
            ConfigError: no target frame, a prim path that no body answers to, or a source path that several do.
        """
        super().build(spec, name, prim_paths)
        where = f"scene.{name}"
        sources = find_bodies_by_prim_path(spec, prim_paths, self.cfg.prim_path, f"{where}.prim_path")
        if len(sources) != 1:
            raise ConfigError(f"{where}.prim_path '{self.cfg.prim_path}' means several bodies: {', '.join(sources)}")
        self._add_site(spec, sources[0], "source", self.cfg.source_frame_offset)
        if not self.cfg.target_frames:
            raise ConfigError(f"{where}.target_frames is empty: there is no frame to tell the pose of")
        found: list[tuple[str, str, OffsetCfg]] = []
        for i, frame in enumerate(self.cfg.target_frames):
            bodies = find_bodies_by_prim_path(
                spec, prim_paths, frame.prim_path, f"{where}.target_frames[{i}].prim_path"
            )
            for body in bodies:
                leaf = body.rsplit("/", 1)[-1]
                label = frame.name if frame.name is not None and len(bodies) == 1 else leaf
                found.append((label, body, frame.offset))
        if not has_engine_order(prim_paths, sources[0]):
            found.sort(key=lambda frame: body_prim_path(prim_paths, frame[1]))
        self._names: list[str] = []
        for label, body, offset in found:
            self._add_site(spec, body, f"target{len(self._names)}", offset)
            self._names.append(label)

    def _add_site(self, spec: mujoco.MjSpec, body: str, label: str, offset: OffsetCfg) -> None:
        rot = np.asarray(offset.rot, dtype=np.float64)
        spec.body(body).add_site(
            name=f"{self.name}/{label}",
            pos=list(offset.pos),
            quat=rot / np.linalg.norm(rot),
            group=5,
            size=[1e-3] * 3,
        )

    def initialize(self, physics: Physics, env_origins_w: torch.Tensor) -> None:
        """Find the frames' sites in the compiled model."""
        super().initialize(physics, env_origins_w)
        model = physics.model
        source = model.site(f"{self.name}/source").id
        targets = [model.site(f"{self.name}/target{i}").id for i in range(len(self._names))]
        self._data = FrameTransformerData(physics, env_origins_w, source, targets, self._names)
        self._data.entity_name = self.name

    def _set_debug_vis_impl(self, debug_vis: bool) -> None:
        if not hasattr(self, "frame_visualizer"):
            self.frame_visualizer = VisualizationMarkers(self.cfg.visualizer_cfg)
        self.frame_visualizer.set_visibility(debug_vis)

    def _debug_vis_callback(self, event: Any) -> None:
        """Axes at the source and the targets and, where the markers have a second shape, lines between them."""
        data, count = self.data, len(self._names)
        source_w = data.source_pos_w[:, None].expand(-1, count, -1).reshape(-1, 3)
        target_w = data.target_pos_w.reshape(-1, 3)
        positions = torch.cat((data.source_pos_w, target_w))
        quats = torch.cat((data.source_quat_w, data.target_quat_w.reshape(-1, 4)))
        scales = torch.ones_like(positions)
        indices = torch.zeros(len(positions), dtype=torch.long)
        if self.frame_visualizer.num_prototypes > 1:
            between_w = target_w - source_w
            length = between_w.norm(dim=-1, keepdim=True)
            line_scales = torch.cat((torch.ones_like(between_w[:, :2]), length), dim=1)
            positions = torch.cat((positions, (source_w + target_w) / 2))
            quats = torch.cat((quats, _quat_of_z_axis(between_w / length.clamp(min=1e-9))))
            scales = torch.cat((scales, line_scales))
            indices = torch.cat((indices, torch.ones(len(between_w), dtype=torch.long)))
        self.frame_visualizer.visualize(positions, quats, scales, indices)


def _quat_of_z_axis(direction: torch.Tensor) -> torch.Tensor:
    """Shortest rotations (w, x, y, z) that bring the z axis to unit vectors of shape (n, 3)."""
    x, y, z = direction.unbind(-1)
    quat = torch.stack((1.0 + z, -y, x, torch.zeros_like(z)), dim=-1)
    norm = quat.norm(dim=-1, keepdim=True)
    half_turn = torch.tensor((0.0, 1.0, 0.0, 0.0), device=direction.device).expand_as(quat)
    return torch.where(norm > 1e-6, quat / norm.clamp(min=1e-6), half_turn)
