"""Frames on the CPU's own engine: the same numbers whether a batch of their own or the stepping batch computes them.

And what follows from them and from joint velocities: motion axes, inertias about centres of mass, body velocities.
"""

from __future__ import annotations

from collections.abc import Callable

import mujoco
import numpy as np
import pytest
import torch

from lift_lab.sim.physics import Physics
from lift_lab.sim.physics.data_fields import FRAME_FIELDS, MOTION_FIELDS

FRAMES = (*FRAME_FIELDS, *MOTION_FIELDS)
NUM_ENVS = 4


@pytest.fixture
def physics(make: Callable[..., Physics]) -> Physics:
    engine = make("native-cpu", num_threads=2)
    for name in FRAMES:
        engine.field(name)
    return engine


def assert_current(physics: Physics, names: tuple[str, ...] = FRAMES) -> None:
    """The fields are what MuJoCo computes for the engine's state and model, to the last bit."""
    for env in range(physics.num_envs):
        data = physics.get_data(env)
        for name in names:
            np.testing.assert_array_equal(physics.field(name)[env], getattr(data, name).astype(np.float32), name)


def test_frames_follow_steps_writes_and_resets(physics: Physics, model: mujoco.MjModel):
    marker = torch.tensor([[0.5, 0.25, 2.0]]).repeat(NUM_ENVS, 1)
    physics.write("ctrl", 0.02)  # squeeze the block
    physics.write("qvel", torch.randn(NUM_ENVS, model.nv, generator=torch.Generator().manual_seed(1)))
    for _ in range(20):
        physics.step(3)
        assert_current(physics)
    before = physics.field("xpos").clone()
    physics.write("mocap_pos", marker)
    physics.write("qpos", 1.5, [2], [7])
    assert torch.equal(physics.field("xpos"), before)
    physics.refresh([2])
    assert torch.equal(physics.field("xpos")[[0, 1, 3]], before[[0, 1, 3]])
    assert not torch.equal(physics.field("xpos")[2], before[2])
    physics.refresh()
    assert_current(physics)
    assert torch.equal(physics.field("xpos")[:, model.body("marker").id], marker)
    physics.reset([1])
    physics.refresh([1])
    assert_current(physics)


def test_a_field_that_needs_the_batch_changes_no_frame(make: Callable[..., Physics], physics: Physics):
    plain = make("native-cpu")
    plain.field("qfrc_bias")
    for name in FRAMES:
        plain.field(name)
    for step in range(40):
        if step == 20:
            physics.field("qfrc_bias")
        for engine in (plain, physics):
            engine.write("ctrl", 0.03 * (step % 3))
            engine.step(2)
        for name in ("qpos", "qvel", *FRAMES):
            assert torch.equal(physics.field(name), plain.field(name)), (step, name)
    assert torch.equal(physics.field("qfrc_bias"), plain.field("qfrc_bias"))


@pytest.mark.parametrize("when", ["before", "after"])
def test_frames_of_a_model_that_differs_between_environments(make: Callable[..., Physics], model, when: str):
    physics = make("native-cpu")
    if when == "after":
        for name in FRAMES:
            physics.field(name)
    offset_m = torch.linspace(0.0, 0.3, NUM_ENVS)
    physics.randomizable("body_pos")[:, model.body("palm").id, 0] += offset_m
    physics.randomizable("site_pos")[:, model.site("tip").id, 2] -= offset_m
    physics.step(2)
    assert_current(physics)
    palm_m = physics.field("xpos")[:, model.body("palm").id, 0]
    torch.testing.assert_close(palm_m, offset_m)


@pytest.mark.parametrize("bound", [FRAME_FIELDS, FRAMES], ids=["frames", "motion"])
@pytest.mark.parametrize("when", ["before", "after"])
def test_masses_that_differ_between_environments(make: Callable[..., Physics], model, when: str, bound):
    physics = make("native-cpu")
    if when == "after":
        for name in bound:
            physics.field(name)
    box = model.body("box").id
    physics.randomizable("body_mass")[:, box] *= torch.linspace(0.5, 2.0, NUM_ENVS).double()
    physics.recompute_constants()
    for name in bound:
        physics.field(name)
    physics.write("qvel", 0.5)
    physics.step(5)
    assert_current(physics, bound)
    if bound is FRAMES:
        mass_kg = physics.field("cinert")[:, box, 9]
        torch.testing.assert_close(mass_kg / mass_kg[0], torch.linspace(1.0, 4.0, NUM_ENVS))


def test_velocities_alone_are_refreshed_for_some_environments(make: Callable[..., Physics], model: mujoco.MjModel):
    physics = make("native-cpu")
    physics.field("cvel")
    before = physics.field("cvel").clone()
    physics.write("qvel", 2.0, [1])
    physics.refresh([1])
    assert_current(physics, ("cvel",))
    assert torch.equal(physics.field("cvel")[[0, 2, 3]], before[[0, 2, 3]])
    assert not torch.equal(physics.field("cvel")[1], before[1])


def test_frames_of_a_state_that_failed_do_not_spread(physics: Physics):
    physics.write("qpos", float("nan"), [1], [7])
    physics.step(2)
    physics.refresh()
    assert physics.health().nonfinite.tolist() == [False, True, False, False]
    assert physics.field("xpos")[[0, 2, 3]].isfinite().all()
    physics.reset([1])
    physics.refresh([1])
    assert_current(physics)
