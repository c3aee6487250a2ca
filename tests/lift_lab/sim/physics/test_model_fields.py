"""A model field that is written for one environment acts as if the model had been compiled with that value.

Each row changes one value of a small model. What MuJoCo's compiler makes of it is the expectation: the compiled field
is written for one environment, which must then move as MuJoCo's own simulation of the changed model.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, Literal, NamedTuple

import mujoco
import numpy as np
import pytest
import torch
from mujoco.batch import MODEL_FIELDS

from lift_lab.sim.physics import CONSTANT_INPUTS, RANDOMIZABLE_FIELDS, Physics, make_physics
from lift_lab.sim.physics.base import silence
from lift_lab.sim.physics.native import NativePhysics
from lift_lab.utils.errors import ConfigError, NotFoundError

# Five colliders on a free body that slides on the ground, two links with limits on a rope, two bodies that equality
# constraints hold, and a camera that follows a centre of mass. No gravity compensation, armature, stiffness, friction
# loss, margin or gap: each of them starts from zero.
XML = """
<mujoco>
  <compiler angle="radian"/>
  <option timestep="0.002" integrator="implicitfast"/>
  <worldbody>
    <body name="ground">
      <inertial mass="1" pos="0 0 0" diaginertia="1 1 1"/>
      <geom name="floor" type="plane" size="5 5 0.1"/>
    </body>
    <site name="hook" pos="1 0 1.3"/>
    <body name="slider" pos="0 0 0.0199" simple="false">
      <freejoint/>
      <inertial mass="0.5" pos="0 0 0" diaginertia="0.002 0.002 0.003"/>
      <geom name="ball" type="sphere" size="0.02"/>
      <geom name="ball1" type="sphere" size="0.02" pos="0.1 0 0"/>
      <geom name="ball2" type="sphere" size="0.02" pos="0 0.1 0"/>
      <geom name="ball3" type="sphere" size="0.02" pos="0.1 0.1 0"/>
      <geom name="box" type="box" size="0.022 0.01 0.015" pos="0.05 0.05 0"/>
      <camera name="eye" pos="0 -1 1" mode="trackcom"/>
    </body>
    <body name="upper" pos="1 0 1">
      <joint name="shoulder" type="hinge" axis="0 1 0" range="-0.2 0.3" limited="true" damping="0.1"/>
      <inertial mass="1" pos="0.2 0 0" diaginertia="0.01 0.02 0.02"/>
      <site name="ring" pos="0.1 0 0.05"/>
      <body name="fore" pos="0.4 0 0">
        <joint name="elbow" type="hinge" axis="0 1 0" range="-0.05 0.3" limited="true" actuatorfrcrange="-30 30"
               actuatorfrclimited="true"/>
        <inertial mass="0.5" pos="0.1 0 0" diaginertia="0.005 0.006 0.006"/>
      </body>
    </body>
    <body name="connected" pos="2 0 1">
      <joint name="connected" type="ball"/>
      <inertial mass="0.3" pos="0 0 -0.2" diaginertia="0.01 0.01 0.01"/>
    </body>
    <body name="welded" pos="2.5 0 1">
      <joint name="welded" type="slide" axis="0 0 1"/>
      <inertial mass="0.3" pos="0 0 0.1" diaginertia="0.01 0.01 0.01"/>
    </body>
  </worldbody>
  <tendon>
    <spatial name="rope" range="0 0.272" limited="true"><site site="hook"/><site site="ring"/></spatial>
  </tendon>
  <equality>
    <connect name="connected" body1="connected" anchor="0.1 0 -0.4" solref="0.05 1"/>
    <weld name="welded" body1="welded" solref="0.05 1"/>
  </equality>
  <actuator>
    <position name="shoulder" joint="shoulder" kp="20" kv="1" forcerange="-15 15" ctrlrange="-1 1"/>
    <general name="elbow" joint="elbow" gainprm="5" dyntype="filter" dynprm="0.05" actlimited="false"/>
  </actuator>
