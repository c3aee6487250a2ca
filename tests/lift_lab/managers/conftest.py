"""A fake environment without physics: managers only ask for sizes, a device, a clock and a scene."""

from __future__ import annotations

from types import SimpleNamespace

import pytest
import torch

from lift_lab.utils.string import resolve_matching_names


class FakeArm:
    """An entity with the lookups of an articulation: three joints, two bodies."""

    joint_names = ("shoulder", "elbow", "finger")
    body_names = ("base", "hand")

    def find_joints(self, keys, preserve_order=False):
        return resolve_matching_names(keys, self.joint_names, preserve_order)

    def find_bodies(self, keys, preserve_order=False):
        return resolve_matching_names(keys, self.body_names, preserve_order)


class FakeBox:
    """An entity with the lookups of a rigid object: one body named after its prim."""

    body_names = ("Object",)

    def find_bodies(self, keys, preserve_order=False):
        return resolve_matching_names(keys, self.body_names, preserve_order)


def make_env(num_envs: int = 4, **attributes) -> SimpleNamespace:
    """A fake environment of 0.1 s steps and episodes of 5 s."""
    defaults = {
        "num_envs": num_envs,
        "device": "cpu",
        "step_dt": 0.1,
        "max_episode_length_s": 5.0,
        "max_episode_length": 50,
        "common_step_counter": 0,
        "sim": SimpleNamespace(is_started=True),
        "scene": {"robot": FakeArm(), "object": FakeBox(), "light": object()},
        "cfg": SimpleNamespace(),
        "calls": [],
        "prefetched": {},
        "physics_failed": None,
    }
    return SimpleNamespace(**(defaults | attributes))


@pytest.fixture
def env() -> SimpleNamespace:
    return make_env()


@pytest.fixture
def env_factory():
    return make_env


@pytest.fixture
def prefetch(env):
    """Answer what a manager will need to know, as an environment does that asks once a step."""

    def answer(manager, dt: float, ended: torch.Tensor) -> None:
        env.prefetched = {key: mask.nonzero().flatten() for key, mask in manager.masks(dt, ended).items()}

    return answer


@pytest.fixture(autouse=True)
def _seed():
    torch.manual_seed(0)
