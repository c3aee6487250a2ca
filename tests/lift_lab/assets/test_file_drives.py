"""Drives in a scene are the file's: the same efforts at the joint as in MuJoCo's own compile of the imported asset.

One robot has a joint for every kind of actuator that the importer makes. What is expected is measured on the compiled
import: efforts at states and targets, gains as differences of efforts, limits as efforts at far targets.
"""

from __future__ import annotations

import logging
import math
from collections.abc import Callable
from dataclasses import dataclass

import mujoco
import numpy as np
import pytest
import torch
from pxr import Gf, Sdf, Usd, UsdGeom, UsdPhysics

import lift_lab.sim as sim_utils
from lift_lab.actuators import IdealPDActuatorCfg, ImplicitActuatorCfg
from lift_lab.assets import ArticulationCfg
from lift_lab.scene import InteractiveScene, InteractiveSceneCfg
from lift_lab.usd import load
from lift_lab.utils import configclass
from lift_lab.utils.errors import ConfigError

NUM_ENVS = 2
_TYPES = Sdf.ValueTypeNames
_DEGREE = math.pi / 180.0


@configclass
class _SceneCfg(InteractiveSceneCfg):
    robot: ArticulationCfg | None = None


def _drive(token: str, **values):
    def author(stage, joint):
        api = UsdPhysics.DriveAPI.Apply(joint, token)
        for name, value in values.items():
            getattr(api, f"Create{name}Attr")(value)

    return author


def _mjc(**values):
    """An MjcActuator; vectors are padded to MuJoCo's ten numbers."""

    def author(stage, joint):
        prim = stage.DefinePrim(f"{joint.GetPath()}_act", "MjcActuator")
        prim.CreateRelationship("mjc:target").SetTargets([joint.GetPath()])
        for name, value in values.items():
            if name.endswith("Range"):
                for end, number in zip(("min", "max"), value, strict=True):
                    prim.CreateAttribute(f"mjc:{name}:{end}", _TYPES.Double).Set(number)
            elif isinstance(value, str):
                prim.CreateAttribute(f"mjc:{name}", _TYPES.Token).Set(value)
            elif name == "inheritRange":
                prim.CreateAttribute(f"mjc:{name}", _TYPES.Double).Set(value)
            else:
                size = 6 if name == "gear" else 10
                value = list(value) + [0.0] * (size - len(value))
                prim.CreateAttribute(f"mjc:{name}", _TYPES.DoubleArray).Set(value)

    return author


def _position(kp, damping, constant=0.0, **values):
    return _mjc(gainPrm=[kp], biasPrm=[constant, -kp, damping], biasType="affine", **values)


def _newton(*schemas, **values):
    def author(stage, joint):
        prim = stage.DefinePrim(f"{joint.GetPath()}_act", "NewtonActuator")
        for schema in ("NewtonPDControlAPI", *schemas):
            prim.AddAppliedSchema(schema)
        for name, value in values.items():
            prim.CreateAttribute(f"newton:{name}", _TYPES.Float).Set(value)
        prim.CreateRelationship("newton:targets").SetTargets([joint.GetPath()])

    return author


@dataclass(frozen=True)
class _Kind:
    author: Callable
    command: str = "position"
    """What its control is: a position, a velocity, or an effort."""
    slides: bool = False