</mujoco>
"""
STEPS = 30
ROLL, PITCH = [0.92388, 0.38268, 0.0, 0.0], [0.92388, 0.0, 0.38268, 0.0]
"""Turns by 45 degrees."""
SOFT = [0.1, 0.3, 0.1, 0.5, 2.0]

Edit = Callable[[mujoco.MjSpec], None]


class Row(NamedTuple):
    """One value of one model field."""

    fields: str
    """The model fields that are written; the first one is what the row is about."""
    edit: Edit
    """Gives the spec the value."""
    name: str


def _set(kind: str, name: str, **values: Any) -> Edit:
    def edit(spec: mujoco.MjSpec) -> None:
        for attribute, value in values.items():
            setattr(getattr(spec, kind)(name), attribute, value)

    return edit


def _row(fields: str, kind: str, name: str, **values: Any) -> Row:
    return Row(fields, _set(kind, name, **values), f"{fields.split()[0]}-{name}")


def _floor_friction(spec: mujoco.MjSpec) -> None:
    for geom in spec.geoms:  # a contact takes the larger of the two
        geom.friction = [0.1, 0.005, 0.0001]


def _set_gravity(spec: mujoco.MjSpec) -> None:
    spec.option.gravity = [1.0, 0.0, -5.0]


ROWS = [
    _row("body_mass", "body", "fore", mass=2.0),
    _row("body_inertia", "body", "fore", inertia=[0.05, 0.06, 0.07]),
    _row("body_ipos", "body", "slider", ipos=[0.02, 0.01, 0.0]),
    _row("body_ipos", "body", "fore", ipos=[0.2, 0.0, 0.1]),
    _row("body_iquat", "body", "slider", iquat=ROLL, inertia=[0.002, 0.002, 0.003]),
    _row("body_pos", "body", "fore", pos=[0.3, 0.0, 0.1]),
    _row("body_quat", "body", "fore", quat=PITCH),
    _row("body_quat", "body", "connected", quat=[0.0, 1.0, 0.0, 0.0]),  # moves the anchor in the world
    _row("body_pos", "body", "ground", pos=[0.0, 0.0, -0.01]),
    _row("body_quat", "body", "ground", quat=[0.99875, 0.0, 0.05, 0.0]),
    _row("body_gravcomp", "body", "upper", gravcomp=1.0),
    _row("jnt_pos", "joint", "elbow", pos=[0.05, 0.0, 0.05]),
    _row("jnt_axis", "joint", "elbow", axis=[0.0, 0.6, 0.8]),
    _row("jnt_range", "joint", "elbow", range=[-0.01, 0.1]),
    _row("jnt_margin", "joint", "elbow", margin=0.1),
    _row("jnt_stiffness", "joint", "shoulder", stiffness=[1000.0, 0.0, 0.0]),
    _row("jnt_solref", "joint", "elbow", solref_limit=[0.1, 1.0]),
    _row("jnt_solimp", "joint", "elbow", solimp_limit=SOFT),
    _row("jnt_actfrcrange", "joint", "elbow", actfrcrange=[-1.0, 1.0]),
    _row("dof_armature", "joint", "shoulder", armature=0.5),
    _row("dof_damping", "joint", "elbow", damping=[2.0, 0.0, 0.0]),
    _row("dof_frictionloss", "joint", "elbow", frictionloss=3.0),
    _row("dof_solref dof_frictionloss", "joint", "elbow", frictionloss=3.0, solref_friction=[0.2, 1.0]),
    _row("dof_solimp dof_frictionloss", "joint", "elbow", frictionloss=3.0, solimp_friction=SOFT),
    _row("geom_pos", "geom", "ball", pos=[-0.1, -0.05, -0.01]),
    _row("geom_pos", "geom", "floor", pos=[0.0, 0.0, -0.01]),
    _row("geom_quat", "geom", "box", quat=PITCH),
    _row("geom_quat", "geom", "floor", quat=[0.99875, 0.05, 0.0, 0.0]),
    _row("geom_size", "geom", "ball", size=[0.05, 0.0, 0.0]),
    Row("geom_friction", _floor_friction, "geom_friction"),
    _row("geom_solref", "geom", "floor", solref=[0.1, 1.0]),
    _row("geom_solimp", "geom", "floor", solimp=SOFT),
    _row("geom_solmix geom_solref", "geom", "floor", solmix=5.0, solref=[0.1, 1.0]),
    _row("geom_margin", "geom", "ball", margin=0.04),
    _row("geom_gap", "geom", "box", gap=0.03),
    _row("site_pos", "site", "ring", pos=[0.2, 0.0, 0.0]),
    _row("cam_pos", "camera", "eye", pos=[0.5, -1.0, 2.0]),
    _row("cam_quat", "camera", "eye", quat=ROLL),
    _row("actuator_gainprm", "actuator", "elbow", gainprm=[20.0] + [0.0] * 9),
    _row("actuator_biasprm", "actuator", "shoulder", biasprm=[0.0, -40.0, -3.0] + [0.0] * 7),
    _row("actuator_dynprm", "actuator", "elbow", dynprm=[0.5] + [0.0] * 9),
    _row("actuator_gear", "actuator", "elbow", gear=[3.0] + [0.0] * 5),
    _row("actuator_ctrlrange", "actuator", "shoulder", ctrlrange=[-0.1, 0.1]),
    _row("actuator_forcerange", "actuator", "shoulder", forcerange=[-2.0, 2.0]),
    _row("eq_data", "equality", "connected", data=[0.0, 0.1, -0.2] + [0.0] * 9),
    _row("eq_solref", "equality", "connected", solref=[0.2, 1.0]),
    _row("eq_solimp", "equality", "connected", solimp=SOFT),
    _row("qpos0", "joint", "shoulder", ref=0.2),
    _row("qpos_spring jnt_stiffness", "joint", "shoulder", stiffness=[1000.0, 0.0, 0.0], springref=0.2),
    Row("opt.gravity", _set_gravity, "opt.gravity"),
]
NOT_DYNAMIC = {"geom_rgba", "cam_fovy"}
"""Fields that no motion depends on."""
ELSEWHERE = {"flex_friction", "site_quat"}
"""Fields of soft bodies, and of sites alone: tests of deformable objects and of sensors."""
NOT_FOLLOWED = {"opt.disableflags", "tendon_lengthspring"}
"""Fields that the engine sets itself, and automatic rest lengths of tendons, which MuJoCo computes only once."""


def _compile(edit: Edit | None = None) -> mujoco.MjModel:
    spec = mujoco.MjSpec.from_string(XML)
    if edit is not None:
        edit(spec)
    return spec.compile()


BASE = _compile()


def _field(model: mujoco.MjModel, name: str) -> np.ndarray:
    return np.asarray(getattr(model.opt, name[4:]) if name.startswith("opt.") else getattr(model, name))


def _start(model: mujoco.MjModel) -> mujoco.MjData:
    """The state in which every simulation begins."""
    data = mujoco.MjData(model)
    silence(data)
    for joint, velocity in (("shoulder", 1.0), ("elbow", -1.0), ("connected", [0.5, 1.0, 0.2]), ("welded", 0.3)):
        data.joint(joint).qvel = velocity
    data.qvel[:3] = 0.3, 0.1, 0.0
    data.ctrl[:] = 0.5, 1.0
    return data


def _observe(data: mujoco.MjData) -> np.ndarray:
    """What a row is compared by: the state, the number of contacts, and the camera's pose."""
    return np.concatenate((data.qpos, data.qvel, [data.ncon], data.cam_xpos[0], data.cam_xmat[0]))


