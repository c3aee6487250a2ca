"""An environment that is written down and read back goes on, bit by bit, as if nothing had happened."""

import numpy as np
import pytest
import torch

import lift_lab.envs.mdp as mdp
from lift_lab.envs import ManagerBasedRLEnv
from lift_lab.managers import CurriculumTermCfg, EventTermCfg, ManagerTermBase, RewardTermCfg, SceneEntityCfg
from lift_lab.utils.errors import StateMismatchError
from lift_lab.utils.noise import UniformNoiseCfg
from lift_lab_rl.files import load_torch, save_torch
from lift_lab_rl.random_state import load_rng_state, rng_state
from lift_lab_tasks.utils import parse_env_cfg


class Habit(ManagerTermBase):
    """A reward that depends on what it saw before and on random numbers of its own."""

    def __init__(self, cfg, env):
        super().__init__(cfg, env)
        self.memory = torch.zeros(env.num_envs)
        self.calls = 0
        self.generator = torch.Generator().manual_seed(3)

    def __call__(self, env):
        self.calls += 1
        self.memory = 0.9 * self.memory + torch.rand(env.num_envs, generator=self.generator)
        return self.memory * (self.calls % 3)


def make(num_envs=4, seed=1):
    """A lift environment with everything that carries state from step to step."""
    cfg = parse_env_cfg("Lift-Cube-Franka-CL", "cpu", num_envs)
    cfg.seed = seed
    cfg.sim.num_threads = 1
    cfg.episode_length_s = 0.3
    cfg.rewards.habit = RewardTermCfg(func=Habit, weight=1.0)
    cfg.observations.policy.history_length = 3
    cfg.observations.policy.joint_pos.noise = UniformNoiseCfg(n_min=-0.01, n_max=0.01)
    cfg.commands.object_pose.resampling_time_range = (0.1, 0.2)
    cfg.curriculum.joint_vel.params["num_steps"] = 10
    cfg.events.mass = EventTermCfg(
        func=mdp.randomize_rigid_body_mass,
        mode="reset",
        params={
            "asset_cfg": SceneEntityCfg("object"),
            "mass_distribution_params": (0.5, 2.0),
            "operation": "scale",
        },
    )
    cfg.events.push = EventTermCfg(
        func=mdp.push_by_setting_velocity,
        mode="interval",
        interval_range_s=(0.05, 0.2),
        params={"velocity_range": {"x": (-0.5, 0.5)}, "asset_cfg": SceneEntityCfg("object")},
    )
    return ManagerBasedRLEnv(cfg)


def run(env, steps, seed=0):
    """Everything that a learner sees in some steps of random actions, and the metrics of episodes that end."""
    generator = torch.Generator().manual_seed(seed)
    seen = []
    for _ in range(steps):
        actions = torch.randn(env.num_envs, env.action_manager.total_action_dim, generator=generator)
        obs, rewards, terminated, truncated, extras = env.step(actions)
        seen += [obs["policy"].clone(), rewards.clone(), terminated.clone(), truncated.clone()]
        if (terminated | truncated).any():
            seen.append(torch.tensor([float(v) for name, v in extras["log"].items() if name.startswith("Metrics/")]))
    return seen


@pytest.fixture
def env():
    env = make()
    yield env
    env.close()


def test_an_environment_goes_on_as_if_it_had_not_stopped(env, tmp_path):
    env.reset()
    run(env, 25)
    save_torch(tmp_path / "state.pt", {"env": env.state_dict(), "rng": rng_state()})
    expected = run(env, 25, seed=1)
    expected_weight = env.reward_manager.get_term_cfg("joint_vel").weight
    env.close()

    other = make(seed=77)
    other.reset()
    run(other, 3)
    state = load_torch(tmp_path / "state.pt")
    other.load_state_dict(state["env"])
    load_rng_state(state["rng"])
    found = run(other, 25, seed=1)
    assert other.reward_manager.get_term_cfg("joint_vel").weight == expected_weight == -0.1
    assert other.common_step_counter == 50
    other.close()
    assert all(torch.equal(a, b) for a, b in zip(expected, found, strict=True))
    assert any(values.dim() == 1 and len(values) >= 9 for values in found)  # seven of the task, two of the physics


def test_writing_a_state_down_changes_nothing(env):
    env.reset()
    run(env, 5)
    state, rng = env.state_dict(), rng_state()
    first = run(env, 10, seed=1)
    env.load_state_dict(state)
    load_rng_state(rng)
    second = run(env, 10, seed=1)
    assert all(torch.equal(a, b) for a, b in zip(first, second, strict=True))


def test_the_state_is_made_of_buffers_and_counters_not_of_settings(env):
    env.reset()
    run(env, 3)
    state = env.state_dict()

    def entries(node):
        if not isinstance(node, (tuple, list, dict)):
            return 1
        return sum(entries(item) for item in (node.values() if isinstance(node, dict) else node))

    assert entries(state["objects"]) < 600  # kinds, names and keys among them
    assert state["settings"] == {}
    assert state["unsaved"] == []
    assert not any("cfg" in name for node in state["objects"].values() for name in node[3])


