"""A body pulled with the mouse."""

from types import SimpleNamespace

import numpy as np
import pytest
import torch


@pytest.fixture
def cube(env):
    return env.unwrapped.scene["object"]


def drag(session, body, env_id, *points, end=True):
    """What viser calls while the mouse drags a body of an environment over points of the picture."""
    (entry,) = session._scene.bodies.moving_bodies[body]._impl.drag_cb
    phases = ["start", *["update"] * (len(points) - 1)] + (["end"] if end else [])
    for phase, point in zip(phases, (*points, points[-1]), strict=False):
        event = SimpleNamespace(phase=phase, instance_index=env_id, start_position=points[0], end_position=point)
        with pytest.raises(StopIteration):
            entry.callback(event).send(None)


def above(point, height):
    return (point[0], point[1], point[2] + height)


def body_id(env, asset):
    return env.unwrapped.scene[asset].engine_body_ids[0]


def test_a_cube_is_lifted_by_a_spring_and_falls_when_let_go(env, session, cube, go):
    go(20)
    before = cube.data.root_pos_w.clone()
    start, target = before[1].tolist(), (before[1] + torch.tensor([0.0, 0.1, 0.3])).tolist()
    drag(session, body_id(env, "object"), 1, start, target, end=False)
    go(100)
    # a mass on a spring of 15 rad/s hangs g / 15**2 below the pointer
    np.testing.assert_allclose(cube.data.root_pos_w[1], np.array(target) - (0, 0, 9.81 / 15**2), atol=2e-3)
    weight = 9.81 * float(cube.get_masses()[1])
    np.testing.assert_allclose(session._puller.force, (0, 0, weight), atol=0.02)
    session._show_figures()
    assert f"pulling object/Object of environment 1 with {weight:.1f} N" in session._panel.status.content
    others = [0, 2]
    torch.testing.assert_close(cube.data.root_pos_w[others], before[others], atol=1e-3, rtol=0)
    session._post("let_go")
    go(40)
    assert abs(float(cube.data.root_pos_w[1, 2] - before[1, 2])) < 0.01
    assert not env.unwrapped.sim.physics.field("xfrc_applied").any()


def test_a_wrench_that_the_task_has_set_stays(env, session, cube, go):
    go(1)
    task = torch.tensor([[[0.1, 0.0, 0.2]]])
    cube.set_external_force_and_torque(task, 0.1 * task, env_ids=torch.tensor([2]))
    wrench = cube.external_wrench_b.clone()
    start = cube.data.root_pos_w[2].tolist()
    drag(session, body_id(env, "object"), 2, start, (np.array(start) + 0.2).tolist(), end=False)
    applied = []
    env_step = session._env.step
    session._env.step = lambda actions: (applied.append(cube.external_wrench_b.clone()), env_step(actions))[1]
    try:
        go(2)
    finally:
        del session._env.step
    assert not torch.equal(applied[0], wrench)
    torch.testing.assert_close(cube.external_wrench_b, wrench, rtol=0, atol=0)


def test_the_grabbed_point_is_pulled_not_the_centre(env, session, cube, go):
    go(20)
    # an edge of the cube is pulled up: it tips
    centre = cube.data.root_pos_w[0]
    grabbed = (centre + torch.tensor([0.0, 0.019, 0.0])).tolist()
    drag(session, body_id(env, "object"), 0, grabbed, above(grabbed, 0.06), end=False)
    go(2)
    assert 0.3 < float(cube.data.root_ang_vel_w[0, 0]) < 20


def test_an_episode_that_ends_while_the_mouse_pulls(env, session, cube, go):
    go(2)
    start = cube.data.root_pos_w[0].tolist()
    drag(session, body_id(env, "object"), 0, start, above(start, 0.2), end=False)
    go(2)
    env.unwrapped.episode_length_buf[:] = env.unwrapped.max_episode_length - 1
    go(1)
    assert session._puller.pull.last_w is None
    go(2)
    assert session._puller.pull is not None
    assert float(session._puller.force.norm()) < 60


def test_with_one_environment_drawn_the_mouse_pulls_that_one(env, session, go):
    session._post("env", 2)
    session._post("show", "only_env", True)
    go(1)
    drag(session, body_id(env, "object"), 0, (1.0, 2.0, 3.0), (1.0, 2.0, 3.1), end=False)
    go(2)
    assert session._puller.pull.env_id == 2


def test_the_mouse_pulls_where_the_picture_was_shifted_to(env, session, cube, go):
    go(1)
    session._scene.world.move(np.array([1.0, 2.0, 3.0]))
    drawn = (cube.data.root_pos_w[1] + torch.tensor([1.0, 2.0, 3.0])).tolist()
    drag(session, body_id(env, "object"), 1, drawn, drawn, end=False)
    session._answer()
    torch.testing.assert_close(session._puller.pull.target_w, cube.data.root_pos_w[1], atol=1e-5, rtol=0)


def test_bodies_that_no_force_can_move_are_not_draggable(session):
    names = {session._scene.body_names[i] for i in session._puller.body_ids}
    assert {"object/Object", "robot/panda_hand"} <= names
    assert "table/Table" not in names
    assert "robot/panda_link0" not in names


def test_a_point_that_is_no_number_is_refused(env, session, go):
    session._post("grab", 0, body_id(env, "object"), (float("nan"), 0.0, 0.0))
    go(1)
    assert "cannot pull at" in session.problem
    assert session._puller.pull is None