_gains = {"Stiffness": 40.0 * _DEGREE, "Damping": 2.0 * _DEGREE}
_KINDS = {
    "drive": _Kind(_drive("angular", **_gains)),
    "drive_limited": _Kind(_drive("angular", **_gains, MaxForce=6.0)),
    "drive_velocity": _Kind(_drive("angular", Damping=3.0 * _DEGREE, MaxForce=9.0), "velocity"),
    "drive_with_speed": _Kind(_drive("angular", **_gains, TargetVelocity=30.0, MaxForce=8.0)),
    "drive_acceleration": _Kind(_drive("angular", Type="acceleration", Stiffness=400.0, Damping=30.0)),
    "drive_slide": _Kind(_drive("linear", Stiffness=70.0, Damping=3.0, MaxForce=11.0), slides=True),
    "position": _Kind(_position(50.0, -2.0)),
    "geared": _Kind(_position(50.0, -2.0, gear=[3.0], forceRange=(-7.0, 7.0))),
    "reversed": _Kind(_position(20.0, -1.0, gear=[-2.0])),
    "limited": _Kind(_position(50.0, -2.0, forceRange=(-7.0, 7.0))),
    "lopsided": _Kind(_position(50.0, -2.0, gear=[-1.5], forceRange=(-2.0, 7.0))),
    "damping_ratio": _Kind(_position(50.0, 1.0)),
    "constant": _Kind(_position(50.0, -2.0, constant=4.0, gear=[2.0])),
    "clipped_target": _Kind(_position(50.0, -2.0, gear=[2.0], ctrlRange=(-0.4, 0.8))),
    "servo_velocity": _Kind(_mjc(gainPrm=[3.0], biasPrm=[0.0, 0.0, -3.0], biasType="affine", gear=[2.0]), "velocity"),
    "clipped_velocity": _Kind(
        _mjc(gainPrm=[3.0], biasPrm=[0.0, 0.0, -3.0], biasType="affine", ctrlRange=(-1.0, 0.5)), "velocity"
    ),
    "motor": _Kind(_mjc(gainPrm=[5.0], gear=[4.0], ctrlRange=(-1.0, 1.0)), "effort"),
    "strong_motor": _Kind(_mjc(gainPrm=[5.0], gear=[4.0], forceRange=(-2.0, 2.0)), "effort"),
    "newton": _Kind(_newton("NewtonMaxEffortClampingAPI", kp=50.0, kd=2.0, maxEffort=7.0)),
    "newton_constant": _Kind(_newton(kp=50.0, kd=2.0, constEffort=1.5)),
    "newton_velocity": _Kind(_newton(kd=2.0), "velocity"),
    "newton_motor": _Kind(_newton("NewtonDCMotorClampingAPI", kp=50.0, kd=2.0, saturationEffort=8.0)),
}


def _author_robot(path, kinds) -> str:
    """Links on joints of their own about a fixed base, each driven in its own way."""
    stage = Usd.Stage.CreateNew(str(path))
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    UsdGeom.SetStageUpAxis(stage, "Z")
    root = UsdGeom.Xform.Define(stage, "/robot").GetPrim()
    stage.SetDefaultPrim(root)
    UsdPhysics.ArticulationRootAPI.Apply(root)
    for name in ("base", *(f"{kind}_link" for kind in kinds)):
        body = UsdGeom.Xform.Define(stage, f"/robot/{name}").GetPrim()
        UsdPhysics.RigidBodyAPI.Apply(body)
        mass = UsdPhysics.MassAPI.Apply(body)
        mass.CreateMassAttr(1.0)
        mass.CreateDiagonalInertiaAttr(Gf.Vec3f(0.02, 0.02, 0.02))
    UsdPhysics.FixedJoint.Define(stage, "/robot/fix").CreateBody1Rel().SetTargets(["/robot/base"])
    for name, kind in kinds.items():
        define = UsdPhysics.PrismaticJoint if kind.slides else UsdPhysics.RevoluteJoint
        joint = define.Define(stage, f"/robot/{name}")
        joint.CreateAxisAttr("Y")
        joint.CreateBody0Rel().SetTargets(["/robot/base"])
        joint.CreateBody1Rel().SetTargets([f"/robot/{name}_link"])
        kind.author(stage, joint.GetPrim())
    stage.Save()
    return str(path)


@pytest.fixture(scope="module")
def robot_file(tmp_path_factory) -> str:
    return _author_robot(tmp_path_factory.mktemp("usd") / "robot.usda", _KINDS)


class _Import:
    """The compiled import: joint efforts at a state and with targets."""

    def __init__(self, path):
        self.model = load(path)[0].compile()
        self.data = mujoco.MjData(self.model)

    def efforts(self, pos, vel, targets) -> np.ndarray:
        """Efforts of all joints in the order of ``_KINDS``; ``targets`` by command, in units of the joint."""
        model, data = self.model, self.data
        for i, name in enumerate(_KINDS):
            joint = model.joint(name)
            data.qpos[joint.qposadr], data.qvel[joint.dofadr] = pos[i], vel[i]
        for a in range(model.nu):
            name = model.joint(model.actuator_trnid[a, 0]).name
            if model.actuator(a).name == f"{name}_velocity":  # carries a drive's own target velocity
                continue
            command, gear = _KINDS[name].command, model.actuator_gear[a, 0]
            target = targets[command][list(_KINDS).index(name)]
            data.ctrl[a] = target / (gear * model.actuator_gainprm[a, 0]) if command == "effort" else target * gear
        mujoco.mj_forward(model, data)
        return np.array([data.qfrc_actuator[model.joint(name).dofadr[0]] for name in _KINDS])


@pytest.fixture(scope="module")
def imported(robot_file) -> _Import:
    return _Import(robot_file)


