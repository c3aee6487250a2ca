"""A run that is continued has the bits of one that never stopped: in this process and in another, after failures."""

import itertools
import os
import random
import subprocess
import sys
from pathlib import Path

import gymnasium as gym
import pytest
import torch

import lift_lab_tasks  # noqa: F401
from lift_lab.managers import RewardTermCfg
from lift_lab_rl.files import load_torch, save_torch
from lift_lab_rl.fingerprint import Fingerprint
from lift_lab_rl.rsl_rl import LiftLabRunner, RslRlVecEnvWrapper, to_rsl_rl
from lift_lab_rl.threads import use_one_torch_thread
from lift_lab_tasks.utils import load_cfg_from_registry, parse_env_cfg
from lift_lab_tasks.utils.runs import fingerprint

pytestmark = pytest.mark.usefixtures("one_torch_thread")

ENGINES = ["native", pytest.param("warp", marks=pytest.mark.slow)]
STEPS, NUM_ENVS, FAILING = 8, 8, 3


def action_in_a_row(env):
    """A reward whose buffers have the names of the project's own caches, and come into being late."""
    own = env.__dict__.setdefault("_cache", {})
    own["sum"] = own.get("sum", 0.0) * 0.9 + env.action_manager.action.mean(1)
    return own["sum"]


def make(engine, folder=None, fails=True, task="Cartpole", **settings):
    """A runner of a small task in which the physics of an environment fails in the last step of every iteration."""
    env_cfg = parse_env_cfg(task, "cpu", NUM_ENVS)
    env_cfg.seed, env_cfg.sim.physics, env_cfg.sim.num_threads = 4, engine, 1
    env_cfg.episode_length_s = 0.2
    env_cfg.rewards.row = RewardTermCfg(func=action_in_a_row, weight=0.1)
    agent_cfg = load_cfg_from_registry(task, "rsl_rl_cfg_entry_point")
    agent_cfg.num_steps_per_env, agent_cfg.save_interval, agent_cfg.device = STEPS, 1, "cpu"
    for name, value in settings.items():
        setattr(agent_cfg, name, value)
    same = fingerprint(env_cfg, agent_cfg)
    env = RslRlVecEnvWrapper(gym.make(task, cfg=env_cfg))
    if fails:
        step = env.step

        def failing_step(actions):
            inner = env.unwrapped
            if (inner.common_step_counter + 1) % STEPS == 0:
                inner.sim.physics.write("qvel", float("nan"), env_ids=[FAILING], cols=[0])
            return step(actions)

        env.step = failing_step
    plain = to_rsl_rl(agent_cfg, env.get_observations().keys())
    return LiftLabRunner(env, plain, folder, "cpu", same)


def resume(runner, checkpoint):
    """Go on from a checkpoint."""
    runner.load(str(checkpoint))
    said = runner.load_resume_state(checkpoint)
    assert said == f"continuing the episodes of iteration {runner.current_learning_iteration}"
    assert runner.continues_exactly


def ending(folder, iteration=4):
    """Bytes of the model, and the state beside it without the time that the training took."""
    state = load_torch(folder / f"resume_state_{iteration}.pt")
    state["logger"].pop("total_time_s")
    return (folder / f"model_{iteration}.pt").read_bytes(), state


def assert_same(found, expected, path=""):
    """Compare nested values bit by bit."""
    assert type(found) is type(expected), path
    if isinstance(found, torch.Tensor):
        assert (found.shape, found.dtype) == (expected.shape, expected.dtype), path
        assert found.numpy().tobytes() == expected.numpy().tobytes(), path
    elif isinstance(found, dict):
        assert found.keys() == expected.keys(), path
        for key in found:
            assert_same(found[key], expected[key], f"{path}.{key}")
    elif isinstance(found, (list, tuple)):
        assert len(found) == len(expected), path
        for k, pair in enumerate(zip(found, expected, strict=True)):
            assert_same(*pair, f"{path}[{k}]")
    else:
        assert found == expected or found != found, path


def failed(runner):
    """In which environments the physics failed in the last step."""
    mask = runner.env.unwrapped.physics_failed
    return [] if mask is None else mask.nonzero().flatten().tolist()


