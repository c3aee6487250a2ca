"""The scripts do what their names say, and answer a user's mistake in one line with exit status 2."""

import filecmp
import json

import mujoco
import onnx
import pytest
import torch

SMALL = ["--task", "Lift-Cube-Franka", "--device", "cpu", "--num_threads", "1"]


@pytest.fixture(scope="module")
def place(tmp_path_factory):
    """One folder for the module: later tests use the runs of earlier ones."""
    return tmp_path_factory.mktemp("runs")


@pytest.fixture(autouse=True)
def _inside(place, monkeypatch):
    monkeypatch.chdir(place)


def runs(place, name):
    found = sorted((place / "logs" / "rsl_rl" / "franka_lift").glob(f"*_{name}*"))
    assert len(found) == 1
    return found[0]


def train(script, name, iterations, *more):
    flags = [*SMALL, "--num_envs", 16, "--run_name", name, "--max_iterations", iterations, "--seed", 3]
    return script("rsl_rl/train.py", *flags, "agent.save_interval=2", *more)


def test_training_writes_models_curves_and_configurations(script, place):
    status, out, _ = train(script, "whole", 4)
    assert status == 0
    run = runs(place, "whole")
    names = {path.name for path in run.iterdir()}
    assert {"model_2.pt", "model_4.pt", "resume_state_2.pt", "resume_state_4.pt", "params"} <= names
    assert (run / "params" / "env.yaml").is_file()
    assert (run / "params" / "agent.yaml").is_file()
    assert any(name.startswith("events.out.tfevents") for name in names)
    assert "Active Reward Terms" in out
    assert [line.split(" | ")[0] for line in out.splitlines() if " | left " in line] == ["1/4", "2/4", "3/4", "4/4"]
    assert not (place / "outputs").exists()


def test_a_run_that_is_continued_ends_with_the_bytes_of_one_that_never_stopped(script, place):
    train(script, "first_half", 2)
    more = ["--resume", "--load_run", ".*_first_half", "--export_io_descriptors"]
    status, out, _ = train(script, "second_half", 4, *more)
    assert status == 0
    described = runs(place, "second_half") / "io_descriptors" / "IO_descriptors.yaml"
    assert f"IO descriptors: {described}" in out
    assert described.is_file()
    assert "continuing the episodes of iteration 2" in out
    assert [line.split(" | ")[0] for line in out.splitlines() if " | left " in line] == ["3/4", "4/4"]
    files = [runs(place, name) / "model_4.pt" for name in ("whole", "second_half")]
    assert filecmp.cmp(*files, shallow=False)


def test_two_threads_give_the_bytes_of_one(script, place):
    train(script, "two_threads", 4, "--num_threads", 2)
    files = [runs(place, name) / "model_4.pt" for name in ("whole", "two_threads")]
    assert filecmp.cmp(*files, shallow=False)


def test_without_the_saved_episodes_a_run_continues_with_fresh_ones(script, place):
    (runs(place, "first_half") / "resume_state_2.pt").unlink()
    status, out, _ = train(script, "fresh", 3, "--resume", "--load_run", ".*_first_half")
    assert status == 0
    assert "starting fresh episodes" in out
    assert (runs(place, "fresh") / "model_3.pt").is_file()


def test_another_configuration_continues_with_fresh_episodes(script, place):
    more = ["--resume", "--load_run", ".*_whole", "--checkpoint", "model_2.pt", "env.rewards.lifting_object.weight=20"]
    status, out, _ = train(script, "changed", 3, *more)
    assert status == 0
    assert "configuration differs" in out


def test_evaluation_counts_episodes_and_writes_json(script, place):
    status, out, _ = script("rsl_rl/evaluate.py", *SMALL, "--episodes", 4, "--json", "result.json")
    assert status == 0
    result = json.loads((place / "result.json").read_text())
    assert result["episodes"] == sum(result["terminations"].values()) == 4
    assert set(result["success_rate"]) == {"4"}
    assert 0.0 < result["mean_episode_length"] <= 250.0
    assert "success rate, first 4 episodes" in out


def test_playing_exports_the_policy_beside_its_checkpoint(script, place):
    checkpoint = runs(place, "whole") / "model_4.pt"
    flags = ["--task", "Lift-Cube-Franka-Play", "--device", "cpu", "--num_envs", 2, "--steps", 3]
    status, _, _ = script("rsl_rl/play.py", *flags, "--checkpoint", checkpoint)
    assert status == 0
    exported = checkpoint.parent / "exported"
    policy = torch.jit.load(str(exported / "policy.pt"))
    assert policy(torch.zeros(2, 36)).shape == (2, 8)
    texts = {prop.key: prop.value for prop in onnx.load(exported / "policy.onnx").metadata_props}
    assert (texts["task"], texts["iteration"]) == ("Lift-Cube-Franka-Play", "4")
    assert (texts["run_path"], texts["checkpoint"]) == (checkpoint.parent.name, "model_4.pt")
    assert mujoco.MjModel.from_xml_path(str(exported / "scene.xml")).key("initial").id == 0


