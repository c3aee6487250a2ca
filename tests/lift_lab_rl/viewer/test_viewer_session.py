"""The live viewer and the replay page, without a browser."""

import base64
import re
import shutil
import signal

import msgspec
import pytest
import torch

from lift_lab.markers import VisualizationMarkers
from lift_lab.utils.errors import ConfigError, FileError, LiftLabError
from lift_lab.visualizers import open_server
from lift_lab_rl.viewer import CheckpointPolicy, RandomPolicy, ViewerSession, ZeroPolicy, record_replay

pytest.importorskip("viser")


def shapes(session):
    """What was sent to the browser: path in the scene -> its handle."""
    return {handle.name: handle for handle in session._scene.bodies.moving_bodies.values()}


def test_every_body_stands_at_the_origin_of_its_environment_plus_its_own_place(env, session):
    session.run(2)
    inner = env.unwrapped
    hand = inner.scene["robot"].body_names.index("panda_hand")
    sent = shapes(session)["/world/bodies/robot/panda_hand"]
    torch.testing.assert_close(torch.tensor(sent.batched_positions), inner.scene["robot"].data.body_pos_w[:, hand])
    torch.testing.assert_close(torch.tensor(sent.batched_wxyzs), inner.scene["robot"].data.body_quat_w[:, hand])


def test_bodies_that_cannot_move_are_sent_once(session):
    assert "/world/bodies/table/Table" not in shapes(session)
    assert "/world/bodies/robot/panda_link0" not in shapes(session)


def test_a_goal_set_by_hand_is_the_goal_of_every_environment_until_given_back(env, session):
    before = env.unwrapped.command_manager.get_term("object_pose").cfg.ranges.pos_x
    session._post("goal", [0.45, -0.1, 0.4])
    session._post("reset")
    session.run(3)
    term = env.unwrapped.command_manager.get_term("object_pose")
    goal = torch.tensor([0.45, -0.1, 0.4])
    torch.testing.assert_close(term.command[:, :3], goal.expand(3, 3))
    markers = VisualizationMarkers.of(env.unwrapped.sim)[0]
    torch.testing.assert_close(markers.positions_w, goal + env.unwrapped.scene.env_origins)
    session._post("goal", None)
    session.run(4)
    assert term.cfg.ranges.pos_x == before
    assert len(set(term.command[:, 0].tolist())) == 3


def test_one_step_at_a_time(env, session):
    session._post("step")
    session.run(1)
    assert session.steps == 1
    assert session._paused


def test_every_click_on_step_is_a_step_also_while_one_is_running(session):
    for _ in range(3):
        session._post("step")
    wait, idle = session._wait, iter(range(10))
    session._wait = lambda due: wait(due) if next(idle, None) is not None else session.stop()
    session.run(10)
    assert session.steps == 3


def test_a_reset_by_hand_forgets_the_memory_of_the_policy(session):
    seen = []
    session._policy.reset = lambda dones: seen.append(dones.tolist())
    session._post("reset")
    session.run(1)
    assert seen == [[True] * 3, [False] * 3]


def test_a_problem_is_shown_until_the_same_control_gets_a_good_value(session):
    session._post("env", 99)
    session.run(1)
    assert "no environment 99" in session.problem
    session._post("speed", "2")
    session.run(2)
    assert "no environment 99" in session.problem
    session._post("env", 1)
    session.run(3)
    assert session.problem is None


def test_ctrl_c_ends_it_after_the_running_step_and_a_second_one_at_once(env, session):
    handler = signal.signal(signal.SIGINT, session.stop)
    try:
        signal.raise_signal(signal.SIGINT)
        session.run(5)
        assert session.steps == 0
        with pytest.raises(KeyboardInterrupt):
            signal.raise_signal(signal.SIGINT)
    finally:
        signal.signal(signal.SIGINT, handler)


def test_episodes_that_end_are_counted(env, session):
    inner = env.unwrapped
    inner.episode_length_buf[:] = inner.max_episode_length - 1
    session._env.reset = lambda: (env.get_observations(), {})
    try:
        session.run(1)
    finally:
        del session._env.reset
    assert session._success.episodes == 3
    assert session._success.rate == 0.0
    session._show_figures()
    assert "0% of 3" in session._panel.episode.content
    assert "reaching_object" in session._panel.figures.content
    assert "· object_position_error" in session._panel.episode.content  # below the command that it is logged with


def test_markers_can_be_hidden_and_sensor_frames_shown(env, session):
    session._post("show", "commands", False)
    session._post("show", "sensors", True)
    session.run(1)
    goal = VisualizationMarkers.of(env.unwrapped.sim)[0]
    assert not goal.is_visible()
    frames = env.unwrapped.scene["ee_frame"].frame_visualizer
    data = env.unwrapped.scene["ee_frame"].data
    torch.testing.assert_close(frames.positions_w[3:6], data.target_pos_w[:, 0])
    # the line: from the middle, half its length along its z axis is the target
    turned = torch.linalg.vector_norm(frames.scales[6:, 2:], dim=1)
    torch.testing.assert_close(turned, (data.target_pos_w[:, 0] - data.source_pos_w).norm(dim=1))
    session._post("show", "commands", True)
    session._post("show", "sensors", False)
    session.run(2)


def test_random_actions_are_within_one(env):
    actions = RandomPolicy(env).act(None)
    assert actions.shape == (3, 8)
    assert actions.abs().max() <= 1.0
    assert actions.std() > 0.3


