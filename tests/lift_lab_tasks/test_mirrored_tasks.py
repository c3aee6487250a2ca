"""A state of a shipped task and its mirror image, written by hand, are observed as the declared map says."""

import math

import pytest
import torch

from lift_lab.envs import ManagerBasedRLEnv
from lift_lab.envs.mirror import TaskMirror, check_mirror
from lift_lab.utils.errors import ConfigError
from lift_lab_rl.rsl_rl import LiftLabRunner, RslRlSymmetryCfg, RslRlVecEnvWrapper, to_rsl_rl
from lift_lab_tasks.manager_based.classic.cartpole.agents.rsl_rl_ppo_cfg import CartpolePPORunnerCfg
from lift_lab_tasks.manager_based.classic.cartpole.cartpole_env_cfg import CartpoleEnvCfg
from lift_lab_tasks.manager_based.manipulation.lift.config.franka import (
    ik_abs_env_cfg,
    ik_rel_env_cfg,
    joint_pos_env_cfg,
    soft_cube_env_cfg,
)
from lift_lab_tasks.manager_based.manipulation.reach.config.franka import ik_abs_env_cfg as reach_ik_abs
from lift_lab_tasks.manager_based.manipulation.reach.config.franka import ik_rel_env_cfg as reach_ik_rel
from lift_lab_tasks.manager_based.manipulation.reach.config.franka import joint_pos_env_cfg as reach_joint_pos

LIFT = {
    "joint positions": joint_pos_env_cfg.FrankaCubeLiftEnvCfg,
    "relative poses": ik_rel_env_cfg.FrankaCubeLiftEnvCfg,
    "absolute poses": ik_abs_env_cfg.FrankaCubeLiftEnvCfg,
}


def panda_image(pos: torch.Tensor) -> torch.Tensor:
    """The Panda's joints mirrored in y = 0, from its kinematics: axes 1, 3, 5 and 7 turn the other way, the flange
    is turned by pi/4 to the hand on either side, and the fingers change places."""
    q1, q2, q3, q4, q5, q6, q7, left, right = pos.unbind(-1)
    return torch.stack([-q1, q2, -q3, q4, -q5, q6, math.pi / 2 - q7, right, left], -1)


def panda_speed_image(vel: torch.Tensor) -> torch.Tensor:
    q1, q2, q3, q4, q5, q6, q7, left, right = vel.unbind(-1)
    return torch.stack([-q1, q2, -q3, q4, -q5, q6, -q7, right, left], -1)


def mirrored_pose(pose: torch.Tensor) -> torch.Tensor:
    x, y, z, qw, qx, qy, qz = pose.unbind(-1)
    return torch.stack([x, -y, z, qw, -qx, qy, -qz], -1)


def make(cfg, physics="native") -> ManagerBasedRLEnv:
    cfg.scene.num_envs, cfg.sim.device, cfg.sim.physics, cfg.seed = 2, "cpu", physics, 3
    env = ManagerBasedRLEnv(cfg)
    env.reset()
    return env


def write_a_state_and_its_image(env: ManagerBasedRLEnv) -> None:
    """Random joints, object, command and action in environment 0, and their mirror images in environment 1."""
    torch.manual_seed(1)
    robot, cube = env.scene["robot"], env.scene["object"]
    pos = robot.data.default_joint_pos[:1] + 0.3 * torch.randn(1, 9)
    pos[:, 7:] = torch.tensor([0.01, 0.03])
    vel = torch.randn(1, 9)
    robot.write_joint_state_to_sim(torch.cat([pos, panda_image(pos)]), torch.cat([vel, panda_speed_image(vel)]))
    quat = torch.nn.functional.normalize(torch.randn(1, 4), dim=-1)
    pose = torch.cat([torch.tensor([[0.5, 0.13, 0.2]]), quat], -1)
    both = torch.cat([pose, mirrored_pose(pose)])
    both[:, :3] += env.scene.env_origins
    cube.write_root_pose_to_sim(both)
    goal = torch.cat([torch.tensor([[0.45, -0.2, 0.3]]), quat], -1)
    env.command_manager.get_command("object_pose")[:] = torch.cat([goal, mirrored_pose(goal)])
    env.sim.physics.refresh()
    env.scene.update(0.0)


@pytest.mark.parametrize(
    ("task", "physics"),
    [*((task, "native") for task in LIFT), pytest.param("joint positions", "warp", marks=pytest.mark.slow)],
)
def test_the_lift_is_observed_mirrored(task, physics):
    env = make(LIFT[task](), physics)
    write_a_state_and_its_image(env)
    mirror = TaskMirror(env)
    action = torch.randn(1, env.action_manager.total_action_dim)
    env.action_manager.process_action(torch.cat([action, mirror.actions().to("cpu")(action)]))
    obs = env.observation_manager.compute()["policy"]
    image = mirror.group("policy").to("cpu")
    torch.testing.assert_close(image(obs[:1]), obs[1:], atol=1e-5, rtol=0.0)
    torch.testing.assert_close(image(obs[1:]), obs[:1], atol=1e-5, rtol=0.0)
    env.close()


