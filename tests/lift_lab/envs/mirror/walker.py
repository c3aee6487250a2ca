"""A free body with four legs, as a walking robot has them: each with a hip about x and a thigh about y."""

from pathlib import Path

from pxr import Gf, Usd, UsdGeom, UsdPhysics

import lift_lab.envs.mdp as mdp
import lift_lab.sim as sim_utils
from lift_lab.actuators import ImplicitActuatorCfg
from lift_lab.assets import ArticulationCfg
from lift_lab.assets.articulation import ArticulationMirrorCfg
from lift_lab.envs import ManagerBasedRLEnv, ManagerBasedRLEnvCfg
from lift_lab.envs.mirror import MirrorCfg
from lift_lab.managers import ObservationGroupCfg, SceneEntityCfg, TerminationTermCfg
from lift_lab.managers import ObservationTermCfg as ObsTerm
from lift_lab.scene import InteractiveSceneCfg
from lift_lab.utils import configclass
from lift_lab.utils.mirror import MirrorTermCfg

LEGS = {"FL": (0.2, 0.1), "FR": (0.2, -0.1), "RL": (-0.2, 0.1), "RR": (-0.2, -0.1)}


def author_walker(path: Path) -> Path:
    """Write the robot into a USD file."""
    stage = Usd.Stage.CreateNew(str(path))
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.z)
    root = UsdGeom.Xform.Define(stage, "/Walker").GetPrim()
    stage.SetDefaultPrim(root)
    UsdPhysics.ArticulationRootAPI.Apply(root)

    def link(name: str, pos: tuple[float, float, float], mass: float) -> None:
        prim = UsdGeom.Xform.Define(stage, f"/Walker/{name}")
        prim.AddTranslateOp().Set(Gf.Vec3d(*pos))
        UsdPhysics.RigidBodyAPI.Apply(prim.GetPrim())
        api = UsdPhysics.MassAPI.Apply(prim.GetPrim())
        api.CreateMassAttr(mass)
        api.CreateDiagonalInertiaAttr(Gf.Vec3f(0.02, 0.02, 0.02))
        api.CreatePrincipalAxesAttr(Gf.Quatf(1, 0, 0, 0))

    def hinge(name: str, parent: str, child: str, at: tuple[float, float, float], axis: str) -> None:
        joint = UsdPhysics.RevoluteJoint.Define(stage, f"/Walker/{name}")
        joint.CreateBody0Rel().SetTargets([f"/Walker/{parent}"])
        joint.CreateBody1Rel().SetTargets([f"/Walker/{child}"])
        joint.CreateLocalPos0Attr(Gf.Vec3f(*at))
        joint.CreateAxisAttr(axis)
        joint.CreateLowerLimitAttr(-60.0)
        joint.CreateUpperLimitAttr(60.0)

    link("base", (0.0, 0.0, 0.5), 5.0)
    for leg, (x, y) in LEGS.items():
        out = 0.05 if y > 0 else -0.05
        link(f"{leg}_hip", (x, y, 0.5), 0.5)
        link(f"{leg}_thigh", (x, y + out, 0.3), 0.5)
        hinge(f"{leg}_hip_joint", "base", f"{leg}_hip", (x, y, 0.0), "X")
        hinge(f"{leg}_thigh_joint", f"{leg}_hip", f"{leg}_thigh", (0.0, out, -0.2), "Y")
    stage.Save()
    return path


@configclass
class _ActionsCfg:
    legs = mdp.JointPositionActionCfg(
        asset_name="robot", joint_names=[".*"], scale={".*_hip_joint": 0.25, ".*_thigh_joint": 0.5}
    )


@configclass
class _CommandsCfg:
    velocity = mdp.UniformVelocityCommandCfg(
        asset_name="robot",
        resampling_time_range=(5.0, 5.0),
        ranges=mdp.UniformVelocityCommandCfg.Ranges(
            lin_vel_x=(-1.0, 1.0), lin_vel_y=(-1.0, 1.0), ang_vel_z=(-1.0, 1.0)
        ),
    )


def left_feet_first(env):
    """A term that the project does not know: heights of the left thighs, then of the right ones, in m."""
    robot = env.scene["robot"]
    ids = robot.find_bodies(["FL_thigh", "RL_thigh", "FR_thigh", "RR_thigh"], preserve_order=True)[0]
    return robot.data.body_pos_w[:, ids, 2]


HEIGHTS = MirrorTermCfg(order=[2, 3, 0, 1])
"""Mirror image of that term: left and right change places."""

WALKER_MIRROR = ArticulationMirrorCfg(
    signs={".*_hip_joint": -1, ".*_thigh_joint": 1}, swaps={"FL_": "FR_", "RL_": "RR_"}
)


def _group(**terms) -> dict:
    group = ObservationGroupCfg()
    for name, term in terms.items():
        setattr(group, name, term)
    return {"policy": group}


def make_walker(path: Path, physics: str = "native", **mirror) -> ManagerBasedRLEnv:
    """The environment, with the usual observations of a velocity task and an unknown one."""
    thighs = SceneEntityCfg("robot", body_names=".*_thigh")

    @configclass
    class SceneCfg(InteractiveSceneCfg):
        robot = ArticulationCfg(
            prim_path="{ENV_REGEX_NS}/Robot",
            spawn=sim_utils.UsdFileCfg(usd_path=str(path)),
            init_state=ArticulationCfg.InitialStateCfg(
                pos=(0.0, 0.0, 0.5), joint_pos={"F._hip_joint": 0.1, "R._hip_joint": -0.1, ".*_thigh_joint": 0.3}
            ),
            actuators={"legs": ImplicitActuatorCfg(joint_names_expr=[".*"], stiffness=20.0, damping=1.0)},
        )

    @configclass
    class EnvCfg(ManagerBasedRLEnvCfg):
        scene = SceneCfg(num_envs=3, env_spacing=2.0)
        actions = _ActionsCfg()
        commands = _CommandsCfg()
        observations = _group(
            lin_vel=ObsTerm(func=mdp.base_lin_vel, scale=2.0),
            ang_vel=ObsTerm(func=mdp.base_ang_vel, scale=(0.2, 0.3, 0.4), clip=(-100.0, 100.0)),
            gravity=ObsTerm(func=mdp.projected_gravity),
            command=ObsTerm(func=mdp.generated_commands, params={"command_name": "velocity"}),
            joint_pos=ObsTerm(func=mdp.joint_pos_rel, scale=3.0, history_length=2),
            joint_vel=ObsTerm(func=mdp.joint_vel_rel),
            in_limits=ObsTerm(func=mdp.joint_pos_limit_normalized),
            quat=ObsTerm(func=mdp.root_quat_w),
            thighs=ObsTerm(func=mdp.body_pose_w, params={"asset_cfg": thighs}),
            actions=ObsTerm(func=mdp.last_action),
            heights=ObsTerm(func=left_feet_first),
        )
        rewards = None
        terminations = {"time_out": TerminationTermCfg(func=mdp.time_out, time_out=True)}

    cfg = EnvCfg()
    cfg.decimation, cfg.episode_length_s, cfg.seed = 2, 2.0, 1
    cfg.sim.device, cfg.sim.physics = "cpu", physics
    known = {"assets": {"robot": WALKER_MIRROR.copy()}, "observations": {"heights": HEIGHTS}}
    cfg.mirror = MirrorCfg(**{**known, **mirror})
    env = ManagerBasedRLEnv(cfg)
    env.reset()
    return env