def test_a_replay_is_one_page_as_long_as_the_episode(env, tmp_path):
    zstandard = pytest.importorskip("zstandard")
    size = record_replay(env, ZeroPolicy(env), tmp_path / "new" / "a.html", steps=10)
    page = (tmp_path / "new" / "a.html").read_text()
    assert size == len(page.encode())
    data = max(re.findall(r'"([A-Za-z0-9+/=]{1000,})"', page), key=len)
    recording = zstandard.ZstdDecompressor().decompress(base64.b64decode(data)[8:])
    length = int.from_bytes(recording[:8], "little")
    content = msgspec.msgpack.decode(recording[8 : 8 + length])
    assert content["durationSeconds"] == pytest.approx(10 * env.unwrapped.step_dt)
    names = {message.get("name") for _, message in content["messages"]}
    assert {"/world/bodies/robot/panda_hand", "/world/bodies/object/Object", "/world/bodies/table/Table"} <= names
    assert max(time for time, _ in content["messages"]) == pytest.approx(10 * env.unwrapped.step_dt)


@pytest.fixture
def run_session(env, run):
    """A session of the checkpoints of a run, all of which stand still."""

    class StandingRunner(Runner):
        def get_inference_policy(self, device):
            policy = ZeroPolicy(env)
            return type("Standing", (), {"__call__": lambda self, obs: policy.act(obs), "reset": policy.reset})()

    server = open_server(port=0)
    session = ViewerSession(env, CheckpointPolicy(StandingRunner(), run / "model_9.pt", "cpu"), server, "Lift")
    session._do_speed("as fast as possible")
    yield session
    server.stop()


def test_a_page_says_that_the_run_was_deleted_and_the_policy_goes_on(run_session, run):
    run_session.run(1)
    shutil.rmtree(run)
    run_session._post("policy", "model_10.pt")
    run_session.run(3)
    run_session._show_figures()
    assert run_session.steps == 3
    assert "no file" in run_session.problem
    assert "is gone: 'model_9.pt' goes on from memory" in run_session._panel.status.content


def test_newest_changes_to_each_checkpoint_that_training_writes(run_session, run):
    run_session._post("newest", True)
    run_session.run(1)
    assert run_session._policy.current == "model_10.pt"
    (run / "model_50.pt").write_text("50")
    run_session.run(2)
    run_session._look_for_checkpoints()
    assert run_session._panel.policy.value == "model_50.pt"
    assert "model_50.pt" in run_session._panel.policy.options


@pytest.mark.parametrize("name", ["../secret.pt", "/etc/passwd", "model_9.pt/../model_9.pt", "model_99.pt", ""])
def test_a_page_can_only_choose_a_policy_of_the_list(run_session, run, name):
    (run.parent / "secret.pt").write_text("7")
    run_session._post("policy", name)
    run_session.run(1)
    assert run_session._policy.current == "model_9.pt"
    assert f"no file '{name}' in '{run}'" in run_session.problem


@pytest.mark.parametrize(
    ("what", "value", "problem"),
    [
        ("speed", "9e999", "speed '9e999'"),
        ("env", 3, "no environment 3; choose one from 0 to 2"),
        ("env", -1, "no environment -1"),
        ("env", float("nan"), "no environment nan"),
        ("goal", [float("nan"), 0.0, 0.4], r"object_pose.pos_x: nan is not between 0.4 and 0.6"),
        ("goal", [9.0, 0.0, 0.4], r"object_pose.pos_x: 9.0 is not between 0.4 and 0.6"),
    ],
)
def test_a_value_that_no_control_offers_is_refused_and_the_session_goes_on(session, what, value, problem):
    session._post(what, value)
    session.run(2)
    assert session.steps == 2
    assert problem in session.problem


class Runner:
    """Loads a checkpoint's text as a constant action."""

    def load_policy(self, path):
        try:
            with open(path) as file:
                text = file.read()
        except FileNotFoundError as error:
            raise FileError(f"no file {path}") from error
        if not text.isdigit():
            raise ConfigError("other networks")
        self.value = int(text)

    def get_inference_policy(self, device):
        return lambda obs: self.value


@pytest.fixture
def run(tmp_path):
    folder = tmp_path / "run"
    folder.mkdir()
    for name, text in (("model_9.pt", "9"), ("model_10.pt", "10"), ("model_best.pt", "1"), ("model_2.pt", "bad")):
        (folder / name).write_text(text)
    return folder


def test_checkpoints_are_listed_in_the_order_of_training(run):
    policy = CheckpointPolicy(Runner(), run / "model_9.pt", "cpu")
    assert policy.choices() == ["model_best.pt", "model_2.pt", "model_9.pt", "model_10.pt"]
    assert policy.newest() == "model_10.pt"
    policy.choose("model_10.pt")
    assert policy.act(None) == 10
    (run / "model_50.pt").write_text("50")
    assert policy.newest() == "model_50.pt"


def test_a_checkpoint_of_another_task_leaves_the_old_policy_acting(run):
    policy = CheckpointPolicy(Runner(), run / "model_9.pt", "cpu")
    with pytest.raises(ConfigError):
        policy.choose("model_2.pt")
    assert (policy.current, policy.act(None)) == ("model_9.pt", 9)


def test_a_run_that_is_deleted_meanwhile_is_reported_and_goes_on(run):
    policy = CheckpointPolicy(Runner(), run / "model_9.pt", "cpu")
    assert policy.warning() is None
    shutil.rmtree(run)
    with pytest.raises(LiftLabError):
        policy.choose("model_10.pt")
    assert policy.act(None) == 9
    assert policy.choices() == ["model_9.pt"]
    assert "is gone" in policy.warning()
