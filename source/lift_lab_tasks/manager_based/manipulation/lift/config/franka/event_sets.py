"""Events of the lift task to choose from, e.g. ``env/events=randomized``; the plain ones are in lift_env_cfg."""

from __future__ import annotations

from lift_lab.managers import EventTermCfg as EventTerm
from lift_lab.managers import SceneEntityCfg
from lift_lab.utils import configclass
from lift_lab_tasks.manager_based.manipulation.lift import mdp
from lift_lab_tasks.manager_based.manipulation.lift.lift_env_cfg import EventCfg

_LEAST_FRICTION, _MOST_FRICTION = 0.5, 1.5


def _material(asset_cfg: SceneEntityCfg, friction_range: tuple[float, float], num_buckets: int) -> EventTerm:
    params = {
        "asset_cfg": asset_cfg,
        "static_friction_range": friction_range,
        "dynamic_friction_range": friction_range,
        "restitution_range": (0.0, 0.0),
        "num_buckets": num_buckets,
    }
    return EventTerm(func=mdp.randomize_rigid_body_material, mode="startup", params=params)


@configclass
class RandomizedEventCfg(EventCfg):
    """Domain randomisation: every environment has a cube of its own mass and surface, drawn once at start.

    In a contact the larger friction coefficient of the two surfaces counts. So the pads have the smallest coefficient
    of the cube's range, and a grip has the cube's coefficient. If both were drawn, only one grip in 16 would have less
    than 0.75.
    """

    object_mass = EventTerm(
        func=mdp.randomize_rigid_body_mass,
        mode="startup",
        params={
            "asset_cfg": SceneEntityCfg("object"),
            "mass_distribution_params": (0.5, 2.0),
            "operation": "scale",
            "distribution": "log_uniform",
        },
    )
    object_material = _material(SceneEntityCfg("object"), (_LEAST_FRICTION, _MOST_FRICTION), num_buckets=256)
    finger_material = _material(
        SceneEntityCfg("robot", body_names="panda_.*finger"), (_LEAST_FRICTION, _LEAST_FRICTION), num_buckets=1
    )


_PLACE_SOFT_OBJECT = EventTerm(
    func=mdp.reset_nodal_state_uniform,
    mode="reset",
    params={
        "position_range": {"x": (-0.1, 0.1), "y": (-0.25, 0.25), "z": (0.0, 0.0)},
        "velocity_range": {},
        "asset_cfg": SceneEntityCfg("object"),
    },
)


@configclass
class SoftEventCfg(EventCfg):
    """The plain events with a soft object."""

    reset_object_position = _PLACE_SOFT_OBJECT


@configclass
class RandomizedSoftEventCfg(RandomizedEventCfg):
    """The randomised events with a soft object."""

    reset_object_position = _PLACE_SOFT_OBJECT
