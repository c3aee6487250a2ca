"""A step of the lift task asks tensors only for two lists: the ended episodes, and the commands that are due.

On a GPU every such question makes the host wait. The operators behind them are the same on the CPU, where they are
counted here, on the engine that the GPU uses.
"""

from collections import Counter

import gymnasium as gym
import pytest
import torch
from torch.utils._python_dispatch import TorchDispatchMode

import lift_lab_tasks  # noqa: F401
from lift_lab_tasks.utils.hydra import compose

QUESTIONS = ("_local_scalar_dense", "nonzero", "equal", "is_nonzero", "masked_select", "unique", "_unique2")
"""Operators whose result the host needs before it can go on."""


class Counting(TorchDispatchMode):
    """Counts operators by name."""

    def __init__(self):
        super().__init__()
        self.calls = Counter()

    def __torch_dispatch__(self, func, types, args=(), kwargs=None):
        self.calls[func.__name__.partition(".")[0]] += 1
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


def test_a_step_in_which_no_episode_ends_asks_which_ended_and_which_commands_are_due(env):
    env.unwrapped.episode_length_buf[:] = 0
    found = calls(env)
    assert {name: found[name] for name in QUESTIONS if found[name]} == {"nonzero": 2 * 2}


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