def _start(path, actuators, physics="native", **spawn):
    sim = sim_utils.SimulationContext(sim_utils.SimulationCfg(device="cpu", physics=physics, dt=0.002))
    robot = ArticulationCfg(
        prim_path="{ENV_REGEX_NS}/Robot", spawn=sim_utils.UsdFileCfg(usd_path=path, **spawn), actuators=actuators
    )
    scene = InteractiveScene(_SceneCfg(num_envs=NUM_ENVS, env_spacing=2.0, robot=robot))
    sim.reset()
    return sim, scene["robot"]


_ALL = {"joint_names_expr": [".*"], "stiffness": None, "damping": None}
_GROUPS = {
    "implicit": {"all": ImplicitActuatorCfg(**_ALL)},
    "explicit": {"all": IdealPDActuatorCfg(**_ALL)},
    "no group": {},
}


@pytest.fixture(scope="module", params=[(p, g) for p in ("native", "warp") for g in _GROUPS], ids="-".join)
def started(request, robot_file):
    physics, group = request.param
    sim, robot = _start(robot_file, {name: cfg.copy() for name, cfg in _GROUPS[group].items()}, physics)
    yield group, sim, robot, [robot.joint_names.index(name) for name in _KINDS]
    sim.close()


def _efforts(sim, robot, order, pos, vel, targets) -> np.ndarray:
    """Joint efforts in the engine, shape (num_envs, number of kinds)."""

    def tensor(values):
        wide = torch.zeros(robot.num_joints)
        wide[order] = torch.as_tensor(np.asarray(values), dtype=torch.float32)
        return wide.expand(NUM_ENVS, -1).clone()

    robot.write_joint_state_to_sim(tensor(pos), tensor(vel))
    robot.set_joint_position_target(tensor(targets["position"]))
    robot.set_joint_velocity_target(tensor(targets["velocity"]))
    robot.set_joint_effort_target(tensor(targets["effort"]))
    robot.write_data_to_sim()
    sim.physics.forward()
    return sim.physics.field("qfrc_actuator").numpy()[:, [robot._dof_ids[i] for i in order]]


def _state(rng, reach):
    count = len(_KINDS)
    pos, vel = rng.uniform(-0.3, 0.3, count), rng.uniform(-1.0, 1.0, count)
    targets = {command: np.zeros(count) for command in ("position", "velocity", "effort")}
    for i, kind in enumerate(_KINDS.values()):
        targets[kind.command][i] = rng.uniform(-reach, reach)
    return pos, vel, targets


def _comparable(group) -> list[int]:
    """A model in torch takes the file's gains and limits, alike to both sides, and no ranges of targets."""
    apart = ("clipped_target", "clipped_velocity", "lopsided") if group == "explicit" else ()
    return [i for i, name in enumerate(_KINDS) if name not in apart]


@pytest.mark.parametrize("reach", [0.1, 30.0], ids=["near targets", "targets beyond every limit"])
def test_a_scene_gives_the_efforts_of_the_compiled_import(started, imported, reach):
    group, sim, robot, order = started
    rng = np.random.default_rng(3)
    shown = _comparable(group)
    for _ in range(6):
        state = _state(rng, reach)
        expected = imported.efforts(*state)
        found = _efforts(sim, robot, order, *state)
        np.testing.assert_allclose(found[:, shown], np.tile(expected[shown], (NUM_ENVS, 1)), rtol=2e-4, atol=2e-4)
        torque = robot.data.applied_torque.numpy()[:, order]
        np.testing.assert_allclose(torque[:, shown], found[:, shown], rtol=2e-4, atol=2e-4)


