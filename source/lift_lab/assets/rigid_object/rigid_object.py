"""A rigid object."""

from __future__ import annotations

from typing import TYPE_CHECKING

import mujoco

from lift_lab.utils.errors import ConfigError

from ..body_asset import BodyAsset
from .rigid_object_data import RigidObjectData

if TYPE_CHECKING:
    from .rigid_object_cfg import RigidObjectCfg


class RigidObject(BodyAsset):
    """One rigid body, free or kinematic. Its body is named after the prim path's last part (as in Isaac Lab)."""

    cfg: RigidObjectCfg
    _data: RigidObjectData

    @property
    def data(self) -> RigidObjectData:
        """The object's state."""
        return self._data

    def _edit_spec(self, spec: mujoco.MjSpec) -> None:
        roots = list(spec.worldbody.bodies)
        if len(roots) != 1 or len(list(spec.bodies)) != 2:
            names = ", ".join(b.name for b in spec.bodies if b.name != "world") or "none"
            raise ConfigError(
                f"scene.{self.name}: a rigid object has exactly one rigid body, '{self.cfg.prim_path}' has: {names}"
            )
        root = roots[0]
        if not root.mocap and not list(root.joints):
            raise ConfigError(
                f"scene.{self.name}: '{self.cfg.prim_path}' is no rigid body but fixed to the world: set rigid_props "
                "(sim_utils.RigidBodyPropertiesCfg()) of its spawn; a thing that never moves is an AssetBaseCfg"
            )
        old, new = root.name, self.prim_name
        root.name = new
        for exclude in spec.excludes:
            exclude.bodyname1 = new if exclude.bodyname1 == old else exclude.bodyname1
            exclude.bodyname2 = new if exclude.bodyname2 == old else exclude.bodyname2

    def _make_data(self) -> None:
        self._data = RigidObjectData(
            self._physics,
            self._env_origins_w,
            self._ids,
            self._body_names,
            self._qadr,
            self._vadr,
            self._mocap,
        )
