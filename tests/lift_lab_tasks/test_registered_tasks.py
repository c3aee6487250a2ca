"""Every registered task beside the lift baseline runs: sizes as documented, and finite under random actions."""

import gymnasium as gym
import pytest
import torch

import lift_lab_tasks  # noqa: F401
from lift_lab.envs import ManagerBasedRLEnv
from lift_lab.envs.mdp import anneal_reward_weight, modify_reward_weight
from lift_lab_rl.rsl_rl import to_rsl_rl
from lift_lab_tasks.utils import load_cfg_from_registry, parse_env_cfg, registered_tasks
from lift_lab_tasks.utils.hydra import compose

SIZES = {  # observations, actions
    "Cartpole": (4, 1),
    "Reach-Franka": (32, 7),
    "Reach-Franka-IK-Rel": (31, 6),
    "Reach-Franka-IK-Abs": (32, 7),
    "Lift-Soft-Cube-Franka": (36, 8),
    "Lift-Cube-Franka-IK-Rel": (35, 7),
    "Lift-Cube-Franka-IK-Abs": (36, 8),
    "Open-Drawer-Franka": (31, 8),
}


def _make(task: str, num_envs: int):
    cfg = parse_env_cfg(task, device="cpu", num_envs=num_envs)
    cfg.sim.num_threads = 1
    cfg.seed = 7
    return gym.make(task, cfg=cfg).unwrapped


@pytest.mark.parametrize("task", SIZES)
def test_fifty_random_steps_are_finite_and_of_the_documented_sizes(task):
    env = _make(task, 4)
    num_obs, num_actions = SIZES[task]
    obs, _ = env.reset()
    assert obs["policy"].shape == (4, num_obs)
    assert env.action_manager.total_action_dim == num_actions
    for _ in range(50):
        obs, reward, terminated, _, _ = env.step(2.0 * torch.rand(4, num_actions) - 1.0)
        assert torch.isfinite(obs["policy"]).all()
        assert torch.isfinite(reward).all()
        assert terminated.dtype == torch.bool
    assert not any(env._failure_counts.values())
    env.close()


@pytest.mark.parametrize("task", ["Reach-Franka-IK-Abs", "Lift-Cube-Franka-IK-Abs"])
def test_an_absolute_action_of_all_zeros_has_no_direction_and_does_no_harm(task):
    env = _make(task, 2)
    env.reset()
    for _ in range(5):
        obs, *_ = env.step(torch.zeros(2, env.action_manager.total_action_dim))
    assert torch.isfinite(obs["policy"]).all()
    env.close()


def test_training_with_absolute_poses_begins_about_the_pose_at_a_reset():
    task = "Lift-Cube-Franka-IK-Abs"
    mean = torch.tensor(load_cfg_from_registry(task, "rsl_rl_cfg_entry_point").policy.init_action_mean)
    env = _make(task, 1)
    env.reset()
    tool = env.scene["ee_frame"].data
    torch.testing.assert_close(mean[:3], tool.target_pos_source[0, 0], atol=0.01, rtol=0.0)
    assert (mean[3:7] / mean[3:7].norm() * tool.target_quat_source[0, 0]).sum().abs() > 0.999
    env.close()


@pytest.mark.parametrize("task", SIZES)
def test_a_play_task_is_the_same_with_few_environments_and_no_noise(task):
    cfg, play = parse_env_cfg(task, device="cpu"), load_cfg_from_registry(f"{task}-Play", "env_cfg_entry_point")
    assert play.scene.num_envs == 50
    assert play.observations.policy.enable_corruption is False
    for part in ("rewards", "actions", "terminations", "commands", "events", "curriculum"):
        ours, theirs = getattr(play, part), getattr(cfg, part)
        assert (ours is None) == (theirs is None)
        assert ours is None or ours.to_dict() == theirs.to_dict()


def test_every_task_has_an_agent_of_its_own_kind_and_says_what_success_is():
    folders = {}
    ours = [
        name
        for name in registered_tasks()
        if str(gym.spec(name).kwargs["env_cfg_entry_point"]).startswith("lift_lab_tasks")
    ]
    for task in ours:
        agent = to_rsl_rl(load_cfg_from_registry(task, "rsl_rl_cfg_entry_point"))
        assert agent["max_iterations"] > 0
        assert gym.spec(task).kwargs["success"]
        folders.setdefault(agent["experiment_name"], set()).add(task.removesuffix("-Play").removesuffix("-CL"))
    # runs of tasks whose actions differ never share a folder, or one would load the other's policy
    assert all(len(tasks) == 1 for tasks in folders.values()), folders


def test_a_cart_in_the_open_ends_an_episode_and_only_its_own():
    env = _make("Cartpole", 3)
    env.reset()
    robot = env.scene["robot"]
    slider = robot.joint_names.index("slider_to_cart")
    position, velocity = robot.data.joint_pos.clone(), torch.zeros(3, 2)
    position[:] = 0.0
    position[1, slider] = 3.1
    robot.write_joint_state_to_sim(position, velocity)
    _, _, terminated, truncated, _ = env.step(torch.zeros(3, 1))
    assert terminated.tolist() == [False, True, False]
    assert not truncated.any()
    assert env.episode_length_buf.tolist() == [1, 0, 1]
    env.close()