def _simulate(model: mujoco.MjModel) -> np.ndarray:
    data = _start(model)
    for _ in range(STEPS):
        mujoco.mj_step(model, data)
    mujoco.mj_forward(model, data)
    return _observe(data)


def _run(physics: Physics, rows: Sequence[Row]) -> list[np.ndarray]:
    """Write row i for environment i + 1, after some steps with the model as it is, and simulate from the start."""
    physics.step(2)
    physics.reset()
    states = [_start(BASE)]
    for env, row in enumerate(rows, start=1):
        changed = _compile(row.edit)
        states.append(_start(changed))
        for name in row.fields.split():
            field = physics.randomizable(name)
            field[env] = torch.from_numpy(_field(changed, name).reshape(field.shape[1:])).to(field)
    for name in ("qpos", "qvel", "ctrl"):
        physics.write(name, torch.from_numpy(np.stack([getattr(state, name) for state in states])))
    physics.step(STEPS)
    return [_observe(physics.get_data(env)) for env in range(len(states))]


def _assert_same_constants(actual: mujoco.MjModel, compiled: mujoco.MjModel) -> None:
    for name in sorted(MODEL_FIELDS - NOT_FOLLOWED):
        values = _field(compiled, name)
        if values.dtype.kind in "bifu":
            np.testing.assert_allclose(_field(actual, name), values, atol=1e-12, rtol=1e-9, err_msg=name)
    assert actual.flg_gravcomp == compiled.flg_gravcomp


@pytest.fixture(scope="module")
def on_warp() -> dict[str, np.ndarray]:
    """Observations of one simulation on the warp engine, with a row in each environment."""
    results = _run(make_physics(BASE, len(ROWS) + 1, "cpu", "warp"), ROWS)
    return dict(zip(["unchanged", *(row.name for row in ROWS)], results, strict=True))


