"""play.py's viewer and replay, and the description of a task, from the command line."""

import ast
import socket
from pathlib import Path

import gymnasium as gym
import pytest

import lift_lab_tasks  # noqa: F401
from lift_lab_tasks.manager_based.classic.cartpole.cartpole_env_cfg import CartpoleEnvCfg

SCRIPTS = Path(__file__).parents[2] / "scripts"
PLAY = ["--task", "Lift-Cube-Franka-Play", "--device", "cpu", "--num_threads", 1, "--num_envs", 2]


@pytest.fixture(autouse=True)
def place(tmp_path, monkeypatch):
    """A folder without runs is the current one."""
    monkeypatch.chdir(tmp_path)


def test_the_viewer_shows_an_agent_that_needs_no_checkpoint(script):
    pytest.importorskip("viser")
    status, out, _ = script("rsl_rl/play.py", *PLAY, "--viewer", "--port", 0, "--agent", "random", "--steps", 2)
    assert status == 0
    assert "viewer: http://127.0.0.1:" in out
    assert "2 steps of 2 environments" in out


def test_as_many_environments_are_shown_as_an_override_of_the_scene_says(script):
    pytest.importorskip("viser")
    flags = ["--task", "Cartpole", "--device", "cpu", "--num_threads", 1, "--port", 0, "--agent", "zero", "--steps", 1]
    status, out, _ = script("rsl_rl/play.py", *flags, "--viewer", "env.scene={num_envs:60}")
    assert status == 0
    assert "1 steps of 60 environments" in out


def test_a_replay_is_written_without_a_checkpoint(script, tmp_path):
    pytest.importorskip("viser")
    status, out, _ = script("rsl_rl/play.py", *PLAY, "--replay", "a.html", "--agent", "zero", "--steps", 2)
    assert status == 0
    assert "replay: a.html" in out
    assert (tmp_path / "a.html").stat().st_size > 100_000


@pytest.fixture
def own_task():
    """A task of the user's own, without a configuration of an agent."""
    entry = gym.spec("Cartpole").entry_point
    gym.register("Own-Cartpole", entry, disable_env_checker=True, kwargs={"env_cfg_entry_point": CartpoleEnvCfg})
    yield "Own-Cartpole"
    del gym.registry["Own-Cartpole"]


def test_zero_actions_are_filmed_without_a_checkpoint_and_without_an_agent(script, tmp_path, own_task):
    av = pytest.importorskip("av")
    small = ["--task", own_task, "--num_envs", 2, "--device", "cpu", "--num_threads", 1, "--steps", 3]
    status, out, err = script("rsl_rl/play.py", *small, "--agent", "zero", "--video", "env.viewer.resolution=[64,48]")
    if "no OpenGL library was found" in out + err:
        pytest.skip(out + err)
    assert (status, err) == (0, "")
    assert "policy: zero" in out
    with av.open(str(tmp_path / "videos" / "Own-Cartpole_zero.mp4")) as video:
        assert sum(1 for _ in video.decode(video=0)) == 3


@pytest.mark.parametrize("library", ["rsl_rl", "sb3", "skrl"])
def test_random_actions_follow_the_seed_with_every_library(script, library):
    small = ["--task", "Cartpole", "--num_envs", 2, "--device", "cpu", "--num_threads", 1, "--steps", 3]
    printed = [script(f"{library}/play.py", *small, "--agent", "random", "--seed", seed) for seed in (1, 1, 2)]
    assert [status for status, _, _ in printed] == [0, 0, 0]
    rewards = [out.partition("mean reward: ")[2].split()[0] for _, out, _ in printed]
    assert rewards[0] == rewards[1] != rewards[2]


def test_a_port_that_is_taken_is_told_before_anything_is_built(script):
    pytest.importorskip("viser")
    with socket.socket() as other:
        other.bind(("127.0.0.1", 0))
        other.listen()
        port = other.getsockname()[1]
        status, _, err = script("rsl_rl/play.py", *PLAY, "--viewer", "--port", port, "--agent", "zero")
    assert status == 2
    assert err.startswith(f"error: port {port} of 127.0.0.1 cannot be used")
    assert err.count("\n") == 1


