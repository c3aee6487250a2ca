"""Plan of the computations with which the warp engine keeps the fields in use current."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Literal, NamedTuple

import mujoco
import numpy as np

from .data_fields import Stage

_COLLISION_SENSORS = (
    mujoco.mjtSensor.mjSENS_CONTACT,
    mujoco.mjtSensor.mjSENS_GEOMDIST,
    mujoco.mjtSensor.mjSENS_GEOMNORMAL,
    mujoco.mjtSensor.mjSENS_GEOMFROMTO,
)


class RefreshPlan(NamedTuple):
    """Computations of a refresh besides the position kinematics; they decide which graph is launched."""

    velocity: Literal["none", "com", "all"] = "none"
    """Nothing; `cvel` and `cdof_dot` alone, which is one kernel and not ten; all that depends on velocity."""
    sensors: bool = False
    collision: bool = False
    """Some sensor in use needs contacts at the new state."""

    @classmethod
    def of(cls, stages: Mapping[str, Stage], model: mujoco.MjModel) -> RefreshPlan:
        """The least work that keeps the fields in use current.

        Args:
            stages: the stage that each of them needs.
            model: the compiled model.
        """
        velocities = {name for name, stage in stages.items() if stage == Stage.VEL}
        sensors = "sensordata" in stages
        kinds = [int(k) for k in _COLLISION_SENSORS]
        collision = np.isin(model.sensor_type, kinds) & (model.sensor_needstage < int(Stage.ACC))
        return cls(
            velocity="none" if not velocities else "com" if velocities <= {"cvel", "cdof_dot"} else "all",
            sensors=sensors,
            collision=sensors and bool(collision.any()),
        )
