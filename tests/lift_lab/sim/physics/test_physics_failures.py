"""A failed environment is reported, disturbs no other, and is whole again after a reset."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

import mujoco
import pytest
import torch

from lift_lab.sim.physics import Physics, make_physics

FAILED = 2
OTHERS = [0, 1, 3]
FIELDS = ("qpos", "qvel", "xpos", "qacc", "sensordata")


def run(physics: Physics, steps: int) -> list[torch.Tensor]:
    for _ in range(steps):
        physics.step(2)
    return [physics.field(name).clone() for name in FIELDS]


def start(physics: Physics) -> None:
    for name in FIELDS:
        physics.field(name)
    physics.reset()
    physics.write("qpos", 0.05, cols=[2])
    physics.write("qvel", 1.0, cols=[0])
    physics.write("ctrl", 0.03)
    physics.refresh()
    physics.health()


@pytest.mark.parametrize(
    ("field", "column", "value"),
    [("qpos", 0, float("nan")), ("qvel", 3, 1e12), ("qvel", 8, float("inf")), ("ctrl", 1, float("nan"))],
)
def test_a_failure_is_reported_and_stays_where_it_is(
    physics: Physics, field: str, column: int, value: float, tmp_path: Path, monkeypatch, capfd
):
    monkeypatch.chdir(tmp_path)
    start(physics)
    untroubled = run(physics, 15)
    assert not physics.health().failed.any()

    start(physics)
    run(physics, 5)
    physics.write(field, value, env_ids=[FAILED], cols=[column])
    troubled = run(physics, 10)
    for name, a, b in zip(FIELDS, untroubled, troubled, strict=True):
        assert torch.equal(a[OTHERS], b[OTHERS]), name
    health = physics.health()
    assert health.nonfinite.tolist() == [False, False, True, False]
    assert not health.overflow.any()

    physics.reset([FAILED])
    physics.refresh()
    physics.step(3)
    assert not physics.health().failed.any()
    assert all(physics.field(name).isfinite().all() for name in FIELDS)
    assert os.listdir(tmp_path) == []
    printed = capfd.readouterr()
    assert "WARNING" not in printed.out + printed.err


def test_a_failure_that_was_reset_before_anyone_asked_is_still_reported(physics: Physics):
    physics.write("qvel", float("nan"), env_ids=[1])
    physics.step(1)
    physics.reset([1])
    physics.refresh()
    assert physics.health().nonfinite.tolist() == [False, True, False, False]
    assert not physics.health().failed.any()


def test_a_reset_environment_forgets_its_past(physics: Physics):
    start(physics)
    fresh = run(physics, 20)
    start(physics)
    run(physics, 7)
    physics.reset([1, 3])
    for env in (1, 3):
        physics.write("qpos", 0.05, env_ids=[env], cols=[2])
        physics.write("qvel", 1.0, env_ids=[env], cols=[0])
        physics.write("ctrl", 0.03, env_ids=[env])
    physics.refresh([1, 3])
    again = run(physics, 20)
    for name, a, b in zip(FIELDS, fresh, again, strict=True):
        assert torch.equal(a[[1, 3]], b[[1, 3]]), name
        assert name == "sensordata" or not torch.equal(a[0], b[0]), name


def test_nothing_depends_on_the_number_of_threads(make: Callable[..., Physics]):
    results = []
    for num_threads in (1, 2):
        physics = make("native-cpu", num_envs=7, num_threads=num_threads)
        assert physics.num_threads == num_threads
        start(physics)
        physics.write("qvel", torch.linspace(-1, 1, 7).view(-1, 1), cols=[1])
        results.append([*run(physics, 30), torch.tensor(physics.get_data(5).qpos)])
    assert all(torch.equal(a, b) for a, b in zip(*results, strict=True))


def test_native_steps_bit_for_bit_as_a_plain_loop(make: Callable[..., Physics], model: mujoco.MjModel):
    physics = make("native-cpu", num_threads=2)
    start(physics)
    physics.write("qvel", 0.7, env_ids=[3], cols=[1])
    data = mujoco.MjData(model)
    data.qpos[2], data.qvel[0], data.qvel[1], data.ctrl[:] = 0.05, 1.0, 0.7, 0.03
    for _ in range(15):
        physics.step(4)
        for _ in range(4):
            mujoco.mj_step(model, data)
    out = physics.get_data(3)
    assert (out.qpos == data.qpos).all()
    assert (out.qvel == data.qvel).all()
    assert out.time == data.time


PILE = """
<mujoco>
  <size memory="{memory}"/>
  <worldbody>
    <geom type="plane" size="9 9 1"/>
    {boxes}
  </worldbody>