def test_a_term_refers_to_the_assets_that_it_holds(env):
    env.reset()
    term, robot = env.command_manager.get_term("object_pose"), env.scene["robot"]
    state = term.state_dict()
    assert ("same", "scene/robot") in state.values()
    time_left, target = term.time_left.clone(), robot.data.joint_pos_target.clone()
    run(env, 2)
    assert not torch.equal(robot.data.joint_pos_target, target)
    moved = robot.data.joint_pos_target.clone()
    term.load_state_dict(state)
    assert torch.equal(term.time_left, time_left)
    assert term.robot is robot
    assert torch.equal(robot.data.joint_pos_target, moved)


@pytest.mark.parametrize("shown_first", [True, False])
def test_a_run_with_markers_goes_on_without_and_the_other_way_round(env, shown_first):
    def show(shown):
        for term in (shown.scene["ee_frame"], shown.command_manager.get_term("object_pose")):
            assert term.set_debug_vis(True)
            term.update_debug_vis()

    other = make(seed=77)
    show(env if shown_first else other)
    for each in (env, other):
        each.reset()
    run(env, 5)
    state, rng = env.state_dict(), rng_state()
    expected = run(env, 10, seed=1)
    other.load_state_dict(state)
    load_rng_state(rng)
    found = run(other, 10, seed=1)
    other.close()
    assert all(torch.equal(a, b) for a, b in zip(expected, found, strict=True))


def test_a_state_of_another_environment_is_refused(env):
    env.reset()
    state = env.state_dict()
    with pytest.raises(StateMismatchError, match="2 environments, this run 4"):
        env.load_state_dict(state | {"num_envs": 2})
    live = state["physics"]["state"] | {"state": torch.zeros(4, 5).double()}
    with pytest.raises(StateMismatchError, match=r"'physics\.state' has shape \(4, 5\), here it is \(4, \d+\)"):
        env.load_state_dict(state | {"physics": state["physics"] | {"state": live}})
    del state["objects"]["env"][3]["common_step_counter"]
    with pytest.raises(StateMismatchError, match=r"'env\.common_step_counter' is not in it"):
        env.load_state_dict(state)


class Seen(ManagerTermBase):
    """A reward that counts what it has in a set, and has an entry in a tuple that changes."""

    def __init__(self, cfg, env):
        super().__init__(cfg, env)
        self.seen, self.pair = set(), (torch.zeros(env.num_envs), 1.0)

    def __call__(self, env):
        self.seen.add(len(self.seen) // 2)
        self.pair = (self.pair[0], self.pair[1] * 1.1)
        return self.pair[0] + len(self.seen) * self.pair[1]


def cartpole():
    """A cart-pole whose curriculum widens a range, a tuple, whenever an episode ends."""
    cfg = parse_env_cfg("Cartpole", "cpu", 3)
    cfg.seed, cfg.sim.num_threads, cfg.episode_length_s = 3, 1, 0.2
    cfg.rewards.seen = RewardTermCfg(func=Seen, weight=1.0)
    params = {
        "address": "events.reset_cart_position.params['position_range']",
        "modify_fn": lambda env, ids, old: (old[0] * 1.05, old[1] * 1.05),
    }
    cfg.curriculum = {"wider": CurriculumTermCfg(func=mdp.modify_term_cfg, params=params)}
    return ManagerBasedRLEnv(cfg)


def test_numbers_in_tuples_and_sets_go_on_too(tmp_path):
    env, other = cartpole(), cartpole()
    for one in (env, other):
        one.reset()
    run(env, 30)
    save_torch(tmp_path / "state.pt", {"env": env.state_dict(), "rng": rng_state()})
    expected = run(env, 30)
    state = load_torch(tmp_path / "state.pt")
    other.load_state_dict(state["env"])
    load_rng_state(state["rng"])
    found = run(other, 30)
    for one in (env, other):
        one.close()
    assert all(torch.equal(a, b) for a, b in zip(expected, found, strict=True))


def test_an_array_that_cannot_be_written_to_is_named():
    env = cartpole()
    env.reset()
    env.table = np.arange(3.0)
    state = env.state_dict()
    env.table = np.zeros(3)
    env.table.flags.writeable = False
    with pytest.raises(StateMismatchError, match=r"'env\.table' is an array that cannot be written to"):
        env.load_state_dict(state)
    env.close()


def test_random_numbers_go_on_where_they_were():
    import random

    state = rng_state()
    first = (torch.rand(3), np.random.rand(3), [random.random() for _ in range(3)])  # noqa: NPY002
    load_rng_state(state)
    assert torch.equal(first[0], torch.rand(3))
    assert (first[1] == np.random.rand(3)).all()  # noqa: NPY002
    assert first[2] == [random.random() for _ in range(3)]
