"""Motion against closed forms and between the engines; randomised masses and friction."""

from __future__ import annotations

from collections.abc import Callable

import mujoco
import numpy as np
import torch

from lift_lab.sim.physics import Physics

G = 9.81
DT = 0.005


def squeeze(physics: Physics) -> None:
    """Throw the box along the floor and close the fingers on the block."""
    physics.write("qpos", 0.05, cols=[2])
    physics.write("qvel", torch.tensor([1.0, 0.3]), cols=[0, 1])
    physics.write("ctrl", 0.03)


def test_a_ball_falls_as_gravity_says(physics: Physics, model: mujoco.MjModel):
    z = model.jnt_qposadr[model.body("ball").jntadr[0]] + 2
    steps = 40
    physics.step(steps)
    fallen = 3.0 - physics.field("qpos")[:, z].cpu()
    # the integrator's own sum: velocity first, then position
    np.testing.assert_allclose(fallen, G * DT**2 * steps * (steps + 1) / 2, rtol=1e-5)
    np.testing.assert_allclose(fallen, G * (steps * DT) ** 2 / 2, rtol=0.03)
    np.testing.assert_allclose(physics.field("time").cpu(), steps * DT, rtol=1e-5)


def test_a_pendulum_swings_with_its_period(physics: Physics, model: mujoco.MjModel):
    address = model.jnt_qposadr[model.joint("pivot").id]
    physics.write("qpos", 0.02, cols=[address])
    angles = []
    for _ in range(60):
        physics.step(4)
        angles.append(float(physics.field("qpos")[2, address]))
    angles = np.array(angles)
    before = np.flatnonzero(np.diff(np.sign(angles)))
    crossings = (before + angles[before] / (angles[before] - angles[before + 1])) * 4 * DT
    inertia_at_pivot = 0.02 + 2 * 0.5**2
    period = 2 * np.pi * np.sqrt(inertia_at_pivot / (2 * G * 0.5))
    np.testing.assert_allclose(crossings[1] - crossings[0], period / 2, rtol=1e-3)
    np.testing.assert_allclose(np.abs(angles).max(), 0.02, rtol=0.02)


def test_masses_that_differ_accelerate_differently(make: Callable[..., Physics], engine: str, model: mujoco.MjModel):
    physics = make(engine)
    ball = model.body("ball").id
    x = model.jnt_dofadr[model.body("ball").jntadr[0]]
    physics.step(10)  # captured before the field is expanded
    physics.reset()
    masses = torch.tensor([0.25, 0.5, 1.0, 2.0])
    field = physics.randomizable("body_mass")
    assert field.shape == (4, model.nbody)
    field[:, ball] = masses.to(field)
    physics.recompute_constants()
    assert physics.randomizable("body_mass") is field or torch.equal(physics.randomizable("body_mass"), field)
    physics.write("xfrc_applied", 1.0, cols=[6 * ball])
    physics.step(10)
    np.testing.assert_allclose(physics.field("qvel")[:, x].cpu(), 10 * DT / masses, rtol=1e-5)


def test_friction_that_differs_holds_differently(make: Callable[..., Physics], engine: str, model: mujoco.MjModel):
    physics = make(engine)
    friction = torch.tensor([0.1, 0.2, 0.3, 0.4])
    for geom in ("floor", "box"):  # a contact takes the larger of the two
        field = physics.randomizable("geom_friction")
        field[:, model.geom(geom).id, 0] = friction.to(field)
    physics.write("qpos", 0.03, cols=[2])
    physics.step(40)  # settle
    pull = 0.25  # of the weight
    physics.write("xfrc_applied", pull * G, cols=[6 * model.body("box").id])
    physics.step(20)
    speed = physics.field("qvel")[:, 0].cpu()
    expected = torch.tensor([pull - 0.1, pull - 0.2, 0.0, 0.0]) * G * 20 * DT
    np.testing.assert_allclose(speed, expected, atol=5e-3)


def test_a_randomised_model_moves_as_one_compiled_so(
    make: Callable[..., Physics], engine: str, model: mujoco.MjModel, spec: mujoco.MjSpec
):
    physics = make(engine)
    box = model.body("box").id
    for name, factor in (("body_mass", 3.0), ("body_inertia", 3.0)):
        physics.randomizable(name)[2, box] *= factor
    physics.recompute_constants()
    spec.geom("box").mass = 3.0
    heavier = spec.compile()
    data = mujoco.MjData(heavier)
    data.qpos[2], data.qvel[0], data.xfrc_applied[box, 0] = 0.05, 1.0, 8.0
    physics.write("qpos", 0.05, cols=[2])
    physics.write("qvel", 1.0, cols=[0])
    physics.write("xfrc_applied", 8.0, cols=[6 * box])
    physics.step(40)
    for _ in range(40):
        mujoco.mj_step(heavier, data)
    expected = data.qpos[:7]
    tolerance = 1e-8 if physics.name == "native" else 2e-4
    actual = physics.get_data(2).qpos[:7]
    np.testing.assert_allclose(actual, expected, atol=tolerance)
    assert np.abs(physics.get_data(1).qpos[:7] - expected).max() > 2 * tolerance


def test_contact_rich_motion_is_the_same_on_native_and_warp(make: Callable[..., Physics], model: mujoco.MjModel):
    native, warp = make("native-cpu"), make("warp-cpu")
    for physics in (native, warp):
        squeeze(physics)
        for _ in range(50):
            physics.step(1)
        assert not physics.health().failed.any()
    # 0.25 s of sliding, tipping and squeezing: float32 contacts against float64 ones
    torch.testing.assert_close(warp.field("qpos"), native.field("qpos"), atol=2e-4, rtol=0.0)
    torch.testing.assert_close(warp.field("qvel"), native.field("qvel"), atol=2e-2, rtol=0.0)
    block = model.jnt_qposadr[model.body("block").jntadr[0]] + 2
    assert native.field("qpos")[0, block] > 0.97  # held: free fall would have taken it to 0.69
