"""What is written is what is read and simulated: state, kinematics and time, on every engine."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest
import scipy.spatial.transform
import torch

from lift_lab.sim.physics import Physics
from lift_lab.utils.errors import ConfigError, NotFoundError

BALL_Z = 7 + 1 + 2  # qpos: box 7, pivot 1, ball (x, y, z, ...)


def random_state(model: mujoco.MjModel, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """A configuration with unit quaternions and a velocity."""
    rng = np.random.default_rng(seed)
    qpos = model.qpos0 + 0.3 * rng.standard_normal(model.nq)
    for joint in np.flatnonzero(model.jnt_type == mujoco.mjtJoint.mjJNT_FREE):
        start = model.jnt_qposadr[joint] + 3
        qpos[start : start + 4] = np.roll(scipy.spatial.transform.Rotation.random(rng=rng).as_quat(), 1)
    return qpos, rng.standard_normal(model.nv)


def forwarded(model: mujoco.MjModel, qpos: np.ndarray, qvel: np.ndarray) -> mujoco.MjData:
    data = mujoco.MjData(model)
    data.qpos[:], data.qvel[:] = qpos, qvel
    mujoco.mj_forward(model, data)
    return data


def test_kinematics_of_written_states_are_those_of_mujoco(physics: Physics, model: mujoco.MjModel):
    names = ["xpos", "xquat", "xmat", "xipos", "site_xpos", "site_xmat", "geom_xpos", "subtree_com", "cdof", "cvel"]
    fields = {name: physics.field(name) for name in names}
    states = [random_state(model, seed) for seed in range(physics.num_envs)]
    physics.write("qpos", torch.tensor(np.array([q for q, _ in states])))
    physics.write("qvel", torch.tensor(np.array([v for _, v in states])))
    physics.refresh()
    for env, (qpos, qvel) in enumerate(states):
        data = forwarded(model, qpos, qvel)
        for name, field in fields.items():
            np.testing.assert_allclose(field[env].cpu(), getattr(data, name), atol=3e-6, err_msg=name)


def test_body_jacobian_is_that_of_mujoco(physics: Physics, model: mujoco.MjModel):
    qpos, qvel = random_state(model, 7)
    physics.write("qpos", torch.tensor(qpos))
    physics.refresh()
    data = forwarded(model, qpos, qvel)
    for body in range(model.nbody):
        linear, angular = np.zeros((3, model.nv)), np.zeros((3, model.nv))
        mujoco.mj_jacBody(model, data, linear, angular, body)
        expected = np.concatenate((linear, angular))
        np.testing.assert_allclose(physics.jac_body(body)[1].cpu(), expected, atol=1e-6)


def test_body_accelerations_are_those_of_mujoco_less_gravity(physics: Physics, model: mujoco.MjModel):
    qpos, qvel = random_state(model, 11)
    physics.write("qpos", torch.tensor(qpos))
    physics.write("qvel", torch.tensor(qvel))
    physics.write("qfrc_applied", 1.0)
    qacc = physics.field("qacc")
    physics.forward()
    data = mujoco.MjData(model)
    data.qpos[:], data.qvel[:], data.qfrc_applied[:] = qpos, qvel, 1.0
    mujoco.mj_forward(model, data)
    np.testing.assert_allclose(physics.com_acc(qacc)[2].cpu(), data.cacc - data.cacc[0], rtol=1e-3, atol=1e-3)


def test_accelerations_are_what_the_last_time_step_did_to_the_velocities(physics: Physics, model: mujoco.MjModel):
    """MuJoCo on its own, a step at a time; also that asking for them changes nothing of the motion."""
    qpos, qvel = random_state(model, 5)
    physics.write("qpos", torch.tensor(qpos))
    physics.write("qvel", torch.tensor(qvel))
    acceleration = physics.acceleration()
    assert not acceleration.any()
    physics.step(3)
    data = mujoco.MjData(physics.model)
    data.qpos[:], data.qvel[:] = qpos, qvel
    for _ in range(3):
        before = data.qvel.copy()
        mujoco.mj_step(physics.model, data)
    expected = (data.qvel - before) / model.opt.timestep
    scale = max(1.0, np.abs(data.qvel).max()) / model.opt.timestep  # of single precision's error
    np.testing.assert_allclose(acceleration[1].cpu(), expected, rtol=1e-3, atol=2e-5 * scale)
    np.testing.assert_allclose(physics.field("qvel")[1].cpu(), data.qvel, rtol=1e-3, atol=1e-3)
    physics.write("qvel", 0.0, env_ids=[0])
    physics.reset([2])
    assert not acceleration[0].any()
    assert acceleration[1].any()
    assert not acceleration[2].any()


def test_what_is_asked_for_after_a_write_is_of_the_new_state(physics: Physics, model: mujoco.MjModel):
    qpos, qvel = random_state(model, 13)
    xpos, cvel = physics.current("xpos"), physics.current("cvel")
    physics.write("qpos", torch.tensor(qpos), env_ids=torch.tensor([1]))
    physics.write("qvel", torch.tensor(qvel), env_ids=[1])
    data = forwarded(model, qpos, qvel)
    assert physics.current("xpos") is xpos
    np.testing.assert_allclose(xpos[1].cpu(), data.xpos, atol=1e-5)
    np.testing.assert_allclose(cvel[1].cpu(), data.cvel, rtol=1e-3, atol=1e-3)
    assert not np.allclose(xpos[0].cpu(), data.xpos, atol=1e-3)
    physics.step()
    before = xpos.clone()
    assert torch.equal(physics.current("xpos"), before)


def test_a_write_names_environments_and_columns(physics: Physics):
    qpos = physics.field("qpos")
    before = qpos.clone()
    physics.write("qpos", torch.tensor([[1.0, 2.0], [3.0, 4.0]]), env_ids=[2, 0], cols=[9, 7])
    before[2, 9], before[2, 7], before[0, 9], before[0, 7] = 1.0, 2.0, 3.0, 4.0
    assert torch.equal(qpos, before)
    physics.write("qpos", 5.0, env_ids=torch.tensor([1]), cols=slice(0, 2))
    before[1, :2] = 5.0
    assert torch.equal(qpos, before)


def test_a_mocap_body_is_where_it_was_written(physics: Physics, model: mujoco.MjModel):
    positions = torch.arange(3.0 * physics.num_envs).view(-1, 3)
    physics.write("mocap_pos", positions)
    physics.write("mocap_quat", torch.tensor([0.0, 1.0, 0.0, 0.0]))
    physics.refresh()
    marker = model.body("marker").id
    torch.testing.assert_close(physics.field("xpos")[:, marker].cpu(), positions)
    assert physics.field("xquat")[:, marker].cpu().tolist() == [[0.0, 1.0, 0.0, 0.0]] * physics.num_envs
    assert physics.field("mocap_pos").shape == (physics.num_envs, 1, 3)


def test_fields_stay_the_same_tensor(physics: Physics):
    fields = {name: physics.field(name) for name in ("qpos", "xpos", "qacc", "sensordata")}
    physics.step(2)
    physics.reset([0])
    physics.refresh()
    assert all(physics.field(name) is tensor for name, tensor in fields.items())
    assert all(tensor.dtype == torch.float32 for tensor in fields.values())


def test_step_leaves_kinematics_of_the_new_state(physics: Physics, model: mujoco.MjModel):
    physics.field("cvel")
    physics.write("qvel", torch.tensor(random_state(model, 3)[1]))
    physics.step(5)
    data = forwarded(model, physics.field("qpos")[1].cpu().numpy(), physics.field("qvel")[1].cpu().numpy())
    np.testing.assert_allclose(physics.field("xpos")[1].cpu(), data.xpos, atol=1e-6)
    np.testing.assert_allclose(physics.field("cvel")[1].cpu(), data.cvel, atol=2e-5)


def test_force_dependent_values_are_of_the_last_substep_until_forward(physics: Physics, model: mujoco.MjModel):
    sensors, qacc = physics.field("sensordata"), physics.field("qacc")
    ball = model.jnt_dofadr[model.body("ball").jntadr[0]]
    physics.write("xfrc_applied", 1.0, cols=[6 * model.body("ball").id + 0])  # 1 N along x on 0.5 kg
    physics.step(3)
    np.testing.assert_allclose(qacc[:, ball].cpu(), 2.0, rtol=1e-5)
    np.testing.assert_allclose(sensors[:, 6:].cpu(), [[2.0, 0.0, 0.0]] * physics.num_envs, atol=1e-5)
    physics.write("xfrc_applied", 3.0, cols=[6 * model.body("ball").id + 0])
    physics.write("qvel", 4.0, cols=[ball])
    physics.refresh()
    np.testing.assert_allclose(sensors[:, 3].cpu(), 4.0, rtol=1e-6)  # the velocity sensor follows,
    np.testing.assert_allclose(sensors[:, 6].cpu(), 2.0, rtol=1e-5)  # the accelerometer does not
    np.testing.assert_allclose(qacc[:, ball].cpu(), 2.0, rtol=1e-5)
    physics.forward()
    np.testing.assert_allclose(sensors[:, 6].cpu(), 6.0, rtol=1e-5)
    np.testing.assert_allclose(qacc[:, ball].cpu(), 6.0, rtol=1e-5)


def test_reset_restores_defaults_of_the_named_environments_only(physics: Physics, model: mujoco.MjModel):
    qacc = physics.field("qacc")
    for name in ("qvel", "ctrl", "qfrc_applied", "xfrc_applied", "mocap_pos"):
        physics.write(name, 0.5)
    physics.step(4)
    before = physics.field("qpos").clone()
    physics.reset([3, 1])
    for env in (1, 3):
        np.testing.assert_allclose(physics.field("qpos")[env].cpu(), model.qpos0, rtol=1e-6)
        for name in ("qvel", "ctrl", "qfrc_applied", "xfrc_applied", "time"):
            assert not physics.field(name)[env].any()
        assert physics.field("mocap_pos")[env].cpu().tolist() == [[0.0, 0.0, 1.0]]
        assert not qacc[env].any()
    assert torch.equal(physics.field("qpos")[[0, 2]], before[[0, 2]])
    assert physics.field("ctrl")[[0, 2]].eq(0.5).all()
    assert physics.field("time")[[0, 2]].cpu().tolist() == pytest.approx([0.02, 0.02])
    assert qacc[0].any()


def test_one_environment_can_be_taken_out_as_mjdata(physics: Physics, model: mujoco.MjModel):
    physics.write("qpos", torch.tensor(random_state(model, 5)[0]), env_ids=[2])
    physics.refresh()
    data = physics.get_data(2)
    assert physics.get_data(2, data) is data
    np.testing.assert_allclose(data.qpos, physics.field("qpos")[2].cpu(), atol=1e-6)
    np.testing.assert_allclose(data.geom_xpos, physics.field("geom_xpos")[2].cpu(), atol=1e-6)


def test_wrong_names_and_shapes_are_told_with_the_nearest_choices(physics: Physics):
    with pytest.raises(NotFoundError, match=r"unknown physics field 'xpso'.*'xpos'"):
        physics.field("xpso")
    with pytest.raises(NotFoundError, match=r"'subtree_linvel' is computed only .*subtreelinvel"):
        physics.field("subtree_linvel")
    with pytest.raises(NotFoundError, match=r"cannot write 'xpos': it is derived and read-only.*'qpos'"):
        physics.write("xpos", 0.0)
    with pytest.raises(ConfigError, match=r"cannot write 'ctrl': values of shape \(3,\) do not fit \(4, 2\)"):
        physics.write("ctrl", torch.zeros(3))
    with pytest.raises(NotFoundError, match=r"'body_parentid' cannot differ between environments"):
        physics.randomizable("body_parentid")
    with pytest.raises(ConfigError, match="num_substeps must be at least 1, got 0"):
        physics.step(0)


def test_gravity_is_that_of_now(physics: Physics, model: mujoco.MjModel):
    np.testing.assert_allclose(physics.gravity.cpu(), np.tile(model.opt.gravity, (physics.num_envs, 1)), rtol=1e-6)
    physics.randomizable("opt.gravity")[1] = torch.tensor([0.0, 1.0, -3.0]).to(physics.randomizable("opt.gravity"))
    np.testing.assert_allclose(physics.gravity[1].cpu(), (0.0, 1.0, -3.0))
    np.testing.assert_allclose(physics.gravity[0].cpu(), model.opt.gravity, rtol=1e-6)
