"""A step of the lift task asks the device one question: which episodes ended, and which commands are due.

On a GPU every question makes the host wait. The operators behind others are the same on the CPU, where they are
counted here, on the engine that the GPU uses.
"""

from collections import Counter

import gymnasium as gym
import pytest
import torch
from torch.utils._python_dispatch import TorchDispatchMode

import lift_lab_tasks  # noqa: F401
from lift_lab.envs import manager_based_rl_env
from lift_lab.utils import indexing
from lift_lab_tasks.utils.hydra import compose

BY_MASK = "indexing by a mask"
QUESTIONS = ("_local_scalar_dense", "nonzero", "equal", "is_nonzero", "masked_select", "unique", "_unique2", BY_MASK)
"""Operators whose result the host needs before it can go on."""


class Counting(TorchDispatchMode):
    """Counts operators by name; indexing by a bool tensor, whose result has a size that depends on it, apart."""

    def __init__(self):
        super().__init__()
        self.calls = Counter()

    def __torch_dispatch__(self, func, types, args=(), kwargs=None):
        name = func.__name__.partition(".")[0]
        by_mask = name in ("index", "index_put", "index_put_", "_index_put_impl_") and any(
            index is not None and index.dtype == torch.bool for index in args[1]
        )
        self.calls[BY_MASK if by_mask else name] += 1
        return func(*args, **(kwargs or {}))


@pytest.fixture(scope="module")
def env():
    pytest.importorskip("mujoco_warp")
    cfg, _ = compose("Lift-Cube-Franka-CL", None, [])
    cfg.scene.num_envs, cfg.sim.device, cfg.sim.physics = 4, "cpu", "warp"
    made = gym.make("Lift-Cube-Franka-CL", cfg=cfg)
    made.reset()
    yield made
    made.close()


def calls(env, steps=2):
    actions = torch.zeros(4, env.unwrapped.action_manager.total_action_dim)
    with torch.inference_mode():
        env.step(actions)
        with Counting() as counting:
            for _ in range(steps):
                env.step(actions)
    return counting.calls


@pytest.fixture
def answers(monkeypatch):
    """What the question was answered with, a list of lists of ids for each step."""
    given = []

    def ask(masks):
        given.append([ids.tolist() for ids in indexing.where_true(masks)])
        return [torch.tensor(ids, dtype=torch.long) for ids in given[-1]]

    monkeypatch.setattr(manager_based_rl_env, "where_true", ask)
    return given


def test_a_step_in_which_no_episode_ends_asks_once_which_ended_and_which_commands_are_due(env, answers):
    env.unwrapped.episode_length_buf[:] = 0
    found = calls(env)
    assert {name: found[name] for name in QUESTIONS if found[name]} == {}
    assert answers == [[[], [], [], []]] * 3  # ended, due commands, episodes that count, of those with success


def test_a_command_that_is_due_is_drawn_in_that_step_and_one_of_an_ended_episode_once(env, answers):
    inner = env.unwrapped
    term = inner.command_manager.get_term("object_pose")
    inner.episode_length_buf[:] = 0
    inner.episode_length_buf[3] = inner.max_episode_length
    term.time_left[:] = torch.tensor([1.0, inner.step_dt, 1.5 * inner.step_dt, inner.step_dt])
    drawn = term.command_counter.clone()
    before = term.command.clone()
    with torch.inference_mode():
        env.step(torch.zeros(4, inner.action_manager.total_action_dim))
    assert answers == [[[3], [1], [3], []]]
    assert (term.command_counter - drawn)[:3].tolist() == [0, 1, 0]
    assert int(term.command_counter[3]) == 1
    assert (term.command != before).any(dim=1).tolist() == [False, True, False, True]
    longest_s = term.cfg.resampling_time_range[1]
    assert term.time_left[[1, 3]].tolist() == pytest.approx([longest_s, longest_s - inner.step_dt])