@pytest.mark.parametrize("engine", ENGINES)
def test_a_run_continues_bit_by_bit_after_a_failure_in_the_last_step(tmp_path, engine):
    whole = make(engine, tmp_path)
    assert whole.learn(4)
    assert failed(whole) == [FAILING]
    expected = ending(tmp_path)

    # in the process and with the runner that trained, as in a notebook
    resume(whole, tmp_path / "model_2.pt")
    assert failed(whole) == [FAILING]
    for name in ("model_3.pt", "model_4.pt", "resume_state_4.pt"):
        (tmp_path / name).unlink()
    assert whole.learn(2)
    assert_same(ending(tmp_path), expected)
    whole.env.close()

    # with another environment, which has seen other episodes
    other = make(engine, tmp_path / "other", fails=True)
    torch.manual_seed(99)
    other.learn(1)
    resume(other, tmp_path / "model_2.pt")
    assert other.learn(2)
    assert_same(ending(tmp_path / "other"), expected)
    other.env.close()

    # in another process
    code = "import test_exact_resume as test; test.main()"
    command = [sys.executable, "-c", code, engine, str(tmp_path / "model_2.pt"), str(tmp_path / "process")]
    here = Path(__file__).parent
    paths = os.pathsep.join([str(here), str(here.parents[1] / "source"), os.environ.get("PYTHONPATH", "")])
    subprocess.run(command, check=True, env=os.environ | {"PYTHONPATH": paths})
    assert_same(ending(tmp_path / "process"), expected)


def test_a_notebook_can_go_back_as_often_as_it_likes(tmp_path):
    runner = make("native", tmp_path, fails=False, task="Lift-Cube-Franka-CL")
    runner.learn(2)
    ends = []
    for _ in range(3):
        resume(runner, tmp_path / "model_1.pt")
        runner.learn(1)
        ends.append((tmp_path / "model_2.pt").read_bytes())
    assert ends[0] == ends[1] == ends[2]
    runner.env.close()


def test_without_a_state_a_runner_that_trained_starts_fresh_episodes(tmp_path):
    runner = make("native", tmp_path, fails=False)
    runner.learn(1)
    resume(runner, tmp_path / "model_1.pt")
    runner.learn(1)
    assert runner.env.unwrapped.episode_length_buf.any()
    (tmp_path / "resume_state_1.pt").unlink()
    runner.load(str(tmp_path / "model_1.pt"))
    said = runner.load_resume_state(tmp_path / "model_1.pt")
    assert said == "no resume_state_1.pt beside the checkpoint: starting fresh episodes"
    assert not runner.continues_exactly
    assert not runner.env.unwrapped.episode_length_buf.any()
    assert not runner.logger.state_dict()["episode_length"].any()
    runner.env.close()


class Smoothing(gym.Wrapper):
    """A user's wrapper: mixes actions with the last ones, and counts with what cannot be saved."""

    def __init__(self, env):
        super().__init__(env)
        self.last, self.count = 0.0, itertools.count()

    def step(self, action):
        self.last = 0.5 * self.last + 0.5 * action
        next(self.count)
        return self.env.step(self.last)


def test_the_state_of_wrappers_continues_and_what_cannot_be_saved_is_named(tmp_path, caplog):
    ends, lost = [], "Smoothing.count (itertools.count)"
    for counts in ([3], [2, 1]):
        folder = tmp_path / str(len(counts))
        for count in counts:
            env_cfg = parse_env_cfg("Cartpole", "cpu", NUM_ENVS)
            env_cfg.seed, env_cfg.sim.num_threads = 4, 1
            env = RslRlVecEnvWrapper(Smoothing(gym.make("Cartpole", cfg=env_cfg)))
            agent_cfg = load_cfg_from_registry("Cartpole", "rsl_rl_cfg_entry_point")
            agent_cfg.save_interval, agent_cfg.device = 1, "cpu"
            runner = LiftLabRunner(env, to_rsl_rl(agent_cfg, env.get_observations().keys()), folder, "cpu")
            if count == 1:
                runner.load(str(folder / "model_2.pt"))
                said = runner.load_resume_state(folder / "model_2.pt")
                assert said == f"continuing the episodes of iteration 2, except for {lost}, which could not be saved"
            caplog.clear()
            runner.learn(count)
            noted = [record.getMessage() for record in caplog.records if "cannot be saved" in record.getMessage()]
            assert noted == [f"a run that is continued will not have the state of {lost}: it cannot be saved"]
            env.close()
        ends.append((folder / "model_3.pt").read_bytes())
    assert ends[0] == ends[1]