</mujoco>
"""


def test_memory_that_runs_out_is_an_overflow_of_that_environment():
    count = 40
    boxes = "".join(f'<body pos="{i} 0 9"><freejoint/><geom type="box" size=".1 .1 .1"/></body>' for i in range(count))
    model = mujoco.MjModel.from_xml_string(PILE.format(memory="300K", boxes=boxes))
    physics = make_physics(model, 3, kind="native", num_threads=1)
    piled = torch.zeros(count, 7)
    piled[:, 2], piled[:, 3] = torch.linspace(0.1, 0.3, count), 1.0
    physics.write("qpos", piled.flatten(), env_ids=[1])
    physics.step(2)
    health = physics.health()
    assert health.overflow.tolist() == [False, True, False]
    assert physics.field("time").tolist() == pytest.approx([0.004, 0.0, 0.004])
    resets = make_physics(model, 3, kind="native", num_threads=1, auto_reset_failed=True)
    resets.write("qpos", piled.flatten(), env_ids=[1])
    for _ in range(3):
        resets.step(1)
    assert resets.field("time").tolist() == pytest.approx([0.006, 0.004, 0.006])  # of the step that was not taken
    assert resets.health().overflow.tolist() == [False, True, False]
    physics.reset([1])
    physics.step(2)
    assert not physics.health().failed.any()


def test_constraint_rows_that_run_out_are_an_overflow_of_that_environment(make: Callable[..., Physics]):
    physics = make("warp-cpu", njmax=16)
    physics.write("qpos", 3.0, cols=[2])
    physics.write("qpos", 0.029, env_ids=[1], cols=[2])  # four contacts of six rows
    physics.step(1)
    assert physics.health().overflow.tolist() == [False, True, False, False]
    physics.reset()
    physics.write("qpos", 3.0, cols=[2])
    physics.step(1)
    assert not physics.health().failed.any()


def test_contacts_that_run_out_are_an_overflow_of_all(make: Callable[..., Physics]):
    physics = make("warp-cpu", nconmax=1)
    physics.write("qpos", 0.029, cols=[2])
    physics.step(1)
    assert physics.health().overflow.all()


def test_an_environment_is_whole_after_the_step_in_which_it_failed(engine: str, make: Callable[..., Physics]):
    fields = ("qpos", "qvel", "xpos", "qacc")
    for physics in (resets := make(engine, auto_reset_failed=True), plain := make(engine)):
        for name in fields:
            physics.field(name)
        physics.reset()
        physics.write("qpos", 0.05, cols=[2])
        physics.refresh()
        physics.health()
        physics.step(2)
        physics.write("qvel", float("nan"), env_ids=[2], cols=[0])
        physics.step(2)
    for name in fields:
        assert resets.field(name).isfinite().all(), name
        others = [0, 1, 3]
        assert torch.equal(resets.field(name)[others], plain.field(name)[others]), name
    assert not resets.field("qacc")[2].any()
    assert resets.field("qpos")[2].tolist() == pytest.approx(resets.model.qpos0.tolist())
    assert resets.health().nonfinite.tolist() == plain.health().nonfinite.tolist() == [False, False, True, False]
    assert not resets.health().failed.any()
    assert plain.health().failed.tolist() == [False, False, True, False]  # still in its bad state


def test_an_environment_is_reset_once_for_a_failure_that_nobody_asked_about(engine: str, make: Callable[..., Physics]):
    physics = make(engine, auto_reset_failed=True)
    physics.write("qvel", float("nan"), env_ids=[1], cols=[0])
    physics.step(1)
    assert physics.field("qpos")[1, 2] == pytest.approx(physics.model.qpos0[2])
    physics.step(1)
    physics.step(1)
    assert physics.field("time").tolist() == pytest.approx([0.015, 0.01, 0.015, 0.015])
    assert physics.health().nonfinite.tolist() == [False, True, False, False]


def test_an_overflow_is_reset_once(make: Callable[..., Physics]):
    physics = make("warp-cpu", njmax=16, auto_reset_failed=True)
    physics.write("qpos", 3.0, cols=[2])
    physics.write("qpos", 0.029, env_ids=[1], cols=[2])  # four contacts of six rows
    physics.step(1)
    assert physics.field("qpos")[1, 2] == pytest.approx(physics.model.qpos0[2])
    physics.step(1)
    physics.step(1)
    assert physics.field("time").tolist() == pytest.approx([0.015, 0.01, 0.015, 0.015])
    assert physics.health().overflow.tolist() == [False, True, False, False]
