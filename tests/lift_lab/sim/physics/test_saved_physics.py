"""An engine goes on bit by bit from a saved state, in this engine or another of the same model."""

from __future__ import annotations

from collections.abc import Callable

import pytest
import torch

from lift_lab.sim.physics import Physics
from lift_lab.utils.errors import StateMismatchError

FIELDS = ("qpos", "qvel", "xpos", "cvel", "qacc", "sensordata", "site_xpos")


def walk(physics: Physics, steps: int, seed: int) -> list[torch.Tensor]:
    """What an engine shows in some steps with random controls and velocities."""
    generator, seen = torch.Generator().manual_seed(seed), []
    for k in range(steps):
        physics.write("ctrl", 0.05 * torch.rand(physics.num_envs, physics.model.nu, generator=generator))
        physics.write("qvel", torch.rand(1, generator=generator).item(), env_ids=[k % physics.num_envs], cols=[0])
        physics.step(2)
        if k == 2:
            physics.reset([1])
            physics.refresh([1])
        seen += [physics.field(name).clone() for name in FIELDS] + [physics.acceleration().clone(), physics.gravity]
        seen += [physics.health().failed]
    return seen


def start(make: Callable[..., Physics], engine: str, differ: bool) -> Physics:
    physics = make(engine)
    if differ:
        physics.randomizable("body_mass")[:, 1] = torch.tensor([1.0, 2.0, 3.0, 4.0])
        physics.randomizable("opt.gravity")[2] = torch.tensor([0.0, 1.0, -5.0])
        physics.randomizable("geom_friction")[1, 0, 0] = 0.9
    physics.acceleration()
    return physics


@pytest.mark.parametrize("differ", [False, True])
def test_an_engine_goes_on_from_a_saved_state(engine: str, make: Callable[..., Physics], differ: bool):
    physics = start(make, engine, differ)
    walk(physics, 5, seed=1)
    state = physics.state_dict()
    expected = walk(physics, 5, seed=2)
    walk(physics, 2, seed=3)
    others = [physics, make(engine), start(make, engine, True)]  # the same, a new one, one with another model
    walk(others[2], 3, seed=4)
    for other in others:
        other.load_state_dict(state)
        found = walk(other, 5, seed=2)
        assert all(torch.equal(a, b) for a, b in zip(expected, found, strict=True))


def test_a_failure_that_was_not_reported_is_reported_after_loading(engine: str, make: Callable[..., Physics]):
    physics, other = make(engine), make(engine)
    physics.write("qvel", float("nan"), env_ids=[2], cols=[0])
    physics.step()
    physics.reset([2])
    other.load_state_dict(physics.state_dict())
    assert other.health().nonfinite.tolist() == [False, False, True, False]
    assert not other.health().failed.any()


def test_writes_since_the_kinematics_are_noted_in_the_state(engine: str, make: Callable[..., Physics]):
    physics, other = make(engine), make(engine)
    physics.current("xpos")
    physics.write("qpos", 7.0, env_ids=[1], cols=[0])
    other.load_state_dict(physics.state_dict())
    assert other.current("xpos")[:, 1, 0].tolist() == [0.0, 7.0, 0.0, 0.0]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"engine": "other"}, "the saved state is of the engine 'other', this is '"),
        ({"version": 0}, "the saved state of the physics has version 0, this is 1"),
        ({"state": {}}, r"the saved state 'physics\.\w+' is no tensor"),
        ({"fields": {"nope": torch.zeros(1)}}, "the saved physics field 'nope' is not in this model"),
        ({"fields": {"xpos": torch.zeros(4, 1, 3)}}, r"'physics.xpos' has shape \(4, 1, 3\), here it is \(4, 9, 3\)"),
        ({"model": {"nope": torch.zeros(1)}}, "the saved model field 'physics.model.nope' is not in this model"),
        ({"model": {"body_mass": torch.zeros(4, 2)}}, r"'physics.model.body_mass' has shape \(4, 2\)"),
        ({"stale": torch.tensor([9])}, "'physics.stale' has to be numbers of environments"),
        ({"acceleration": torch.zeros(1)}, "'physics.acceleration' has shape"),
        ({"fields": 3}, "the saved state of the physics is not valid"),
    ],
)
def test_a_state_of_something_else_is_refused_and_changes_nothing(physics: Physics, change: dict, message: str):
    state = physics.state_dict()
    physics.step(3)
    before = physics.state_dict()
    with pytest.raises(StateMismatchError, match=message):
        physics.load_state_dict(state | change)
    after = physics.state_dict()
    assert all(torch.equal(after["state"][name], values) for name, values in before["state"].items())
