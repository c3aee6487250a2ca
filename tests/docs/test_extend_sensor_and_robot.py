"""The sensor and the robot of the page on extending lift_lab work as they are written."""

import importlib
import re
import sys
from pathlib import Path

import gymnasium as gym
import pytest
import torch

from lift_lab.envs import ManagerBasedRLEnv
from lift_lab.managers import ObservationTermCfg
from lift_lab_assets import robots
from lift_lab_tasks.manager_based.classic.cartpole.cartpole_env_cfg import CartpoleEnvCfg

PAGE = Path(__file__).resolve().parents[2] / "docs" / "extend.md"
GRAVITY = 9.81


def _blocks(section: str) -> list[str]:
    text = PAGE.read_text().split(f"\n## {section}\n")[1].split("\n## ")[0]
    return re.findall(r"^```py(?: [^\n]*)?\n(.*?)^```$", text, flags=re.DOTALL | re.MULTILINE)


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A folder of modules that are forgotten after the test."""
    monkeypatch.syspath_prepend(str(tmp_path))
    before = set(sys.modules)
    yield tmp_path
    for name in set(sys.modules) - before:
        if str(getattr(sys.modules[name], "__file__", "")).startswith(str(tmp_path)):
            del sys.modules[name]


@pytest.mark.parametrize("physics", ["native", "warp"])
def test_the_sensor_of_the_page_weighs_the_pole_of_a_cart(folder, physics):
    """At rest and upright the cart carries the pole: its weight along z, and nothing else."""
    (folder / "force_torque.py").write_text(_blocks("Add a sensor")[0])
    module = importlib.import_module("force_torque")
    cfg = CartpoleEnvCfg()
    cfg.scene.num_envs = 3
    cfg.sim.device, cfg.sim.physics = "cpu", physics
    cfg.events.reset_pole_position.params.update(position_range=(0.0, 0.0), velocity_range=(0.0, 0.0))
    cfg.events.reset_cart_position.params.update(position_range=(0.0, 0.0), velocity_range=(0.0, 0.0))
    cfg.scene.wrist = module.ForceTorqueSensorCfg(prim_path="{ENV_REGEX_NS}/Robot/pole")
    cfg.observations.policy.force = ObservationTermCfg(func=module.measured_force, params={"sensor_name": "wrist"})
    env = ManagerBasedRLEnv(cfg)
    env.reset()
    obs = env.step(torch.zeros(3, 1))[0]["policy"]
    mass = float(env.scene["robot"].data.default_mass[0, env.scene["robot"].find_bodies("pole")[0]].sum())
    torch.testing.assert_close(obs[:, -3:], torch.tensor([0.0, 0.0, mass * GRAVITY]).expand(3, 3), atol=1e-2, rtol=0.0)
    assert env.scene["wrist"].data.torque_b.shape == (3, 3)
    with pytest.raises(AttributeError, match=r"'wrist' .*no 'forces_b'; did you mean 'force_b'"):
        env.scene["wrist"].data.forces_b  # noqa: B018
    env.close()


ARM = """#usda 1.0
(
    defaultPrim = "Arm"
    metersPerUnit = 1
    upAxis = "Z"
)

def Xform "Arm" (prepend apiSchemas = ["PhysicsArticulationRootAPI"])
{
    def PhysicsFixedJoint "root_joint"
    {
        rel physics:body1 = </Arm/base>
    }
    def Xform "base" (prepend apiSchemas = ["PhysicsRigidBodyAPI", "PhysicsMassAPI"])
    {
        LINK
    }
    def Xform "upper" (prepend apiSchemas = ["PhysicsRigidBodyAPI", "PhysicsMassAPI"])
    {
        LINK
    }
    def Xform "hand" (prepend apiSchemas = ["PhysicsRigidBodyAPI", "PhysicsMassAPI"])
    {
        LINK
        double3 xformOp:translate = (0.4, 0, 0)
        uniform token[] xformOpOrder = ["xformOp:translate"]
    }
    def PhysicsRevoluteJoint "joint1"
    {
        uniform token physics:axis = "Z"
        rel physics:body0 = </Arm/base>
        rel physics:body1 = </Arm/upper>
    }
    def PhysicsRevoluteJoint "joint2"
    {
        uniform token physics:axis = "Z"
        rel physics:body0 = </Arm/upper>
        rel physics:body1 = </Arm/hand>
        point3f physics:localPos0 = (0.4, 0, 0)
    }
}
""".replace("LINK", "float physics:mass = 1\n float3 physics:diagonalInertia = (0.01, 0.01, 0.01)")


def test_the_robot_of_the_page_needs_a_usd_file_a_robot_file_and_a_task_file(folder, monkeypatch):
    robot, task = _blocks("Add a robot")
    (folder / "robots").mkdir()
    monkeypatch.setattr(robots, "__path__", [*robots.__path__, str(folder / "robots")])
    (folder / "my_arm.usda").write_text(ARM)
    (folder / "robots" / "my_arm.py").write_text(robot.replace("{ASSETS_USD_DIR}", str(folder)))
    (folder / "my_reach.py").write_text(task)
    robots.robot_configs.cache_clear()
    try:
        importlib.import_module("my_reach")
        cfg = gym.spec("Reach-My-Arm").kwargs["env_cfg_entry_point"]()
        cfg.scene.num_envs, cfg.sim.device, cfg.sim.physics = 2, "cpu", "native"
        cfg.validate()
        env = gym.make("Reach-My-Arm", cfg=cfg).unwrapped
        env.reset()
        obs = env.step(torch.zeros(2, 2))[0]["policy"]
        assert env.scene["robot"].joint_names == ["joint1", "joint2"]
        assert obs.shape == (2, 2 + 2 + 7 + 2)
        assert torch.isfinite(obs).all()
        env.close()
    finally:
        gym.registry.pop("Reach-My-Arm", None)
        robots.robot_configs.cache_clear()