@pytest.mark.parametrize("task", ["Lift-Cube-Franka", "Lift-Cube-Franka-CL", "Lift-Cube-Franka-IK-Rel"])
def test_curriculum_presets_swap_the_whole_curriculum_of_a_lift_task(task):
    step, _ = compose(task, None, ["env/curriculum=step"])
    linear, _ = compose(task, None, ["env/curriculum=linear", "env.curriculum.joint_vel.params.num_steps=5"])
    none, _ = compose(task, None, ["env/curriculum=none"])
    assert step.curriculum.action_rate.func is modify_reward_weight
    assert linear.curriculum.action_rate.func is anneal_reward_weight
    assert linear.curriculum.action_rate.params["num_steps"] == 10000
    assert linear.curriculum.joint_vel.params["num_steps"] == 5
    assert none.curriculum is None
    # a linear curriculum ends where the step ends
    for term in ("action_rate", "joint_vel"):
        ends = getattr(linear.curriculum, term).params["final_weight"], getattr(step.curriculum, term).params["weight"]
        assert ends[0] == ends[1] == -0.1


@pytest.mark.parametrize("task", ["Lift-Cube-Franka", "Lift-Cube-Franka-CL-Play"])
def test_reward_presets_swap_the_whole_reward_of_a_lift_task(task):
    plain, _ = compose(task, None)
    gated, _ = compose(task, None, ["env/rewards=gated"])
    ungated, _ = compose(task, None, ["env/rewards=ungated", "env.rewards.lifting_object.weight=20"])
    assert gated.rewards.to_dict() == plain.rewards.to_dict()
    assert ungated.rewards.object_goal_tracking.params["minimal_height"] is None
    assert ungated.rewards.lifting_object.weight == 20.0
    assert gated.rewards.object_goal_tracking.params["minimal_height"] == 0.04


def test_the_event_preset_gives_every_environment_a_cube_of_its_own():
    plain, _ = compose("Lift-Cube-Franka", None)
    assert compose("Lift-Cube-Franka", None, ["env/events=plain"])[0].events.to_dict() == plain.events.to_dict()
    cfg, _ = compose("Lift-Cube-Franka", None, ["env/events=randomized"])
    cfg.scene.num_envs, cfg.seed, cfg.sim.device = 64, 5, "cpu"
    env = ManagerBasedRLEnv(cfg)
    model, mass = env.sim.model, env.sim.physics.randomizable("body_mass").cpu()
    friction = env.sim.physics.randomizable("geom_friction")[..., 0].cpu()
    cube = model.body("object/Object").id
    assert 0.1 <= mass[:, cube].min() < 0.13  # from half of 0.2 kg
    assert 0.33 < mass[:, cube].max() <= 0.4  # to twice as much
    varied = {model.body(model.geom_bodyid[g]).name for g in (friction.std(0) > 0).nonzero().flatten().tolist()}
    assert varied == {"object/Object"}
    pads = [model.geom(f"robot/panda_{side}finger_pad").id for side in ("left", "right")]
    # a contact takes the larger coefficient of its two: the cube's
    grip = torch.maximum(friction[:, model.body("object/Object").geomadr[0], None], friction[:, pads])
    assert 0.5 <= grip.min() < 0.55
    assert 1.45 < grip.max() <= 1.5
    assert 0.9 < grip.mean() < 1.1
    assert (mass.std(0) > 0).sum() == 1
    env.close()


def test_the_event_preset_gives_every_environment_a_soft_cube_of_its_own():
    cfg, _ = compose("Lift-Soft-Cube-Franka", None, ["env/events=randomized"])
    cfg.scene.num_envs, cfg.seed, cfg.sim.device = 16, 5, "cpu"
    env = ManagerBasedRLEnv(cfg)
    env.reset()
    cube = env.scene["object"]
    masses, friction = cube.get_masses(), env.sim.physics.randomizable("flex_friction")[:, 0, 0]
    for drawn, low, high in ((masses, 0.05, 0.2), (friction, 0.5, 1.5)):
        assert low <= drawn.min() < drawn.mean() < drawn.max() <= high
    offset = cube.data.root_pos_w - env.scene.env_origins - torch.tensor([0.5, 0.0, 0.02])
    assert 0.05 < offset[:, 0].abs().max() <= 0.1
    assert 0.12 < offset[:, 1].abs().max() <= 0.25
    env.close()


@pytest.mark.slow
def test_the_cartpole_learns_to_balance():
    from lift_lab_rl.rsl_rl import LiftLabRunner, RslRlVecEnvWrapper

    env_cfg, agent_cfg = compose("Cartpole", "rsl_rl_cfg_entry_point", ["env.scene.num_envs=256", "env.sim.device=cpu"])
    env_cfg.sim.num_threads = 1
    env_cfg.seed = agent_cfg.seed
    wrapped = RslRlVecEnvWrapper(gym.make("Cartpole", cfg=env_cfg))
    runner = LiftLabRunner(wrapped, to_rsl_rl(agent_cfg), None, "cpu")
    runner.learn(100, init_at_random_ep_len=True)
    policy = runner.get_inference_policy()
    env = wrapped.unwrapped
    obs, _ = wrapped.reset()
    fell = torch.zeros(256, dtype=torch.bool)
    with torch.inference_mode():
        for _ in range(env.max_episode_length - 1):
            obs, *_ = wrapped.step(policy(obs))
            fell |= env.reset_terminated
    pole = env.scene["robot"].data.joint_pos[:, env.scene["robot"].joint_names.index("cart_to_pole")]
    balanced = ~fell & (pole.abs() < 0.2)
    wrapped.close()
    assert balanced.float().mean() > 0.95
