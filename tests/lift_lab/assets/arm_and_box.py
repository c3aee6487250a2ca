"""A scene that tests of assets share: an arm of two links on hinges, and a box."""

import math
from pathlib import Path

from pxr import Gf, Usd, UsdGeom, UsdPhysics

import lift_lab.sim as sim_utils
from lift_lab.actuators import ImplicitActuatorCfg
from lift_lab.assets import ArticulationCfg, RigidObjectCfg
from lift_lab.scene import InteractiveScene, InteractiveSceneCfg
from lift_lab.sensors import FrameTransformerCfg
from lift_lab.utils import configclass

NUM_ENVS = 3
SPACING = 2.0


def author_arm(path: Path) -> None:
    """Two links on hinges about y, fixed to the world: shoulder at 0.5 m, link 1 is 0.4 m long."""
    stage = Usd.Stage.CreateNew(str(path))
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.z)
    root = UsdGeom.Xform.Define(stage, "/Arm").GetPrim()
    stage.SetDefaultPrim(root)
    UsdPhysics.ArticulationRootAPI.Apply(root)
    for name, pos, mass in (
        ("base", (0, 0, 0.5), 2.0),
        ("upper", (0, 0, 0.5), 1.0),
        ("lower", (0.4, 0, 0.5), 0.5),
    ):
        link = UsdGeom.Xform.Define(stage, f"/Arm/{name}")
        link.AddTranslateOp().Set(Gf.Vec3d(*pos))
        UsdPhysics.RigidBodyAPI.Apply(link.GetPrim())
        api = UsdPhysics.MassAPI.Apply(link.GetPrim())
        api.CreateMassAttr(mass)
        api.CreateCenterOfMassAttr(Gf.Vec3f(0.2, 0, 0) if name != "base" else Gf.Vec3f(0, 0, 0))
        api.CreateDiagonalInertiaAttr(Gf.Vec3f(0.01, 0.02, 0.02))
        api.CreatePrincipalAxesAttr(Gf.Quatf(1, 0, 0, 0))
    fixed = UsdPhysics.FixedJoint.Define(stage, "/Arm/root_joint")
    fixed.CreateBody1Rel().SetTargets(["/Arm/base"])
    fixed.CreateLocalPos0Attr(Gf.Vec3f(0, 0, 0.5))
    for name, body0, body1, at in (
        ("shoulder", "base", "upper", (0, 0, 0)),
        ("elbow", "upper", "lower", (0.4, 0, 0)),
    ):
        joint = UsdPhysics.RevoluteJoint.Define(stage, f"/Arm/{name}")
        joint.CreateBody0Rel().SetTargets([f"/Arm/{body0}"])
        joint.CreateBody1Rel().SetTargets([f"/Arm/{body1}"])
        joint.CreateLocalPos0Attr(Gf.Vec3f(*at))
        joint.CreateAxisAttr("Y")
        joint.CreateLowerLimitAttr(-90.0)
        joint.CreateUpperLimitAttr(120.0)
        drive = UsdPhysics.DriveAPI.Apply(joint.GetPrim(), "angular")
        drive.CreateStiffnessAttr(30.0 * math.pi / 180.0)
        drive.CreateDampingAttr(3.0 * math.pi / 180.0)
        drive.CreateMaxForceAttr(25.0)
    stage.Save()


@configclass
class SceneCfg(InteractiveSceneCfg):
    arm: ArticulationCfg | None = None
    box: RigidObjectCfg | None = None
    tip: FrameTransformerCfg | None = None


def box_cfg(**rigid) -> RigidObjectCfg:
    return RigidObjectCfg(
        prim_path="{ENV_REGEX_NS}/Box",
        init_state=RigidObjectCfg.InitialStateCfg(pos=(1.0, 0.0, 2.0), lin_vel=(0.5, 0.0, 0.0)),
        spawn=sim_utils.CuboidCfg(
            size=(0.2, 0.1, 0.1),
            rigid_props=sim_utils.RigidBodyPropertiesCfg(**rigid),
            mass_props=sim_utils.MassPropertiesCfg(mass=0.6),
            collision_props=sim_utils.CollisionPropertiesCfg(),
        ),
    )


def arm_cfg(path: Path, actuators: dict) -> ArticulationCfg:
    return ArticulationCfg(
        prim_path="{ENV_REGEX_NS}/Arm",
        spawn=sim_utils.UsdFileCfg(usd_path=str(path)),
        init_state=ArticulationCfg.InitialStateCfg(joint_pos={"shoulder": 0.3, "elbow": -0.2}),
        actuators=actuators,
    )


def implicit(stiffness=50.0, damping=5.0) -> dict:
    return {"all": ImplicitActuatorCfg(joint_names_expr=[".*"], stiffness=stiffness, damping=damping)}


def start(physics: str = "native", gravity=(0.0, 0.0, -9.81), num_envs: int = NUM_ENVS, **entities):
    sim = sim_utils.SimulationContext(sim_utils.SimulationCfg(device="cpu", physics=physics, dt=0.002, gravity=gravity))
    scene = InteractiveScene(SceneCfg(num_envs=num_envs, env_spacing=SPACING, **entities))
    sim.reset()
    scene.update(0.0)
    return sim, scene
