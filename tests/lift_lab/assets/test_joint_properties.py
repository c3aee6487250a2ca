"""What is written of a joint's gains and friction reaches what it names, and nothing else."""

import pytest
import torch

import lift_lab.sim as sim_utils
from lift_lab.actuators import IdealPDActuatorCfg, ImplicitActuatorCfg
from lift_lab.scene import InteractiveScene, InteractiveSceneCfg
from lift_lab.sim.ignored import ignored_settings
from lift_lab.utils import configclass
from lift_lab_assets import FRANKA_PANDA_CFG

NUM_ENVS = 2


@configclass
class _SceneCfg(InteractiveSceneCfg):
    robot = FRANKA_PANDA_CFG.replace(
        prim_path="{ENV_REGEX_NS}/Robot",
        actuators={
            "arm": IdealPDActuatorCfg(joint_names_expr=["panda_joint.*"], stiffness=80.0, damping=4.0),
            "hand": ImplicitActuatorCfg(joint_names_expr=["panda_finger.*"], stiffness=2000.0, damping=100.0),
        },
    )


@pytest.fixture
def robot():
    sim = sim_utils.SimulationContext(sim_utils.SimulationCfg(device="cpu"))
    scene = InteractiveScene(_SceneCfg(num_envs=NUM_ENVS, env_spacing=2.0))
    sim.reset()
    yield scene["robot"]
    sim.close()


def test_gains_that_a_term_gave_an_explicit_model_outlive_those_of_other_joints(robot):
    arm, hand = robot.actuators["arm"], robot.actuators["hand"]
    arm.stiffness[1] = 60.0
    arm.damping[1] = 3.0
    robot.write_joint_stiffness_to_sim(1500.0, joint_ids=hand.joint_indices, env_ids=[0])
    robot.write_joint_damping_to_sim(90.0, joint_ids=hand.joint_indices, env_ids=[0])
    torch.testing.assert_close(arm.stiffness, torch.tensor([[80.0] * 7, [60.0] * 7]))
    torch.testing.assert_close(arm.damping, torch.tensor([[4.0] * 7, [3.0] * 7]))
    torch.testing.assert_close(hand.stiffness, torch.tensor([[1500.0] * 2, [2000.0] * 2]))
    torch.testing.assert_close(hand.damping, torch.tensor([[90.0] * 2, [100.0] * 2]))


def test_gains_written_by_name_reach_the_explicit_model(robot):
    robot.write_joint_stiffness_to_sim(torch.tensor([[70.0]]), joint_ids=[2], env_ids=[1])
    expected = torch.full((NUM_ENVS, 7), 80.0)
    expected[1, 2] = 70.0
    torch.testing.assert_close(robot.actuators["arm"].stiffness, expected)
    torch.testing.assert_close(robot.data.joint_stiffness[:, :7], expected)


def test_friction_is_written_with_isaac_labs_arguments(robot):
    robot.write_joint_friction_coefficient_to_sim(
        torch.tensor([[0.5, 0.6]]),
        joint_dynamic_friction_coeff=torch.tensor([[0.4, 0.4]]),
        joint_viscous_friction_coeff=torch.tensor([[1.5, 1.6]]),
        joint_ids=[0, 3],
        env_ids=[1],
    )
    friction, viscous = robot.data.joint_friction_coeff, robot.data.joint_viscous_friction_coeff
    torch.testing.assert_close(friction[1, [0, 3]], torch.tensor([0.5, 0.6]))
    torch.testing.assert_close(viscous[1, [0, 3]], torch.tensor([1.5, 1.6]))
    torch.testing.assert_close(friction[0], robot.data.default_joint_friction_coeff[0])
    assert any("dynamic_friction" in path for path in ignored_settings())
    robot.write_joint_viscous_friction_coefficient_to_sim(joint_viscous_friction_coeff=2.0, joint_ids=[1])
    torch.testing.assert_close(viscous[:, 1], torch.tensor([2.0] * NUM_ENVS))
    robot.write_joint_friction_to_sim(0.7, [6], [0])  # Isaac Lab's older function, whose second argument are joints
    torch.testing.assert_close(robot.data.joint_friction[:, 6], torch.tensor([0.7, float(friction[1, 6])]))
    torch.testing.assert_close(robot.data.default_joint_friction, robot.data.default_joint_friction_coeff)