@pytest.mark.parametrize("task", LIFT)
def test_a_mirrored_action_moves_the_arm_to_the_mirrored_place(task):
    """The targets that both environments give their joints are images of each other."""
    env = make(LIFT[task]())
    write_a_state_and_its_image(env)
    action = 0.3 * torch.randn(1, env.action_manager.total_action_dim)
    if task == "absolute poses":
        action[:, :7] = torch.tensor([0.5, 0.1, 0.3, 0.0, 1.0, 0.1, 0.0])
    env.action_manager.process_action(torch.cat([action, TaskMirror(env).actions().to("cpu")(action)]))
    env.action_manager.apply_action()
    targets = env.scene["robot"].data.joint_pos_target
    torch.testing.assert_close(panda_image(targets[:1]), targets[1:], atol=2e-4, rtol=0.0)
    env.close()


def test_the_hand_of_the_mirrored_arm_is_the_mirrored_hand():
    env = make(LIFT["joint positions"]())
    write_a_state_and_its_image(env)
    robot = env.scene["robot"]
    hand = robot.find_bodies("panda_hand")[0][0]
    place = robot.data.body_pos_w[:, hand] - env.scene.env_origins
    turn = robot.data.body_quat_w[:, hand]
    image = mirrored_pose(torch.cat([place, turn], -1)[:1])
    torch.testing.assert_close(image[:, :3], place[1:], atol=1e-5, rtol=0.0)
    assert (image[:, 3:] * turn[1:]).sum().abs().item() == pytest.approx(1.0, abs=1e-5)
    fingers = robot.find_bodies(["panda_leftfinger", "panda_rightfinger"])[0]
    left, right = (robot.data.body_pos_w[:, i] - env.scene.env_origins for i in fingers)
    flip = torch.tensor([1.0, -1.0, 1.0])
    torch.testing.assert_close(left[0] * flip, right[1], atol=1e-5, rtol=0.0)
    torch.testing.assert_close(right[0] * flip, left[1], atol=1e-5, rtol=0.0)
    env.close()


@pytest.mark.parametrize(
    "cfg_type",
    [
        soft_cube_env_cfg.FrankaSoftCubeLiftEnvCfg,
        reach_joint_pos.FrankaReachEnvCfg,
        reach_ik_rel.FrankaReachEnvCfg,
        reach_ik_abs.FrankaReachEnvCfg,
        CartpoleEnvCfg,
    ],
    ids=["soft object", "reach", "reach, relative poses", "reach, absolute poses", "cart-pole"],
)
def test_the_declaration_of_a_shipped_task_passes_the_check(cfg_type):
    env = make(cfg_type())
    check_mirror(env, ["policy"])
    env.close()


def cartpole_runner(env_cfg, micro_batches=None, **symmetry) -> LiftLabRunner:
    cfg = CartpolePPORunnerCfg()
    cfg.algorithm.symmetry_cfg = RslRlSymmetryCfg(**{"use_data_augmentation": True, **symmetry})
    cfg.algorithm.micro_batches = micro_batches
    env_cfg.scene.num_envs = 16
    env_cfg.seed = 5
    torch.manual_seed(5)
    return LiftLabRunner(RslRlVecEnvWrapper(ManagerBasedRLEnv(env_cfg)), to_rsl_rl(cfg))


@pytest.mark.parametrize(
    "symmetry",
    [
        {},
        {"average_policy": True},
        {"average_policy": True, "use_data_augmentation": False, "use_mirror_loss": True, "mirror_loss_coeff": 1.0},
    ],
    ids=["mirrored samples", "symmetric policy, mirrored samples", "symmetric policy, mirror loss"],
)
def test_our_update_mirrors_a_task_as_rsl_rls_does(symmetry):
    weights = []
    for micro_batches in (False, None):
        runner = cartpole_runner(CartpoleEnvCfg(), micro_batches, **symmetry)
        runner.learn(1)
        weights.append(torch.cat([p.detach().flatten() for p in runner.alg.actor.parameters()]))
        runner.env.close()
    if "average_policy" in symmetry:  # an odd policy does not depend on its last bias, which Adam moves by rounding
        weights = [one[:-1] for one in weights]
    torch.testing.assert_close(weights[0], weights[1], atol=2e-5, rtol=1e-4)


def test_a_wrong_declaration_stops_a_training_before_it_starts():
    env_cfg = CartpoleEnvCfg()
    env_cfg.mirror.assets["robot"].signs["cart_to_pole"] = 1.0
    with pytest.raises(ConfigError, match=r"bodies' velocities: number 15 \(X of pole\) does not mirror as declared"):
        cartpole_runner(env_cfg)
