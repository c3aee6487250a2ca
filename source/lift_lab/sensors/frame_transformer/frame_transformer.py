"""Frame transformer.

Each frame is a site of the model, so that the engine's own kinematics place it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import mujoco
import numpy as np
import torch

from lift_lab.utils import math as math_utils
from lift_lab.utils.errors import ConfigError
from lift_lab.utils.string import resolve_matching_names

from ..sensor_base import SensorBase, find_bodies_by_prim_path

if TYPE_CHECKING:
    from lift_lab.assets import Articulation, RigidObject
    from lift_lab.sim.physics.base import Physics

    from .frame_transformer_cfg import FrameTransformerCfg, OffsetCfg


class FrameTransformerData:
    """Readings. F is the number of target frames; computed on demand from the current kinematics."""

    def __init__(self, physics: Physics, origins_w: torch.Tensor, source: int, targets: list[int], names: list[str]):
        self._physics = physics
        self._origins_w = origins_w
        self._source = source
        contiguous = targets == list(range(targets[0], targets[0] + len(targets)))
        self._targets = slice(targets[0], targets[0] + len(targets)) if contiguous else targets
        self.target_frame_names = names
        """Names of the target frames, in config order."""

    @property
    def source_pos_w(self) -> torch.Tensor:
        """Position of the source frame in m, shape (num_envs, 3)."""
        return self._physics.field("site_xpos")[:, self._source] + self._origins_w

    @property
    def source_quat_w(self) -> torch.Tensor:
        """Orientation of the source frame (w, x, y, z), shape (num_envs, 4)."""
        return self._quat(self._physics.field("site_xmat")[:, self._source])

    @property
    def target_pos_w(self) -> torch.Tensor:
        """Positions of the target frames in m, shape (num_envs, F, 3)."""
        return self._physics.field("site_xpos")[:, self._targets] + self._origins_w[:, None]

    @property
    def target_quat_w(self) -> torch.Tensor:
        """Orientations of the target frames (w, x, y, z), shape (num_envs, F, 4)."""
        return self._quat(self._physics.field("site_xmat")[:, self._targets])

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
    """Poses of target frames relative to a source frame (Isaac Lab's ``FrameTransformer``)."""

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

    def build(self, spec: mujoco.MjSpec, name: str, assets: Mapping[str, Articulation | RigidObject]) -> None:
        """Add a site for the source frame and one for each target frame.

        Raises:
            ConfigError: a prim path that no body answers to, or a source path that several do.
        """
        super().build(spec, name, assets)
        where = f"scene.{name}"
        sources = find_bodies_by_prim_path(spec, assets, self.cfg.prim_path, f"{where}.prim_path")
        if len(sources) != 1:
            raise ConfigError(f"{where}.prim_path '{self.cfg.prim_path}' means several bodies: {', '.join(sources)}")
        self._add_site(spec, sources[0], "source", self.cfg.source_frame_offset)
        self._names: list[str] = []
        for i, frame in enumerate(self.cfg.target_frames):
            bodies = find_bodies_by_prim_path(spec, assets, frame.prim_path, f"{where}.target_frames[{i}].prim_path")
            for body in bodies:
                leaf = body.rsplit("/", 1)[-1]
                label = frame.name if frame.name is not None and len(bodies) == 1 else leaf
                self._add_site(spec, body, f"target{len(self._names)}", frame.offset)
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