@pytest.mark.parametrize("row", ROWS, ids=[row.name for row in ROWS])
@pytest.mark.parametrize("engine", ["native", "warp"])
def test_a_field_of_one_environment_acts_as_if_compiled(
    engine: Literal["native", "warp"], row: Row, request: pytest.FixtureRequest
):
    expected, unchanged = _simulate(_compile(row.edit)), _simulate(BASE)
    tolerance = 1e-9 if engine == "native" else 1e-3
    assert np.abs(expected - unchanged).max() > 5e-3, "the row does nothing"
    if engine == "native":
        physics = NativePhysics(BASE, 2, num_threads=1)
        kept, actual = _run(physics, [row])
        _assert_same_constants(physics._batch.get_model(1), _compile(row.edit))
    else:
        results: dict[str, np.ndarray] = request.getfixturevalue("on_warp")
        kept, actual = results["unchanged"], results[row.name]
    np.testing.assert_allclose(actual, expected, atol=tolerance, rtol=0.0)
    np.testing.assert_allclose(kept, unchanged, atol=tolerance, rtol=0.0)


def test_the_rows_are_all_fields():
    assert {row.fields.split()[0] for row in ROWS} | NOT_DYNAMIC | ELSEWHERE == set(RANDOMIZABLE_FIELDS)


def test_the_fields_that_constants_follow_from_are_those_of_mujoco():
    read_by_set_const = set(mujoco.MjModel._setconst_inputs)
    assert set(CONSTANT_INPUTS) == set(RANDOMIZABLE_FIELDS) & read_by_set_const


@pytest.mark.parametrize("when", ["step", "refresh", "forward", "get_data"])
@pytest.mark.parametrize("inference", [False, True])
def test_constants_follow_whichever_call_comes_next(when: str, inference: bool):
    physics = NativePhysics(BASE, 2, num_threads=1)
    body = BASE.body("upper").id
    with torch.inference_mode(inference):
        physics.randomizable("body_mass")[1, body] = 3.0
        getattr(physics, when)(*([0] if when == "get_data" else []))
    expected = [BASE.body_subtreemass[body] + added for added in (0.0, 2.0)]
    masses = physics._batch.expanded("body_subtreemass")
    assert masses is not None
    np.testing.assert_allclose(masses[:, body], expected)


@pytest.mark.parametrize(
    ("name", "index", "value", "message"),
    [
        ("body_ipos", ("body", "welded"), [0.1, 0.0, 0.0], "body_ipos of 'welded' cannot change"),
        ("body_iquat", ("body", "welded"), ROLL, "body_iquat of 'welded' cannot change"),
        ("jnt_pos", ("joint", "welded"), [0.0, 0.1, 0.0], "jnt_pos of 'welded' cannot change"),
        ("jnt_axis", ("joint", "welded"), [0.0, 0.6, 0.8], "jnt_axis of 'welded' cannot change"),
        ("geom_size", ("geom", "floor"), [1.0, 1.0, 1.0], "geom_size of 'floor' cannot change: a plane"),
    ],
)
@pytest.mark.parametrize("engine", ["native", "warp"])
def test_a_value_that_the_compiled_model_cannot_have_is_refused(
    engine: Literal["native", "warp"], name: str, index: tuple[str, str], value: list[float], message: str
):
    # a body of its own that slides along an axis of its inertia: MuJoCo stores a diagonal inertia matrix
    spec = mujoco.MjSpec.from_string(
        """<mujoco><worldbody><geom name="floor" type="plane" size="5 5 0.1"/><body name="welded">
        <joint name="welded" type="slide" axis="0 0 1"/><inertial mass="1" pos="0 0 0" diaginertia="1 1 1"/>
        </body></worldbody></mujoco>"""
    )
    physics = make_physics(spec.compile(), 2, "cpu", engine)
    field = physics.randomizable(name)
    physics.step()  # values as compiled pass
    field[1, getattr(physics.model, index[0])(index[1]).id] = torch.tensor(value).to(field)
    with pytest.raises(ConfigError, match=message):
        physics.step()


def test_a_field_that_cannot_differ_is_refused_with_the_nearest_names():
    physics = NativePhysics(BASE, 2, num_threads=1)
    with pytest.raises(NotFoundError, match="'tendon_stiffness' cannot differ between environments; did you mean"):
        physics.randomizable("tendon_stiffness")