@pytest.mark.parametrize(
    ("args", "message"),
    [
        (["--viewer", "--replay", "a.html"], "choose one of --viewer and --replay"),
        (["--viewer", "--video"], "--video films off screen"),
        (["--viewer", "--port", "0", "--agent", "zero", "--checkpoint", "x.pt"], "needs no --checkpoint"),
        (["--video", "--agent", "random", "--checkpoint", "x.pt"], "--agent random needs no --checkpoint"),
        (["--agent", "zero", "--load_run", "x"], "--agent zero needs no --load_run"),
        (["--viewer", "--port", "0"], "train first"),
        (["--viewer", "--agent", "zero", "--load_run", "x"], "--agent zero needs no --load_run"),
        (["--viewer", "--agent", "random", "--experiment_name", "x"], "--agent random needs no --experiment_name"),
        (["--port", "8081"], "--port is the viewer's: add --viewer"),
        (["--replay", "a.html", "--port", "8081"], "--port is the viewer's: add --viewer"),
        (["--replay", "a.txt"], "expected a file ending in .html"),
        (["--replay", "/proc/a/b.html", "--agent", "zero"], "cannot write '/proc/a/b.html'"),
        (["--viewer", "--video_envs", "2"], "--video_envs belongs to --video"),
        (["--video_length", "5"], "--video_length says what a video shows: add --video"),
        (["--checkpoint", "pretrained", "--load_run", "x"], "--load_run chooses among runs"),
        (["--use_pretrained_checkpoint", "--load_run", "x"], "--load_run chooses among runs"),
        (["--use_pretrained_checkpoint", "--checkpoint", "x.pt"], "both name the policy: give one"),
        (["--replay", "a.html", "--real-time"], "--real-time paces a simulation"),
        (["--agent", "sb3_cfg_entry_point"], "did you mean 'rsl_rl_cfg_entry_point'"),
        (["--agent", "none"], "choose one of: 'rsl_rl_cfg_entry_point', 'zero', 'random'"),
        (["--checkpoint", "pretrained", "--video", "--video_camera", "nope"], "camera 'nope'"),
    ],
)
def test_flags_that_do_not_go_together_are_answered_in_one_line(script, args, message):
    pytest.importorskip("viser")
    status, _, err = script("rsl_rl/play.py", *PLAY, *args)
    assert status == 2
    assert err.startswith("error: ")
    assert message in err
    assert err.count("\n") == 1


def test_a_checkpoint_of_another_task_is_refused_in_one_line(script, tmp_path):
    pytest.importorskip("viser")
    small = ["--device", "cpu", "--num_threads", 1, "--num_envs", 4, "--max_iterations", 1]
    status, _, _ = script("rsl_rl/train.py", "--task", "Cartpole", *small)
    assert status == 0
    (checkpoint,) = tmp_path.glob("logs/rsl_rl/cartpole/*/model_1.pt")
    status, _, err = script("rsl_rl/play.py", *PLAY, "--viewer", "--port", 0, "--checkpoint", checkpoint)
    assert status == 2
    assert err.startswith(f"error: checkpoint '{checkpoint}' does not fit this task's networks: ")
    assert err.count("\n") == 1


def test_a_policy_of_another_observation_size_is_refused_in_one_line_by_every_script(script, tmp_path):
    small = ["--device", "cpu", "--num_threads", 1, "--num_envs", 4]
    status, _, _ = script("rsl_rl/train.py", "--task", "Cartpole", *small, "--max_iterations", 1, "agent.seed=3")
    assert status == 0
    wider = [*small, "env.observations.policy.joint_pos_rel.history_length=2"]
    for name, more in (
        ("rsl_rl/play.py", []),
        ("rsl_rl/evaluate.py", ["--episodes", 1]),
        ("rsl_rl/train.py", ["--resume", "--max_iterations", 2]),
    ):
        status, _, err = script(name, "--task", "Cartpole", *wider, *more)
        assert status == 2, name
        assert err.startswith("error: checkpoint '"), name
        assert "does not fit this task's networks: " in err
        assert err.endswith("; it was trained with --task Cartpole agent.seed=3\n"), name
        assert err.count("\n") == 1, name


@pytest.mark.parametrize("name", ["play.py", "train.py"])
def test_without_an_opengl_library_one_line_says_so_and_the_rest_is_done(script, tmp_path, monkeypatch, name):
    pytest.importorskip("av")
    small = ["--task", "Cartpole", "--device", "cpu", "--num_threads", 1, "--num_envs", 4]
    if name == "play.py":
        script("rsl_rl/train.py", *small, "--max_iterations", 1)
    libraries = tmp_path / "libraries"
    libraries.mkdir()
    for library in ("libEGL.so", "libEGL.so.1"):  # found first by the process that draws, and no libraries
        (libraries / library).write_bytes(b"")
    monkeypatch.setenv("LD_LIBRARY_PATH", str(libraries))
    for variable in ("MUJOCO_GL", "DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(variable, raising=False)
    more = ["--steps", 2] if name == "play.py" else ["--max_iterations", 1, "--video_length", 2]
    status, out, err = script(f"rsl_rl/{name}", *small, "--video", *more)
    (line,) = [line for line in (out + err).splitlines() if line.startswith("warning: ")]
    assert "libegl1 libgl1-mesa-dri libopengl0" in line
    if name == "play.py":
        assert status == 1  # what was asked for is missing
        assert "2 steps of 4 environments" in out
    else:
        assert status == 0
        assert "finished after 1 iterations" in out
    assert not list(tmp_path.rglob("*.mp4"))


def test_training_loads_nothing_of_the_viewer():
    packages = SCRIPTS.parent / "source"
    files = [packages / "lift_lab_cli" / "train.py", *(packages / "lift_lab_rl" / "rsl_rl").glob("*.py")]
    for file in files:
        imports = [
            node for node in ast.walk(ast.parse(file.read_text())) if isinstance(node, ast.Import | ast.ImportFrom)
        ]
        names = {getattr(node, "module", None) or "" for node in imports} | {a.name for n in imports for a in n.names}
        assert not {name for name in names if name.split(".")[-1] in ("viewer", "visualizers", "viser")}, file


def test_a_task_is_described(script):
    status, out, _ = script("list_envs.py", "--describe", "Lift-Cube-Franka")
    assert status == 0
    assert "object_goal_tracking_fine_grained" in out
    assert "Ignored settings" in out
