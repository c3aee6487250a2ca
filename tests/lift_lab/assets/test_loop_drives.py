"""A drive on a joint that closes a loop acts between the two bodies, in a scene as in the compiled import."""

from __future__ import annotations

import logging

import mujoco
import numpy as np
import pytest
import torch
from pxr import Gf, Sdf, Usd, UsdGeom, UsdPhysics

import lift_lab.sim as sim_utils
from lift_lab.actuators import ImplicitActuatorCfg
from lift_lab.assets import ArticulationCfg
from lift_lab.scene import InteractiveScene, InteractiveSceneCfg
from lift_lab.usd import load
from lift_lab.utils import configclass

NUM_ENVS = 2


@configclass
class _SceneCfg(InteractiveSceneCfg):
    robot: ArticulationCfg | None = None


@pytest.fixture(scope="module")
def robot_file(tmp_path_factory) -> str:
    """Two levers on a base, and a driven slide between them that closes a loop; a tendon actuator on one lever."""
    path = str(tmp_path_factory.mktemp("usd") / "levers.usda")
    stage = Usd.Stage.CreateNew(path)
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    UsdGeom.SetStageUpAxis(stage, "Z")
    root = UsdGeom.Xform.Define(stage, "/robot").GetPrim()
    stage.SetDefaultPrim(root)
    UsdPhysics.ArticulationRootAPI.Apply(root)
    for name, x in (("base", 0.0), ("left", 0.0), ("right", 0.4)):
        body = UsdGeom.Xform.Define(stage, f"/robot/{name}")
        body.AddTranslateOp().Set(Gf.Vec3d(x, 0, 0))
        UsdPhysics.RigidBodyAPI.Apply(body.GetPrim())
        mass = UsdPhysics.MassAPI.Apply(body.GetPrim())
        mass.CreateMassAttr(1.0)
        mass.CreateDiagonalInertiaAttr(Gf.Vec3f(0.02, 0.02, 0.02))
    UsdPhysics.FixedJoint.Define(stage, "/robot/fix").CreateBody1Rel().SetTargets(["/robot/base"])
    for name, x in (("left", 0.0), ("right", 0.4)):
        joint = UsdPhysics.RevoluteJoint.Define(stage, f"/robot/{name}_hinge")
        joint.CreateAxisAttr("Y")
        joint.CreateBody0Rel().SetTargets(["/robot/base"])
        joint.CreateBody1Rel().SetTargets([f"/robot/{name}"])
        joint.CreateLocalPos0Attr(Gf.Vec3f(x, 0, 0))
    slide = UsdPhysics.PrismaticJoint.Define(stage, "/robot/piston")
    slide.CreateAxisAttr("X")
    slide.CreateBody0Rel().SetTargets(["/robot/left"])
    slide.CreateBody1Rel().SetTargets(["/robot/right"])
    slide.CreateLocalPos0Attr(Gf.Vec3f(0.4, 0, 0.3))
    slide.CreateLocalPos1Attr(Gf.Vec3f(0, 0, 0.3))
    slide.CreateExcludeFromArticulationAttr(True)
    drive = UsdPhysics.DriveAPI.Apply(slide.GetPrim(), "linear")
    drive.CreateStiffnessAttr(200.0)
    drive.CreateDampingAttr(5.0)
    drive.CreateMaxForceAttr(12.0)
    tendon = stage.DefinePrim("/robot/cord", "MjcTendon")
    tendon.CreateAttribute("mjc:type", Sdf.ValueTypeNames.Token).Set("fixed")
    tendon.CreateRelationship("mjc:path").SetTargets(["/robot/left_hinge"])
    tendon.CreateAttribute("mjc:path:coef", Sdf.ValueTypeNames.DoubleArray).Set([1.0])
    pull = stage.DefinePrim("/robot/pull", "MjcActuator")
    pull.CreateRelationship("mjc:target").SetTargets(["/robot/cord"])
    stage.Save()
    return path


def _start(path, actuators, physics):
    sim = sim_utils.SimulationContext(sim_utils.SimulationCfg(device="cpu", physics=physics, dt=0.002))
    robot = ArticulationCfg(
        prim_path="{ENV_REGEX_NS}/Robot", spawn=sim_utils.UsdFileCfg(usd_path=path), actuators=actuators
    )
    scene = InteractiveScene(_SceneCfg(num_envs=NUM_ENVS, env_spacing=2.0, robot=robot))
    sim.reset()
    return sim, scene["robot"]


def _imported_efforts(path, kp, target):
    model = load(path)[0].compile()
    data = mujoco.MjData(model)
    piston = model.actuator("piston").id
    model.actuator_gainprm[piston, 0], model.actuator_biasprm[piston, 1] = kp, -kp
    data.ctrl[piston] = target
    mujoco.mj_forward(model, data)
    return {model.joint(j).name: data.qfrc_actuator[model.jnt_dofadr[j]] for j in range(model.njnt)}


_FILE = {"joint_names_expr": [".*"], "stiffness": None, "damping": None}


@pytest.mark.parametrize("physics", ["native", "warp"])
@pytest.mark.parametrize(
    ("actuators", "kp", "target"),
    [
        ({"all": ImplicitActuatorCfg(**_FILE)}, 200.0, 0.03),
        ({}, 200.0, 0.03),
        ({}, 200.0, 0.5),  # beyond the force limit
        ({"all": ImplicitActuatorCfg(**(_FILE | {"stiffness": 90.0}))}, 90.0, -0.05),
    ],
    ids=["file", "no group", "limited", "stiffness given"],
)
def test_a_target_of_the_loops_joint_moves_its_two_bodies(robot_file, physics, actuators, kp, target):
    sim, robot = _start(robot_file, {name: cfg.copy() for name, cfg in actuators.items()}, physics)
    piston = robot.joint_names.index("piston")
    targets = torch.zeros(NUM_ENVS, robot.num_joints)
    targets[:, piston] = target
    robot.set_joint_position_target(targets)
    robot.write_data_to_sim()
    sim.physics.forward()
    found = sim.physics.field("qfrc_actuator").numpy()[:, [robot._dof_ids[i] for i in range(robot.num_joints)]]
    imported = _imported_efforts(robot_file, kp, target)
    assert abs(imported["right_hinge"]) > 0.5
    expected = [imported[name] for name in robot.joint_names]
    np.testing.assert_allclose(found, [expected] * NUM_ENVS, rtol=1e-4, atol=1e-5)
    assert robot.data.joint_stiffness[0, piston] == kp
    assert robot.data.joint_effort_limits[0, piston] == 12.0
    sim.close()


def test_actuators_that_no_target_reaches_are_named(robot_file, caplog):
    with caplog.at_level(logging.WARNING, "lift_lab.assets.articulation.drives"):
        sim, _ = _start(robot_file, {"all": ImplicitActuatorCfg(**_FILE)}, "native")
    assert any("'pull'" in line and "no target reaches them" in line for line in caplog.messages)
    sim.close()
