"""Fields of MjData that the engines serve, and how much of the forward dynamics each needs."""

from __future__ import annotations

from enum import IntEnum

import mujoco

from .model_fields import words


class Stage(IntEnum):
    """Stage of the forward dynamics that a field needs; the values are MuJoCo's `mjtStage`."""

    NONE = 0
    """A state field: needs nothing."""
    POS = 1
    """Depends on positions: current after step() and refresh()."""
    VEL = 2
    """Depends on velocities too: current after step() and refresh() once any such field is bound."""
    ACC = 3
    """Depends on forces: after step() it belongs to the last substep; forward() makes it current."""


STATE_FIELDS = words("time qpos qvel act ctrl qfrc_applied xfrc_applied mocap_pos mocap_quat")
"""Fields that write() takes. `xfrc_applied` is (force, torque) at a body's centre of mass, world frame."""

MOVING_FIELDS = frozenset(("qpos", "qvel", "mocap_pos", "mocap_quat"))
"""State fields that kinematics depend on."""

MAX_VALUE = 1e10
"""MuJoCo's bound (mjMAXVAL) on healthy positions, velocities and accelerations."""

FRAME_FIELDS = words("xpos xquat xmat xipos ximat xanchor xaxis geom_xpos geom_xmat site_xpos site_xmat")
"""Fields that follow from joint positions, mocap poses and :data:`FRAME_MODEL_FIELDS` alone."""

FRAME_MODEL_FIELDS = words(
    "qpos0 body_pos body_quat body_ipos body_iquat jnt_pos jnt_axis geom_pos geom_quat site_pos site_quat"
)
"""Model fields that :data:`FRAME_FIELDS` depend on."""

MOTION_FIELDS = words("subtree_com cdof cinert cvel cdof_dot")
"""Fields that follow from joint positions and velocities, mocap poses, :data:`FRAME_MODEL_FIELDS` and
:data:`MOTION_MODEL_FIELDS` alone."""

MOTION_MODEL_FIELDS = words("body_mass body_inertia")
"""Model fields that :data:`MOTION_FIELDS` depend on and :data:`FRAME_FIELDS` do not."""

_POS_FIELDS = (
    *FRAME_FIELDS,
    *words("cam_xpos cam_xmat subtree_com cdof cinert ten_length actuator_length"),
)
_VEL_FIELDS = words(
    "cvel cdof_dot ten_velocity actuator_velocity qfrc_bias qfrc_passive qfrc_gravcomp",
    "subtree_linvel subtree_angmom",
)
_ACC_FIELDS = words(
    "qacc act_dot actuator_force qfrc_actuator qfrc_smooth qfrc_constraint",
    "cacc cfrc_int cfrc_ext",
)

DERIVED_FIELDS: dict[str, Stage] = {
    **dict.fromkeys(_POS_FIELDS, Stage.POS),
    **dict.fromkeys(_VEL_FIELDS, Stage.VEL),
    **dict.fromkeys(_ACC_FIELDS, Stage.ACC),
    "sensordata": Stage.POS,
}
"""Read-only fields and the stage each needs; `sensordata` needs its sensors', :func:`sensor_stages`."""

_SENSOR = mujoco.mjtSensor
_SUBTREE_SENSORS = (_SENSOR.mjSENS_SUBTREELINVEL, _SENSOR.mjSENS_SUBTREEANGMOM)
_ACCELERATION_SENSORS = (
    _SENSOR.mjSENS_ACCELEROMETER,
    _SENSOR.mjSENS_FORCE,
    _SENSOR.mjSENS_TORQUE,
    _SENSOR.mjSENS_FRAMELINACC,
    _SENSOR.mjSENS_FRAMEANGACC,
)
NEEDS_SENSOR: dict[str, tuple[mujoco.mjtSensor, ...]] = {
    **dict.fromkeys(("subtree_linvel", "subtree_angmom"), _SUBTREE_SENSORS),
    **dict.fromkeys(("cacc", "cfrc_int", "cfrc_ext"), _ACCELERATION_SENSORS),
}
"""Fields that MuJoCo computes only when the model has one of these sensors."""


def sensor_stages(model: mujoco.MjModel) -> list[Stage]:
    """The stage that each entry of `sensordata` needs, length nsensordata."""
    stages = []
    for needed, dim in zip(model.sensor_needstage, model.sensor_dim, strict=True):
        stages += [Stage(int(needed))] * int(dim)
    return stages
