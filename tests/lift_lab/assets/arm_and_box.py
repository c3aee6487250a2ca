"""A scene that tests of assets share: an arm of two links on hinges, and a box."""

from pathlib import Path

import lift_lab.sim as sim_utils
from lift_lab.actuators import ImplicitActuatorCfg
from lift_lab.assets import ArticulationCfg, RigidObjectCfg
from lift_lab.scene import InteractiveScene, InteractiveSceneCfg
from lift_lab.sensors import FrameTransformerCfg
from lift_lab.utils import configclass

NUM_ENVS = 3
SPACING = 2.0


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