def test_the_benchmark_measures_engine_and_environment(script, place):
    flags = ["--task", "Lift-Cube-Franka", "--device", "cpu", "--num_envs", 8, "--steps", 5, "--json", "speed.json"]
    status, _, _ = script("benchmark.py", *flags)
    assert status == 0
    result = json.loads((place / "speed.json").read_text())
    assert result["ratio"] > 0.0
    assert result["ratio"] == pytest.approx(result["env_steps_per_s"] * 4 / result["physics_steps_per_s"])


def test_a_profile_has_the_engine_and_the_update_among_its_parts(script, place):
    flags = ["--task", "Lift-Cube-Franka", "--device", "cpu", "--num_envs", 8, "--steps", 5, "--json", "profile.json"]
    status, printed, _ = script("benchmark.py", *flags, "--profile", "--profile_training", 1)
    assert status == 0
    result = json.loads((place / "profile.json").read_text())
    step, iteration = result["profile_s"], result["profile_training_s"]
    assert {"physics", "rewards", "observations"} < set(step)
    assert {"physics", "actor: network", "critic: network", "update: forward", "update: backward"} < set(iteration)
    assert all(seconds >= 0.0 for parts in (step, iteration) for seconds in parts.values())
    # 24 steps of the environment are within an iteration
    assert iteration["physics"] > step["physics"]
    assert "CPU time of a training iteration of 8 environments" in printed


def test_tasks_are_listed(script):
    status, out, _ = script("list_envs.py", "--keyword", "franka")
    assert status == 0
    pretrained = {line.split()[1]: "yes" in line.split() for line in out.splitlines() if line.startswith("│")}
    assert all(pretrained.values())
    assert {"Lift-Cube-Franka-CL-Play", "Lift-Soft-Cube-Franka"} <= set(pretrained)


@pytest.mark.parametrize(
    ("name", "args", "message"),
    [
        (
            "rsl_rl/train.py",
            ["--task", "Lift-Cube-Frank"],
            "unknown task 'Lift-Cube-Frank'; did you mean 'Lift-Cube-Franka'",
        ),
        ("rsl_rl/train.py", [], "required: --task"),
        ("rsl_rl/train.py", [*SMALL, "--num_env", "4"], "unknown flag '--num_env'; did you mean --num_envs"),
        ("rsl_rl/train.py", [*SMALL, "--num_envs", "0"], "at least 1, got '0'"),
        ("rsl_rl/train.py", [*SMALL, "env.rewards.lift.weight=2"], "unknown override key 'env.rewards.lift.weight'"),
        ("rsl_rl/train.py", [*SMALL, "env.decimation=a"], "env.decimation: expected int, got str 'a'"),
        ("rsl_rl/train.py", [*SMALL, "--device", "cuda:77"], "'cuda:77' is not available"),
        (
            "rsl_rl/train.py",
            [*SMALL, "--agent", "rsl_cfg"],
            "has no 'rsl_cfg' for rsl_rl; choose one of: 'rsl_rl_cfg_entry_point'",
        ),
        ("rsl_rl/train.py", [*SMALL, "--checkpoint", "x.pt"], "add --resume"),
        (
            "rsl_rl/train.py",
            [*SMALL, "--max_iterations", "3", "agent.max_iterations=5"],
            "--max_iterations 3 and agent.max_iterations=5: give one of them",
        ),
        ("rsl_rl/train.py", [*SMALL, "--logger", "neptune"], "neptune's service ended"),
        ("rsl_rl/train.py", [*SMALL, "--log_project_name", "a"], "--log_project_name needs --logger wandb"),
        ("rsl_rl/train.py", [*SMALL, "--experiment_name", "none", "--resume"], "train first"),
        ("rsl_rl/train.py", [*SMALL, "--resume", "--load_run", ".*whole", "--max_iterations", "4"], "finished 4 of 4"),
        ("rsl_rl/play.py", [*SMALL, "--checkpoint", "logs/nothing/model_1.pt"], "'logs' has no 'nothing'"),
        ("rsl_rl/evaluate.py", [*SMALL, "--load_run", "absent"], "no run in"),
        ("rsl_rl/evaluate.py", [*SMALL, "agent.load_run=absent"], "no run in"),
        ("rsl_rl/evaluate.py", [*SMALL, "--load_run", "a", "agent.load_run=b"], "--load_run a and agent.load_run=b"),
        ("rsl_rl/play.py", [*SMALL, "agent.load_checkpoint=model_99.pt"], "matches 'model_99.pt'"),
        ("rsl_rl/evaluate.py", [*SMALL, "--load_run", "absent", "--perturb", "mas=2"], "did you mean 'mass'"),
        (
            "rsl_rl/train.py",
            [*SMALL, "--num_envs", "2", "env.actions.arm_action.joint_names=[panda_jont.*]"],
            "did you mean 'panda_joint1'",
        ),
        (
            "rsl_rl/train.py",
            [*SMALL, "--num_envs", "2", "env.scene.object.spawn.usd_path=cubee.usda"],
            "did you mean 'cube.usda'",
        ),
        (
            "rsl_rl/train.py",
            [*SMALL, "--num_envs", "2", "agent.algorithm.advantage_clip=-1"],
            "agent.algorithm.advantage_clip is -1; it must be finite and above 0, or null",
        ),
        (
            "rsl_rl/train.py",
            [*SMALL, "--seed", "-5"],
            "-5; it must be at least 0 and at most 4294967295, or -1",
        ),
        ("rsl_rl/train.py", [*SMALL, "--run_name", "a/b"], "'a/b' cannot be part of a folder's name"),
        ("rsl_rl/train.py", [*SMALL, "agent.algorithm.schedule=adaptve"], "did you mean 'adaptive'"),
        ("list_envs.py", ["--keyword", "zzz"], "no task contains 'zzz'"),
        ("list_envs.py", ["--describe", "Cartpole", "--keyword", "a"], "--keyword filters the list"),
        ("list_envs.py", ["-m"], "unknown flag '-m'"),
        ("rsl_rl/evaluate.py", [*SMALL, "--agent", "env_cfg_entry_point"], "'rsl_rl_cfg_entry_point'"),
        ("rsl_rl/evaluate.py", [*SMALL, "--json", "."], "cannot write '.': it is a folder"),
        ("rsl_rl/evaluate.py", [*SMALL, "--perturb", "standard"], "several evaluations: use lift-lab study"),
        (
            "rsl_rl/evaluate.py",
            [*SMALL, "--perturb", "mass=2", "mass=3", "env.scene.num_envs=2"],
            "perturbation 'mass' is given twice",
        ),
        (
            "maintainers/export_pretrained.py",
            ["x.pt", "--task", "Cartpole", "--evaluation", __file__],
            "test_command_lines.py': it is not JSON",
        ),
        ("maintainers/video_cost.py", ["--steps", "0"], "at least 1, got '0'"),
        ("list_envs.py", ["extra"], "unexpected argument 'extra'"),
        ("benchmark.py", ["--task", "Lift-Cube-Franka", "--steps", "0"], "at least 1, got '0'"),
    ],
)
def test_a_mistake_is_answered_in_one_line(script, name, args, message):
    status, out, err = script(name, *args)
    assert status == 2
    assert out == ""
    assert err.startswith("error: ")
    assert message in err
    assert err.count("\n") == 1