@pytest.mark.parametrize("share", [0.0, 0.5])
def test_a_step_in_which_episodes_end_asks_no_more_where_some_practise_missed_goals(env, answers, share):
    inner = env.unwrapped
    inner.curriculum_manager.get_term_cfg("missed_goals").params.update(share=share, start_step=0)
    inner.common_step_counter = 100
    inner.episode_length_buf[:] = 0
    with torch.inference_mode():
        env.step(torch.zeros(4, inner.action_manager.total_action_dim))  # the share is read when episodes end
        inner.curriculum_manager.compute(torch.tensor([0]))
        inner.episode_length_buf[:] = torch.tensor([0, 1, 1, 1]) * inner.max_episode_length
        metrics = inner.metrics_manager
        metrics.leave_out(torch.arange(4), torch.tensor([False, False, False, share > 0.0]))
        metrics.episode_value("success")[:] = torch.tensor([1.0, 0.0, 1.0, 1.0])
        metrics.episode_value("time_to_success_s")[:] = 0.02 * torch.tensor([5.0, torch.nan, 7.0, 8.0])
        with Counting() as counting:
            *_, extras = env.step(torch.zeros(4, inner.action_manager.total_action_dim))
    counting.calls.pop("is_nonzero")  # on the CPU alone a reset asks whether an object turns
    assert {name: counting.calls[name] for name in QUESTIONS if counting.calls[name]} == {}
    counted, succeeded = ([1, 2], [2]) if share else ([1, 2, 3], [2, 3])
    assert answers[-1] == [[1, 2, 3], [], counted, succeeded]
    log = extras["log"]
    assert float(log["Metrics/success_rate"]) == pytest.approx(len(succeeded) / len(counted))
    assert float(log["Metrics/object_pose/time_to_success_s"]) == pytest.approx(0.02 * (7 if share else 7.5))
    counts = [extras["log_counts"][f"Metrics/{name}"] for name in ("success_rate", "object_pose/time_to_success_s")]
    assert counts == [len(counted), len(succeeded)]


def test_what_the_last_step_was_like_is_measured_before_the_question(env, monkeypatch):
    """So that the host does it while a GPU still computes the physics."""
    inner, at_the_question = env.unwrapped, Counter()

    def ask(masks):
        at_the_question.update(counting.calls)
        return indexing.where_true(masks)

    monkeypatch.setattr(manager_based_rl_env, "where_true", ask)
    inner.episode_length_buf[:] = torch.tensor([0, 0, 1, 1]) * inner.max_episode_length
    with torch.inference_mode(), Counting() as counting:
        env.step(torch.zeros(4, inner.action_manager.total_action_dim))
    for name in ("reciprocal", "asin_", "linalg_vector_norm"):  # means, angle, distances
        assert counting.calls[name] == at_the_question[name] > 0


def test_a_success_on_the_last_step_counts_without_another_question(env, answers):
    inner = env.unwrapped
    term = inner.command_manager.get_term("object_pose")
    inner.episode_length_buf[:] = torch.tensor([0, 0, 1, 1]) * (inner.max_episode_length - 1)
    with torch.inference_mode():
        inner.metrics_manager.reset()
        inner.prefetched = {}
        at = inner.scene["object"].data.root_pos_w - inner.scene["robot"].data.root_pos_w
        term.pose_command_b[2, :3] = at[2]
        *_, extras = env.step(torch.zeros(4, inner.action_manager.total_action_dim))
    assert [2] in answers[-1]
    log = extras["log"]
    assert float(log["Metrics/success_rate"]) == 0.5
    assert float(log["Metrics/object_pose/time_to_success_s"]) == pytest.approx(inner.max_episode_length_s)


def test_the_last_observations_of_episodes_ask_nothing(env, answers, monkeypatch):
    inner = env.unwrapped
    monkeypatch.setattr(inner, "wants_final_obs", True)
    inner.episode_length_buf[:] = torch.tensor([0, 0, 1, 1]) * inner.max_episode_length
    with torch.inference_mode(), Counting() as counting:
        *_, extras = env.step(torch.zeros(4, inner.action_manager.total_action_dim))
    counting.calls.pop("is_nonzero")  # on the CPU alone a reset asks whether an object turns
    assert {name: counting.calls[name] for name in QUESTIONS if counting.calls[name]} == {}
    assert answers[0][0] == [2, 3]
    assert extras["final_obs"]["policy"].shape == (4, 36)


def test_a_failure_of_the_physics_ends_its_episode_and_reaches_no_other_number(env):
    inner = env.unwrapped
    inner.episode_length_buf[:] = 0
    actions = torch.zeros(4, inner.action_manager.total_action_dim)
    inner.sim.physics.write("qvel", float("nan"), env_ids=[1], cols=[0])
    with torch.inference_mode():
        obs, reward, terminated, _, extras = env.step(actions)
    assert terminated.tolist() == [False, True, False, False]
    assert reward.isfinite().all()
    assert reward[1] == 0.0
    assert obs["policy"].isfinite().all()
    assert float(extras["log"]["Metrics/physics/nonfinite"]) == 1.0
    assert all(torch.as_tensor(value).isfinite().all() for value in extras["log"].values())
