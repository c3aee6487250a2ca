"""What the viewer shows and hides."""

import numpy as np
import pytest
import torch

from lift_lab.markers import VisualizationMarkers

G = 9.81


def handles(session):
    return session._scene.bodies.moving_bodies


def num_drawn(session, path):
    """Instances of a mesh in the browser's scene."""
    return len(session._server.scene.get_handle_by_name(path).batched_positions)


def test_only_the_selected_environment_is_drawn_with_its_markers(env, session):
    session._post("show", "only_env", True)
    session._post("env", 2)
    session.run(2)
    origin = env.unwrapped.scene.env_origins[2].numpy()
    cube = env.unwrapped.scene["object"].data.root_pos_w[2].numpy()
    hand, table = "/world/bodies/robot/panda_hand", "/world/bodies/table/Table"
    assert num_drawn(session, hand) == num_drawn(session, table) == 1
    scene = session._server.scene
    np.testing.assert_allclose(scene.get_handle_by_name("/world/bodies/object/Object").batched_positions, [cube])
    assert np.linalg.norm(scene.get_handle_by_name(table).batched_positions[0] - origin) < 1.5
    goal = VisualizationMarkers.of(env.unwrapped.sim)[0].positions_w[2].numpy()
    np.testing.assert_allclose(scene.get_handle_by_name("/world/markers/0/frame").batched_positions, [goal])
    session._post("show", "only_env", False)
    session.run(3)
    assert num_drawn(session, hand) == num_drawn(session, table) == 3


def test_colliders_are_sent_when_first_shown_and_follow_the_bodies(env, session):
    path = "/world/colliders/object/Object"
    assert session._server.scene.get_handle_by_name(path) is None
    session._post("show", "colliders", True)
    session._post("show", "visuals", False)
    session.run(3)
    collider = session._server.scene.get_handle_by_name(path)
    np.testing.assert_allclose(collider.batched_positions, env.unwrapped.scene["object"].data.root_pos_w.numpy())
    assert collider.visible
    assert not any(handle.visible for handle in handles(session).values())
    session._post("show", "colliders", False)
    session.run(4)
    assert not collider.visible


def test_frames_are_those_of_the_bodies_and_sites_of_the_selected_environment(env, session):
    session._post("env", 1)
    session._post("show", "frames", True)
    session.run(2)
    inner = env.unwrapped
    robot, cube = inner.scene["robot"], inner.scene["object"]
    frames = session._scene.frames.body_frames
    moving = [i for i, name in enumerate(robot.body_names) if name != "panda_link0"]
    expected = torch.cat((robot.data.body_pos_w[1, moving], cube.data.root_pos_w[1:2]))
    np.testing.assert_allclose(frames.batched_positions, expected.numpy(), atol=1e-5)
    target = inner.scene["ee_frame"].data.target_pos_w[1, 0].numpy()
    sites = session._server.scene.get_handle_by_name("/world/frames/sites").batched_positions
    assert np.abs(sites - target).max(axis=1).min() < 1e-4
    session._post("show", "frames", False)
    session.run(3)
    assert not frames.visible


def test_contact_forces_of_a_cube_at_rest_add_up_to_its_weight(env, session):
    for what in ("contact_points", "contact_forces"):
        session._post("show", what, True)
    session._post("env", 1)
    session._post("force_scale", 10.0)
    session.run(30)  # it lies still
    inner = env.unwrapped
    contacts = session._scene.contacts
    on_cube = np.linalg.norm(
        contacts.points.batched_positions - inner.scene["object"].data.root_pos_w[1].numpy(), axis=1
    )
    assert (on_cube < 0.05).sum() == 4
    weight = G * float(inner.scene["object"].get_masses()[1])
    arrows = contacts.arrows.points
    total_m = (arrows[:, 1] - arrows[:, 0]).sum(axis=0)
    np.testing.assert_allclose(total_m * 100 / 10.0, (0, 0, weight), atol=0.02 * weight)
    session._show_figures()
    assert f"{weight:.2f} N" in session._panel.figures.content
    for what in ("contact_points", "contact_forces"):
        session._post("show", what, False)
    session.run(31)
    assert contacts.points is None
    assert contacts.arrows is None
    session._show_figures()
    assert "contact" not in session._panel.figures.content


def test_to_follow_a_body_keeps_it_at_one_place_of_the_picture(env, session):
    session.run(1)
    hand = handles(session)[session._scene.moving["robot/panda_hand"]]
    world = session._server.scene.get_handle_by_name("/world")
    before = hand.batched_positions[0].copy()
    session._post("follow", "robot/panda_hand")
    session._policy.act = lambda obs: torch.ones(3, 8)
    session.run(15)
    moved = hand.batched_positions[0] - before
    assert np.linalg.norm(moved) > 0.02
    np.testing.assert_allclose(world.position, -moved, atol=1e-5)
    camera = session._server.initial_camera
    np.testing.assert_allclose(camera.look_at, before, atol=1e-5)
    session._post("env", 1)  # the same body of another environment is in the middle, too
    session.run(16)
    shown = hand.batched_positions[1] + np.asarray(world.position)
    np.testing.assert_allclose(camera.look_at, shown, atol=0.05)
    session._post("env", 0)
    session._post("view")
    session._post("follow", "nothing")
    session.run(17)
    assert not world.position.any()
    assert np.linalg.norm(camera.look_at - before) > 0.02


@pytest.mark.parametrize(
    ("request_", "problem"),
    [
        (("show", "contacts", True), "cannot show 'contacts'"),
        (("show", "actions", True), "cannot show 'actions'"),  # this task's actions draw nothing
        (("follow", "robot/panda_link0"), "no body 'robot/panda_link0' moves; did you mean 'robot/panda_link"),
        (("force_scale", float("nan")), "nan cm per N is not between"),
        (("plot", "reward"), "cannot plot 'reward'; did you mean 'rewards'"),
        (("plot_term", "lifting"), "cannot plot 'lifting' of rewards; did you mean 'lifting_object'"),
    ],
)
def test_what_this_scene_does_not_have_is_refused(session, request_, problem):
    session._post(*request_)
    session.run(1)
    assert problem in session.problem


def test_every_control_says_what_it_does(session):
    gui = session._server.gui
    inputs = [h for h in gui._gui_input_handle_from_uuid.values() if hasattr(h, "label")]
    assert len(inputs) > 15
    assert [h.label for h in inputs if not h.hint] == []


def press(session, key):
    """What viser calls when a key is pressed."""
    (command,) = [c for c in session._server.gui._command_handle_from_uuid.values() if c.hotkey == key]
    (callback,) = command._impl.trigger_cb
    callback(None)


def test_keys_do_what_the_controls_do(session):
    session.run(1)
    press(session, "N")
    press(session, "C")
    press(session, "F")
    session.run(2)
    assert session._scene.env_id == 1
    assert session._scene.shown["contact_points"]
    assert session._scene.shown["contact_forces"]
    assert session._panel.follow.value == "robot/panda_rightfinger"  # the root does not move
    for key in ("P", "P", "C", "F", "L", "X", "I", "M"):
        press(session, key)
    session.run(3)
    assert session._scene.env_id == 2  # the one before the first is the last
    shown = {name for name, on in session._scene.shown.items() if on}
    assert shown == {"visuals", "colliders", "frames", "only_env"}
    assert session._panel.follow.value == "nothing"
    press(session, "space")
    session._answer()
    assert session._paused
    press(session, "O")
    session.run(4)
    assert session.steps == 4
    press(session, "M")
    session._answer()
    assert session._scene.shown["commands"]