def _measured(imported) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Stiffness, damping and effort limits (infinite where there is none) of the compiled import, from efforts."""
    count, step = len(_KINDS), 1e-4
    zero = {command: np.zeros(count) for command in ("position", "velocity", "effort")}

    def slope(kind):
        ends = []
        for sign in (1.0, -1.0):
            state = [np.zeros(count), np.zeros(count)]
            state[kind] = np.full(count, sign * step)
            ends.append(imported.efforts(*state, zero))
        return -(ends[0] - ends[1]) / (2 * step)

    def greatest(reach):
        far = []
        for sign in (1.0, -1.0):
            # far from the target by the state, too: where targets are clipped the drive itself is not
            targets = {command: np.full(count, sign * reach) for command in zero}
            far.append(np.abs(imported.efforts(np.full(count, -sign * reach), np.full(count, -sign * reach), targets)))
        return np.max(far, axis=0)

    near, far = greatest(1e3), greatest(1e4)
    return slope(0), slope(1), np.where(far > 2 * near, np.inf, far)


def test_a_scene_reports_the_gains_and_limits_of_the_compiled_import(started, imported):
    group, _, robot, order = started
    stiffness, damping, limits = _measured(imported)
    assert dict(zip(_KINDS, np.isinf(limits), strict=True))["position"]
    data = robot.data
    for found, expected in ((data.joint_stiffness, stiffness), (data.joint_damping, damping)):
        np.testing.assert_allclose(found[:, order], np.tile(expected, (NUM_ENVS, 1)), rtol=1e-4, atol=1e-4)
    if group == "explicit":
        np.testing.assert_allclose(robot.actuators["all"].effort_limit[:, order], [limits] * NUM_ENVS, rtol=1e-5)
        np.testing.assert_allclose(data.joint_effort_limits, 1e9)  # Isaac Lab's: the model clips, not the engine
    else:
        np.testing.assert_allclose(data.joint_effort_limits[:, order], [limits] * NUM_ENVS, rtol=1e-5)


def test_gains_scaled_in_one_environment_are_scaled_from_the_files(started, imported):
    _, sim, robot, order = started
    robot.write_joint_stiffness_to_sim(2.0 * robot.data.default_joint_stiffness[1:], env_ids=[1])
    robot.write_joint_damping_to_sim(3.0 * robot.data.default_joint_damping[1:], env_ids=[1])
    stiffness, damping, _ = _measured(imported)
    rng = np.random.default_rng(5)
    pos, vel, targets = _state(rng, 0.005)  # below every limit
    pos, vel = 0.02 * pos, 0.02 * vel
    found = _efforts(sim, robot, order, pos, vel, targets)
    extra = stiffness * (targets["position"] - pos) + 2.0 * damping * (targets["velocity"] - vel)
    expected = imported.efforts(pos, vel, targets)
    np.testing.assert_allclose(found, [expected, expected + extra], rtol=1e-3, atol=1e-3)
    robot.write_joint_stiffness_to_sim(robot.data.default_joint_stiffness.clone())
    robot.write_joint_damping_to_sim(robot.data.default_joint_damping.clone())


def test_numbers_of_a_config_hold_instead_of_the_files_law(robot_file):
    group = ImplicitActuatorCfg(joint_names_expr=[".*"], stiffness=10.0, damping=1.0)
    sim, robot = _start(robot_file, {"all": group})
    order = [robot.joint_names.index(name) for name in _KINDS]
    pos, vel, targets = _state(np.random.default_rng(0), 0.1)
    targets = {"position": np.full(len(_KINDS), 0.05), "velocity": targets["velocity"], "effort": targets["effort"]}
    law = 10.0 * (0.05 - pos) + 1.0 * (targets["velocity"] - vel) + targets["effort"]
    limited = (
        "drive_limited",
        "drive_with_speed",
        "limited",
        "geared",
        "lopsided",
        "newton",
        "newton_motor",
        "motor",
        "strong_motor",
    )
    shown = [i for i, name in enumerate(_KINDS) if name not in limited]
    found = _efforts(sim, robot, order, pos, vel, targets)
    np.testing.assert_allclose(found[:, shown], [law[shown]] * NUM_ENVS, rtol=1e-4, atol=1e-5)
    # the limits stay the file's where the config gives none, as in Isaac Lab
    limits = dict(zip(robot.joint_names, robot.data.joint_effort_limits[0].tolist(), strict=True))
    assert [limits[name] for name in limited] == pytest.approx([6.0, 8.0, 7.0, 21.0, 10.5, 7.0, 8.0, 20.0, 8.0])
    sim.close()


def test_drive_properties_of_a_spawner_are_of_the_joint_for_every_kind(robot_file):
    properties = sim_utils.JointDrivePropertiesCfg(stiffness=30.0, damping=1.5, max_effort=5.0)
    sim, robot = _start(robot_file, {"all": ImplicitActuatorCfg(**_ALL)}, joint_drive_props=properties)
    number = {name: i for i, name in enumerate(robot.joint_names)}
    drives = [number[name] for name, kind in _KINDS.items() if kind.command == "position"]
    np.testing.assert_allclose(robot.data.joint_stiffness[:, drives], 30.0, rtol=1e-6)
    np.testing.assert_allclose(robot.data.joint_damping[:, drives], 1.5, rtol=1e-6)
    np.testing.assert_allclose(robot.data.joint_effort_limits, 5.0, rtol=1e-6)
    sim.close()


def test_a_damping_ratio_is_of_the_files_armature_whatever_the_config_adds(tmp_path, imported):
    path = _author_robot(tmp_path / "one.usda", {"damping_ratio": _KINDS["damping_ratio"]})
    sim, robot = _start(path, {"all": ImplicitActuatorCfg(**_ALL, armature=0.5)})
    expected = dict(zip(_KINDS, _measured(imported)[1], strict=True))["damping_ratio"]
    np.testing.assert_allclose(robot.data.joint_damping, expected, rtol=1e-5)
    np.testing.assert_allclose(robot.data.joint_armature, 0.5)
    sim.close()


def test_an_actuator_that_is_no_pd_drive_needs_gains_or_stays_as_it_is(tmp_path, caplog):
    filtered = _Kind(_position(50.0, -2.0, dynType="filter", dynPrm=[0.1]))
    path = _author_robot(tmp_path / "one.usda", {"knee": filtered})
    with pytest.raises(ConfigError, match=r"joint 'knee' has the actuators 'knee_act' .* give stiffness and damping"):
        _start(path, {"all": ImplicitActuatorCfg(**_ALL)})
    sim, _ = _start(path, {"all": ImplicitActuatorCfg(joint_names_expr=[".*"], stiffness=5.0, damping=1.0)})
    assert sim.model.nu == 1
    assert sim.model.na == 0
    with caplog.at_level(logging.WARNING, "lift_lab.assets.articulation.drives"):
        sim, _ = _start(path, {})
    assert sim.model.na == 1
    assert any("no target reaches them" in line and "'knee_act'" in line for line in caplog.messages)
    sim.close()


def test_joints_without_a_group_are_named_in_one_line(robot_file, caplog):
    with caplog.at_level(logging.WARNING, "lift_lab.assets.articulation.drives"):
        sim, _ = _start(robot_file, {"some": ImplicitActuatorCfg(**(_ALL | {"joint_names_expr": ["drive.*"]}))})
    (line,) = [line for line in caplog.messages if "no actuator group" in line]
    assert "'position'" in line
    assert "'drive'" not in line
    sim.close()


@pytest.mark.parametrize(
    ("field", "value"), [("stiffness", -1.0), ("damping", float("nan")), ("effort_limit_sim", -2.0), ("armature", -0.1)]
)
def test_numbers_out_of_range_are_refused(tmp_path, field, value):
    path = _author_robot(tmp_path / "one.usda", {"knee": _KINDS["position"]})
    cfg = ImplicitActuatorCfg(**(_ALL | {field: value}))
    with pytest.raises(ConfigError, match=rf"scene\.robot\.actuators\.all\.{field} is .* at least 0"):
        _start(path, {"all": cfg})


def test_an_effort_limit_of_zero_is_a_joint_that_cannot_push(tmp_path):
    path = _author_robot(tmp_path / "one.usda", {"knee": _KINDS["position"]})
    sim, robot = _start(path, {"all": ImplicitActuatorCfg(**_ALL, effort_limit_sim=0.0)})
    robot.set_joint_position_target(torch.ones(NUM_ENVS, 1))
    robot.write_data_to_sim()
    sim.physics.forward()
    np.testing.assert_allclose(sim.physics.field("qfrc_actuator"), 0.0, atol=1e-30)
    sim.close()


def _pair(first, second):
    """Two actuators on one joint."""

    def author(stage, joint):
        first(stage, joint)
        prim = stage.GetPrimAtPath(f"{joint.GetPath()}_act")
        stage.GetRootLayer().GetPrimAtPath(prim.GetPath()).name += "ive"
        second(stage, joint)

    return _Kind(author)


@pytest.mark.parametrize("force", [None, (-3.0, 3.0)])
def test_actuators_that_share_a_joint_add_up(tmp_path, caplog, force):
    limits = {} if force is None else {"forceRange": force}
    velocity = _mjc(gainPrm=[3.0], biasPrm=[0.0, 0.0, -3.0], biasType="affine", **limits)
    path = _author_robot(tmp_path / "one.usda", {"knee": _pair(_position(50.0, -2.0, gear=[2.0], **limits), velocity)})
    assert load(path)[0].compile().nu == 2
    with caplog.at_level(logging.WARNING, "lift_lab.assets.articulation.file_drives"):
        sim, robot = _start(path, {"all": ImplicitActuatorCfg(**_ALL)})
    np.testing.assert_allclose(robot.data.joint_stiffness, 4 * 50.0)
    np.testing.assert_allclose(robot.data.joint_damping, 4 * 2.0 + 3.0)
    np.testing.assert_allclose(robot.data.joint_effort_limits, math.inf if force is None else 2 * 3.0 + 3.0)
    said = [line for line in caplog.messages if "added up" in line]
    assert len(said) == (force is not None)  # MuJoCo clips each: the sum is near, not the same
    sim.close()
