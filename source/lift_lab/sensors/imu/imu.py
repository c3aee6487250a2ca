"""Inertial measurement unit.

A site on the body with MuJoCo's accelerometer, gyro, velocimeter and angular acceleration sensors. Accelerations are
those of the equations of motion, where Isaac Lab takes the difference of two velocities.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import mujoco
import numpy as np
import torch

from lift_lab.utils.errors import ConfigError

from ..sensor_base import SensorBase, find_bodies_by_prim_path
from .imu_data import ImuData

if TYPE_CHECKING:
    from lift_lab.sim.physics.base import Physics

    from .imu_cfg import ImuCfg

_SENSORS = {
    "accelerometer": mujoco.mjtSensor.mjSENS_ACCELEROMETER,
    "gyro": mujoco.mjtSensor.mjSENS_GYRO,
    "velocimeter": mujoco.mjtSensor.mjSENS_VELOCIMETER,
    "frameangacc": mujoco.mjtSensor.mjSENS_FRAMEANGACC,
}


class Imu(SensorBase):
    """Accelerations and velocities of a body, as an IMU on it measures them (Isaac Lab's ``Imu``)."""

    cfg: ImuCfg

    @property
    def data(self) -> ImuData:
        """The readings."""
        return self._data

    def build(self, spec: mujoco.MjSpec, name: str, prim_paths: Mapping[str, str]) -> None:
        """Add a site and its MuJoCo sensors.

        Raises:
            ConfigError: a prim path that no body answers to, or several do.
        """
        super().build(spec, name, prim_paths)
        where = f"scene.{name}.prim_path"
        bodies = find_bodies_by_prim_path(spec, prim_paths, self.cfg.prim_path, where)
        if len(bodies) != 1:
            raise ConfigError(f"{where} '{self.cfg.prim_path}' means several bodies: {', '.join(bodies)}")
        rot = np.asarray(self.cfg.offset.rot, dtype=np.float64)
        spec.body(bodies[0]).add_site(
            name=f"{name}/imu",
            pos=list(self.cfg.offset.pos),
            quat=rot / np.linalg.norm(rot),
            group=5,
            size=[1e-3] * 3,
        )
        for kind, sensor in _SENSORS.items():
            spec.add_sensor(name=f"{name}/{kind}", type=sensor, objtype=mujoco.mjtObj.mjOBJ_SITE, objname=f"{name}/imu")

    def initialize(self, physics: Physics, env_origins_w: torch.Tensor) -> None:
        """Find the site and the sensors in the compiled model."""
        super().initialize(physics, env_origins_w)
        model = physics.model
        columns = {kind: int(model.sensor(f"{self.name}/{kind}").adr[0]) for kind in _SENSORS}
        site = model.site(f"{self.name}/imu").id
        self._data = ImuData(physics, env_origins_w, site, columns, self.cfg.gravity_bias)
        self._data.entity_name = self.name

    def reset(self, env_ids: Sequence[int] | torch.Tensor | slice | None = None) -> None:
        """Forget the accelerations of some environments: they belong to a state that is gone."""
        self._data.stepped[slice(None) if env_ids is None else env_ids] = False

    def update(self, dt: float, force_recompute: bool = False) -> None:
        """Take note that the engine has stepped."""
        if dt > 0:
            self._data.stepped.fill_(True)