# -- states of something else


def test_a_state_of_another_task_or_number_of_environments_changes_nothing(tmp_path, monkeypatch):
    lift = make("native", tmp_path / "lift", fails=False, task="Lift-Cube-Franka-CL")
    lift.learn(1)
    of_lift = load_torch(tmp_path / "lift" / "resume_state_1.pt")
    lift.env.close()
    runner = make("native", tmp_path, fails=False)
    runner.learn(1)
    state = load_torch(tmp_path / "resume_state_1.pt")
    inner = runner.env.unwrapped
    before = inner.sim.physics.field("qpos").clone()
    resets = []
    monkeypatch.setattr(runner.env, "reset", lambda: resets.append(inner.sim.physics.field("qpos").clone()))
    for changed, message in (
        (state | {"env": of_lift["env"]}, "physics"),
        (state | {"env": state["env"] | {"num_envs": 3}}, "has 3 environments, this run 8"),
        (state | {"env": state["env"] | {"objects": of_lift["env"]["objects"]}}, "is only in the "),
        (state | {"env": state["env"] | {"version": 1}}, "has the form of version 1, this is version 5"),
    ):
        save_torch(tmp_path / "resume_state_1.pt", changed)
        said = runner.load_resume_state(tmp_path / "model_1.pt")
        assert message in said
        assert said.endswith(": starting fresh episodes")
        assert "\n" not in said
        assert torch.equal(resets[-1], before)
    runner.env.close()


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda state: [1], "is no state of a training"),
        (lambda state: {}, "is no state of a training"),
        (lambda state: state | {"version": 1}, "has the form of version 1, this is version 3"),
        (lambda state: state | {"iteration": 3}, "it is of iteration 3"),
        (lambda state: state | {"env": None}, "it holds no environment"),
        (lambda state: state | {"env": {"version": 5, "num_envs": 8}}, "the saved state of the physics is not valid"),
        (lambda state: state | {"obs": {}}, "its observation groups are none"),
        (lambda state: state | {"obs": {"policy": torch.zeros(8, 3)}}, "'obs.policy' has to be a tensor of shape"),
        (lambda state: state | {"logger": {}}, "its curves are not those of this version"),
        (lambda state: state | {"logger": state["logger"] | {"returns": ["x"]}}, "'logger.returns' holds 'x'"),
        (lambda state: state | {"memory": []}, "it is of another number of networks"),
        (lambda state: state | {"memory": [torch.zeros(1, 2, 3), None]}, "the memory of its networks"),
        (lambda state: state | {"best": [1.0]}, "'best' has to be two numbers"),
        (lambda state: state | {"rng": state["rng"] | {"torch": torch.zeros(3, dtype=torch.uint8)}}, "RuntimeError"),
        (lambda state: state | {"rng": {}}, "KeyError"),
        (lambda state: state | {"total_steps": "many"}, "total_steps is no number"),
        (lambda state: {key: value for key, value in state.items() if key != "smoothed"}, "KeyError"),
    ],
)
def test_a_state_with_wrong_contents_means_fresh_episodes(trained, tmp_path, change, message):
    runner, folder = trained
    (tmp_path / "model_1.pt").write_bytes((folder / "model_1.pt").read_bytes())
    save_torch(tmp_path / "resume_state_1.pt", change(load_torch(folder / "resume_state_1.pt")))
    runner.load(str(tmp_path / "model_1.pt"))
    said = runner.load_resume_state(tmp_path / "model_1.pt")
    assert message in said
    assert said.endswith(": starting fresh episodes")
    assert "\n" not in said
    assert runner.learn(1)


def places(value, path=()):
    """Paths of all entries of nested containers."""
    for key in value if isinstance(value, dict) else range(len(value)) if isinstance(value, (list, tuple)) else ():
        yield (*path, key)
        yield from places(value[key], (*path, key))


def replaced(value, path, new):
    """Nested containers with another value in one place."""
    if not path:
        return new
    entries = dict(value) if isinstance(value, dict) else list(value)
    entries[path[0]] = replaced(value[path[0]], path[1:], new)
    return tuple(entries) if isinstance(value, tuple) else entries


