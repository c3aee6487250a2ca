"""What an editor knows of a user's code: pyright reads it as an installed package with its py.typed."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

pytest.importorskip("pyright")

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture
def check(tmp_path):
    """Errors of pyright's standard mode in some code: pairs of the line's text and the rule."""

    def run(code: str) -> list[tuple[str, str]]:
        (tmp_path / "snippet.py").write_text(code)
        settings = {"include": ["snippet.py"], "typeCheckingMode": "standard", "pythonVersion": "3.11"}
        (tmp_path / "pyrightconfig.json").write_text(json.dumps(settings | {"stubPath": str(ROOT / "typings")}))
        command = [sys.executable, "-m", "pyright", "--outputjson", "-p", str(tmp_path), "--pythonpath", sys.executable]
        env = os.environ | {"PYTHONPATH": str(ROOT / "source")}
        report = subprocess.run(command, capture_output=True, text=True, timeout=120, env=env).stdout
        lines = code.splitlines()
        errors = [item for item in json.loads(report)["generalDiagnostics"] if item["severity"] == "error"]
        return [(lines[error["range"]["start"]["line"]].strip(), error["rule"]) for error in errors]

    return run


def test_names_that_mujoco_and_usd_do_not_have_are_reported(check):
    right = """
import mujoco
import numpy as np
from pxr import Usd, UsdGeom

spec = mujoco.MjSpec()
body = spec.worldbody.add_body(name="a", pos=np.zeros(3))
body.add_geom(type=mujoco.mjtGeom.mjGEOM_BOX, size=[1.0, 1.0, 1.0])
model = spec.compile()
model.body_pos[0] = 1.0
stage = Usd.Stage.CreateInMemory()
mesh = UsdGeom.Mesh.Define(stage, "/Mesh")
mesh.GetPointsAttr().Set([])
path: str = mesh.GetPrim().GetPath().pathString
"""
    wrong = """
model.body_poss
spec.worldbody.add_body(nam="b")
spec.geoms[0].rgbaa
mujoco.mjtGeom.mjGEOM_BOXX
mujoco.mj_stepp
stage.GetPrimAtPaht("/Mesh")
mesh.GetPointAttr()
mesh.GetPrim().GetPath().pathstring
UsdGeom.Mehs
model.nq = 3
"""
    assert [line for line, _ in check(right + wrong)] == wrong.split("\n")[1:-1]


def test_a_task_in_isaac_labs_style_passes_and_its_mistakes_are_reported(check):
    right = """
import torch

import lift_lab.envs.mdp as mdp
import lift_lab.sim as sim_utils
import lift_lab_assets
from lift_lab.assets import Articulation, ArticulationCfg, AssetBaseCfg, RigidObject, RigidObjectCfg
from lift_lab.envs import ManagerBasedRLEnv, ManagerBasedRLEnvCfg
from lift_lab.managers import ActionTerm, ObservationGroupCfg, ObservationTermCfg, RewardTermCfg, SceneEntityCfg
from lift_lab.scene import InteractiveSceneCfg
from lift_lab.sensors import ContactSensor
from lift_lab.utils import MISSING, configclass
from lift_lab_assets import FRANKA_PANDA_CFG
from lift_lab_tasks.manager_based.manipulation.lift.lift_env_cfg import LiftEnvCfg


def height(env: ManagerBasedRLEnv, asset_cfg: SceneEntityCfg = SceneEntityCfg("object")) -> torch.Tensor:
    asset: RigidObject = env.scene[asset_cfg.name]
    sensor: ContactSensor = env.scene.sensors["touch"]
    robot: Articulation = env.scene["robot"]
    force: torch.Tensor = sensor.data.net_forces_w
    speed: torch.Tensor = asset.data.root_lin_vel_w + robot.data.joint_velocity_limits[:, :3]
    return asset.data.root_pos_w[:, 2] + speed[:, 0] + force[:, 0, 0]


@configclass
class SceneCfg(InteractiveSceneCfg):
    robot: ArticulationCfg = FRANKA_PANDA_CFG.replace(prim_path="{ENV_REGEX_NS}/Robot")
    table: AssetBaseCfg = MISSING
    object: RigidObjectCfg = RigidObjectCfg(
        prim_path="{ENV_REGEX_NS}/Object",
        init_state=RigidObjectCfg.InitialStateCfg(pos=(0.5, 0.0, 0.1)),
        spawn=sim_utils.CuboidCfg(size=(0.1, 0.1, 0.1), mass_props=sim_utils.MassPropertiesCfg(mass=0.1)),
    )


@configclass
class ActionsCfg:
    arm: mdp.JointPositionActionCfg = mdp.JointPositionActionCfg(asset_name="robot", joint_names=["panda_joint.*"])


@configclass
class ObservationsCfg:
    @configclass
    class PolicyCfg(ObservationGroupCfg):
        joints = ObservationTermCfg(func=mdp.joint_pos_rel)

    policy: PolicyCfg = PolicyCfg()


@configclass
class RewardsCfg:
    height = RewardTermCfg(func=height, weight=1.0)


@configclass
class MyEnvCfg(ManagerBasedRLEnvCfg):
    scene: SceneCfg = SceneCfg(num_envs=16, env_spacing=2.0)
    actions: ActionsCfg = ActionsCfg()
    observations: ObservationsCfg = ObservationsCfg()
    rewards: RewardsCfg = RewardsCfg()
    speed: float = MISSING

    def __post_init__(self):
        super().__post_init__()
        self.decimation = 2
        self.scene.robot.init_state.pos = (0.0, 0.0, 0.1)


class MyAction(ActionTerm):
    cfg: mdp.JointPositionActionCfg


cfg = MyEnvCfg(speed=2.0)
cfg.copy().validate()
own = LiftEnvCfg()
own.rewards.lifting_object.weight = 2.0
"""
    wrong = """
FRANKA_PANDA_CFG.replac(prim_path="a")
lift_lab_assets.FRANKA_PANDAS_CFG
sim_utils.CuboidCfg(sise=(0.1, 0.1, 0.1))
MyEnvCfg(sped=2.0)
cfg.scene.robott
cfg.decimtion = 2
RewardTermCfg(func=height, wait=1.0)
mdp.joint_pos_rell
def term(robot: Articulation): return robot.data.root_lin_vel
"""
    assert [line for line, _ in check(right + wrong)] == wrong.split("\n")[1:-1]