def test_flags_of_isaac_lab_without_effect_are_named(script):
    flags = ["--headless", "--enable_cameras", "--disable_fabric"]
    status, _, err = script("rsl_rl/train.py", "--task", "nothing", *flags)
    assert status == 2
    assert err.splitlines()[0] == "no effect here: --enable_cameras, --disable_fabric (there is no Omniverse)"


def test_a_training_ends_when_its_task_is_solved_and_a_flag_trains_on(script, place):
    flags = ["--task", "Cartpole", "--device", "cpu", "--num_threads", 1, "--num_envs", 8, "--run_name", "solved"]
    flags += ["--seed", 3, "--max_iterations", 9, "env.episode_length_s=0.2"]
    early = [f"agent.evaluation.{name}" for name in ("from_success=null", "min_success=0", "max_share=1", "episodes=4")]
    status, out, _ = script("rsl_rl/train.py", *flags, *early, "agent.evaluation.interval=1")
    assert status == 0
    assert "evaluation at iteration 2: success" in out
    assert "the task is solved: training ends after 2 iterations" in out
    assert "finished after 2 iterations, the task is solved: " in out
    (run,) = (place / "logs" / "rsl_rl" / "cartpole").glob("*_solved")
    assert {"model_2.pt", "resume_state_2.pt", "model_best.pt"} <= {path.name for path in run.iterdir()}

    status, _, err = script("rsl_rl/train.py", *flags, "--resume", *early)
    assert (status, err.count("\n")) == (2, 1)
    assert "train on with --no_evaluation" in err
    status, out, _ = script("rsl_rl/train.py", *flags, "--resume", "--no_evaluation", "--max_iterations", 3)
    assert status == 0
    assert "continuing the episodes of iteration 2" in out
    status, _, err = script("rsl_rl/train.py", *flags, "--no_evaluation", "agent.evaluation.episodes=4")
    assert (status, err.count("\n")) == (2, 1)
    status, _, err = script("sb3/train.py", "--task", "Cartpole", "--no_evaluation")
    assert (status, err.count("\n")) == (2, 1)
    assert "'--no_evaluation'" in err