def test_entries_of_a_wrong_type_are_one_line_each(trained, tmp_path):
    runner, folder = trained
    (tmp_path / "model_1.pt").write_bytes((folder / "model_1.pt").read_bytes())
    state, chance = load_torch(folder / "resume_state_1.pt"), random.Random(5)
    shallow = [path for path in places(state) if len(path) <= 3 and path[0] != "fingerprint"]
    deep = [path for path in places(state["env"], ("env",)) if len(path) > 3]
    refused = 0
    for path in [*chance.sample(shallow, 20), *chance.sample(deep, 30)]:
        new = chance.choice(["x", [], ("unknown",), ("object", "Other", {}), ("same", "nowhere"), torch.zeros(3, 5)])
        save_torch(tmp_path / "resume_state_1.pt", replaced(state, path, new))
        runner.load(str(tmp_path / "model_1.pt"))
        said = runner.load_resume_state(tmp_path / "model_1.pt")
        assert "\n" not in said, path
        assert len(said) < 600, path
        refused += said.endswith(": starting fresh episodes")
        if runner.continues_exactly:
            save_torch(tmp_path / "resume_state_1.pt", state)
            assert runner.load_resume_state(tmp_path / "model_1.pt") == "continuing the episodes of iteration 1"
    assert refused > 30


@pytest.fixture(scope="module")
def trained(tmp_path_factory):
    """A runner and the folder of its first iteration."""
    folder = tmp_path_factory.mktemp("run")
    runner = make("native", folder, fails=False)
    runner.learn(1)
    runner.log_dir = None
    yield runner, folder
    runner.env.close()


# -- settings


def test_a_setting_that_is_newer_than_the_saved_run_may_have_its_default(tmp_path):
    runner = make("native", tmp_path, fails=False)
    runner.learn(1)
    state = load_torch(tmp_path / "resume_state_1.pt")
    for name in ("env.events.reset_cart_position.min_step_count_between_reset", "agent.algorithm.mean_reg_coef"):
        assert state["fingerprint"].pop(name) is not None
    save_torch(tmp_path / "resume_state_1.pt", state)
    resume(runner, tmp_path / "model_1.pt")
    assert state["fingerprint"].pop("env.episode_length_s") == "0.2"  # not the default
    save_torch(tmp_path / "resume_state_1.pt", state)
    runner.load(str(tmp_path / "model_1.pt"))
    said = runner.load_resume_state(tmp_path / "model_1.pt")
    wanted = "the configuration differs from the saved run's (env.episode_length_s is 0.2, it was not there)"
    assert said == f"{wanted}: starting fresh episodes"
    runner.env.close()


def test_settings_that_do_not_matter_are_left_out_and_others_are_named():
    env_cfg, agent_cfg = (
        parse_env_cfg("Cartpole", "cpu", 4),
        load_cfg_from_registry("Cartpole", "rsl_rl_cfg_entry_point"),
    )
    before = fingerprint(env_cfg, agent_cfg)
    assert isinstance(before, Fingerprint)
    env_cfg.sim.num_threads, env_cfg.log_dir, agent_cfg.max_iterations = 7, "elsewhere", 9999
    env_cfg.viewer.eye, env_cfg.export_io_descriptors = (1.0, 2.0, 3.0), True
    mirror, env_cfg.mirror = env_cfg.mirror, None  # used with a symmetry_cfg only
    assert fingerprint(env_cfg, agent_cfg).difference(before.values) is None
    env_cfg.mirror = mirror
    older = {**before.values, "env.export_io_descriptors": "false"}  # a version to which it mattered
    assert fingerprint(env_cfg, agent_cfg).difference(older) is None
    env_cfg.decimation, agent_cfg.seed = 5, 1234
    found = fingerprint(env_cfg, agent_cfg).difference(before.values)
    was = before.values["agent.seed"]
    assert found == f"agent.seed is 1234, it was {was}, and 1 more differ"


def main():
    """The part of the test that runs in another process: continue a run for two iterations."""
    engine, checkpoint, folder = sys.argv[1], Path(sys.argv[2]), Path(sys.argv[3])
    use_one_torch_thread()
    runner = make(engine, folder)
    resume(runner, checkpoint)
    assert runner.learn(2)
    runner.env.close()
