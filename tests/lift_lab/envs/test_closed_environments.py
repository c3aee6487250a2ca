"""Closed environments give their memory back, without waiting for Python's collector of cycles."""

from __future__ import annotations

import gc
import os
import sys
import weakref
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
import torch
from env_parts import zero_action

from lift_lab.envs import ManagerBasedRLEnv
from lift_lab.utils.errors import PhysicsError

COUNT, NUM_ENVS = 12, 2000


@pytest.fixture
def no_collector() -> Iterator[None]:
    """Leave cycles alone: what is freed is freed by the library itself."""
    gc.collect()
    gc.disable()
    yield
    gc.enable()


@pytest.mark.parametrize("physics", ["native", "warp"])
def test_closing_frees_the_engine_though_the_environment_is_kept(make_env: Callable[..., ManagerBasedRLEnv], physics):
    env = make_env(physics=physics)
    env.reset()
    env.step(zero_action(env))
    engine = env.sim.physics
    joint_pos = env.scene["robot"].data.joint_pos.clone()
    kept = engine.field("qpos")
    memory = weakref.ref(engine._batch if physics == "native" else engine._d)
    env.close()
    env.close()
    assert memory() is None
    assert kept[:, :2].isfinite().all()  # a tensor that was handed out stays valid
    assert joint_pos.shape == (3, 2)
    for use in (engine.step, engine.refresh, lambda: engine.field("qvel"), lambda: engine.num_envs):
        with pytest.raises(PhysicsError, match="was closed"):
            use()


@pytest.mark.usefixtures("no_collector")
def test_a_new_environment_frees_the_closed_ones(make_cfg):
    freed = []
    for _ in range(3):
        env = ManagerBasedRLEnv(make_cfg(num_envs=256))
        env.reset()
        freed.append(weakref.ref(env))
        assert [ref() is None for ref in freed[:-1]] == [True] * (len(freed) - 1)
        env.close()
        del env


@pytest.mark.skipif(sys.platform != "linux", reason="reads /proc")
@pytest.mark.usefixtures("no_collector")
def test_many_environments_one_after_another_take_the_memory_of_one(make_cfg):
    def resident_mb() -> float:
        return int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE") / 1e6

    sizes = []
    for _ in range(COUNT):
        env = ManagerBasedRLEnv(make_cfg(num_envs=NUM_ENVS))
        env.reset()
        env.step(torch.zeros(NUM_ENVS, 2))
        env.close()
        del env
        sizes.append(resident_mb())
    assert sizes[-1] - sizes[2] < 20.0  # MB; each takes 10
