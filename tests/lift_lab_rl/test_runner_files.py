"""Checkpoints are whole or absent, and runs are reproducible and continue where they were."""

import errno
import filecmp
import os
import signal
import threading
from pathlib import Path

import pytest
import torch
from point_task import AgentCfg, PointEnv, train

from lift_lab.utils.errors import ConfigError, FileError
from lift_lab_rl import distributed
from lift_lab_rl.files import load_torch, save_torch
from lift_lab_rl.rsl_rl import LiftLabRunner, RslRlPpoActorCriticRecurrentCfg, RslRlRndCfg, saving, to_rsl_rl
from lift_lab_rl.rsl_rl.best_policy import BEST
from lift_lab_rl.rsl_rl.run_files import checkpoint_iteration
from lift_lab_rl.study.curves import read_scalars

# -- files


def test_a_crash_between_writing_and_moving_leaves_the_old_file_whole(tmp_path, monkeypatch):
    path = tmp_path / "model.pt"
    save_torch(path, {"x": torch.zeros(3)})

    def crash(*_):
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr(os, "replace", crash)
        with pytest.raises(KeyboardInterrupt):
            save_torch(path, {"x": torch.ones(1000)})
    assert torch.equal(load_torch(path)["x"], torch.zeros(3))
    assert [entry.name for entry in tmp_path.iterdir()] == ["model.pt"]


def test_equal_content_gives_equal_bytes_under_any_name(tmp_path):
    content = {"a": torch.arange(5.0), "b": [1, 2.5]}
    save_torch(tmp_path / "one.pt", content)
    save_torch(tmp_path / "another_name.pt", content)
    assert filecmp.cmp(tmp_path / "one.pt", tmp_path / "another_name.pt", shallow=False)


@pytest.mark.parametrize("content", [b"", b"not a model", b"PK\x03\x04 half a zip"])
def test_a_broken_checkpoint_is_named_in_one_line(tmp_path, content):
    path = tmp_path / "model_3.pt"
    path.write_bytes(content)
    with pytest.raises(FileError, match=r"model_3\.pt") as caught:
        load_torch(path)
    assert "\n" not in str(caught.value)


def test_a_missing_checkpoint_is_named(tmp_path):
    with pytest.raises(FileError, match="no file"):
        load_torch(tmp_path / "model_7.pt")


def test_a_checkpoint_with_code_in_it_is_refused(tmp_path):
    path = tmp_path / "model_1.pt"
    torch.save({"run": print}, path)
    with pytest.raises(FileError, match=r"model_1\.pt"):
        load_torch(path)


def test_a_file_without_iterations_is_no_checkpoint(tmp_path):
    save_torch(tmp_path / "resume_state_4.pt", {"rng": torch.zeros(1)})
    with pytest.raises(ConfigError, match=r"resume_state_4.pt' is no checkpoint of a training"):
        checkpoint_iteration(tmp_path / "resume_state_4.pt")


# -- the loop


def test_checkpoints_are_numbered_by_finished_iterations(tmp_path):
    runner, finished = train(tmp_path, iterations=5)
    assert finished
    assert runner.current_learning_iteration == 5
    assert {f.name for f in tmp_path.glob("model_?.pt")} == {"model_2.pt", "model_4.pt", "model_5.pt"}
    assert load_torch(tmp_path / "model_4.pt")["iter"] == 4


def test_only_the_newest_resume_states_are_kept(tmp_path):
    cfg = AgentCfg(save_interval=1, keep_resume_states=2)
    train(tmp_path, iterations=5, cfg=cfg)
    assert {f.name for f in tmp_path.glob("resume_state_*")} == {"resume_state_4.pt", "resume_state_5.pt"}


def test_two_runs_of_a_seed_and_any_number_of_threads_write_the_same_bytes(tmp_path):
    for name, threads in (("a", 1), ("b", 1), ("c", 2)):
        train(tmp_path / name, threads=threads)
    first, *others = [tmp_path / name / "model_4.pt" for name in "abc"]
    assert [filecmp.cmp(first, other, shallow=False) for other in others] == [True, True]


def test_saving_a_loaded_checkpoint_gives_the_same_bytes(tmp_path):
    train(tmp_path / "a")
    torch.manual_seed(99)
    runner = LiftLabRunner(PointEnv(), to_rsl_rl(AgentCfg()))
    runner.load(str(tmp_path / "a" / "model_4.pt"))
    runner.save(str(tmp_path / "again.pt"))
    assert filecmp.cmp(tmp_path / "again.pt", tmp_path / "a" / "model_4.pt", shallow=False)


def test_a_checkpoint_of_other_networks_is_refused_in_one_line(tmp_path):
    train(tmp_path, iterations=2)
    cfg = AgentCfg()
    cfg.policy.actor_hidden_dims = [4]
    runner = LiftLabRunner(PointEnv(), to_rsl_rl(cfg))
    with pytest.raises(ConfigError, match="does not fit") as caught:
        runner.load(str(tmp_path / "model_2.pt"))
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_ends_the_run_after_its_iteration_with_a_checkpoint(tmp_path, number):
    steps = []

    def on_step(step):
        steps.append(step)
        if step == 20:  # within the third iteration of 8 steps
            os.kill(os.getpid(), number)

    before = signal.getsignal(number)
    runner, finished = train(tmp_path, iterations=50, on_step=on_step)
    assert not finished
    assert len(steps) == 24
    assert load_torch(tmp_path / "model_3.pt")["iter"] == runner.current_learning_iteration == 3
    assert signal.getsignal(number) is before


def test_a_run_in_another_thread_leaves_signals_alone(tmp_path):
    thread = threading.Thread(target=train, args=(tmp_path, 2))
    thread.start()
    thread.join()
    assert (tmp_path / "model_2.pt").is_file()


def test_curves_hold_every_iteration_and_the_figures_of_the_paper(tmp_path):
    from tensorboard.backend.event_processing.event_accumulator import EventAccumulator

    train(tmp_path, iterations=4)
    events = EventAccumulator(str(tmp_path), size_guidance={"scalars": 0})
    events.Reload()
    tags = set(events.Tags()["scalars"])
    assert [e.step for e in events.Scalars("Loss/surrogate")] == [1, 2, 3, 4]
    kinds = ("step_reward", "reward", "episode_length")
    spread = [f"Train/{statistic}_{kind}" for kind in kinds for statistic in ("mean", "max", "min")]
    assert {*spread, "Loss/entropy", "Loss/value", "Loss/learning_rate", "Policy/mean_std"} <= tags
    assert {"Metrics/success", "Perf/total_fps"} <= tags


class LogsItsReset(PointEnv):
    """Keeps its last log until the next end of an episode, and begins with one of no episode."""

    def __init__(self):
        super().__init__()
        self.log = {"Metrics/success": torch.tensor(0.5)}

    def step(self, actions):
        obs, reward, done, extras = super().step(actions)
        self.log = extras["log"] or self.log
        return obs, reward, done, extras | {"log": self.log}


def test_a_log_of_no_episode_is_not_counted(monkeypatch):
    torch.manual_seed(5)
    runner = LiftLabRunner(LogsItsReset(), to_rsl_rl(AgentCfg()))
    terms = []
    monkeypatch.setattr(runner.best, "update", lambda report, save: terms.append(report.terms))
    runner.learn(3)  # of 8 steps each; all episodes have 20
    success = runner.env.log["Metrics/success"].item()
    assert terms == [{}, {}, {"Metrics/success": pytest.approx(success)}]


class CountsItsLog(PointEnv):
    """Two episodes end in step 2, three in step 4; one and all of them are behind ``Metrics/some``."""

    def step(self, actions):
        obs, reward, done, extras = super().step(actions)
        ended = {2: 2, 4: 3}.get(self.steps, 0)
        done = (torch.arange(self.num_envs) < ended).long()
        log = {"Metrics/some": float(self.steps), "Metrics/all": float(self.steps)} if ended else {}
        return obs, reward, done, extras | {"log": log, "log_counts": {"Metrics/some": {2: 1}.get(self.steps, ended)}}


def test_means_over_some_of_the_episodes_weigh_as_many(monkeypatch):
    runner = LiftLabRunner(CountsItsLog(), to_rsl_rl(AgentCfg()))
    terms = []
    monkeypatch.setattr(runner.best, "update", lambda report, save: terms.append(report.terms))
    runner.learn(1)
    assert terms == [{"Metrics/some": (1 * 2 + 3 * 4) / 4, "Metrics/all": (2 * 2 + 3 * 4) / 5}]


# -- continuing


def resumed(folder, cfg=None, env=None, log_dir=None, iteration=4, **settings):
    """A runner that loaded a checkpoint, and what it said of the state beside it."""
    runner = LiftLabRunner(env or PointEnv(), to_rsl_rl(cfg or AgentCfg()), log_dir, **settings)
    path = folder / f"model_{iteration}.pt"
    runner.load(str(path))
    return runner, runner.load_resume_state(path)


def test_the_steps_of_a_run_are_counted_also_with_another_number_of_environments(tmp_path):
    train(tmp_path)
    runner, said = resumed(tmp_path, env=PointEnv(4), fingerprint="other")
    assert said == "the configuration differs from the saved run's: starting fresh episodes"
    runner.learn(1)
    assert runner.total_steps == 4 * 8 * 32 + 8 * 4
    (tmp_path / "resume_state_4.pt").unlink()
    runner, said = resumed(tmp_path, env=PointEnv(4))
    assert said == "no resume_state_4.pt beside the checkpoint: starting fresh episodes"
    runner.learn(1)
    assert runner.total_steps == 5 * 8 * 4


def test_a_broken_state_leaves_the_checkpoint_its_use(tmp_path):
    train(tmp_path)
    path = tmp_path / "resume_state_4.pt"
    path.write_bytes(path.read_bytes()[:1000])
    runner, said = resumed(tmp_path)
    assert said.startswith(f"cannot read '{path}'")
    assert said.endswith(": starting fresh episodes")
    assert runner.learn(1)


def test_no_process_continues_where_another_cannot(tmp_path, monkeypatch):
    train(tmp_path)
    told = []
    monkeypatch.setattr(distributed, "first_problem", lambda problem: told.append(problem) or "no rank1_state_4.pt")
    runner, said = resumed(tmp_path)
    assert said == "no rank1_state_4.pt: starting fresh episodes"
    assert told == [None]
    assert not runner.continues_exactly


def test_a_disk_that_is_too_full_for_the_state_still_gets_the_model(tmp_path, monkeypatch):
    replace = os.replace

    def full(source, target):
        if Path(target).name.startswith("resume_state"):
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        replace(source, target)

    monkeypatch.setattr(os, "replace", full)
    monkeypatch.setattr(saving, "LAST_TRIES_S", ())
    with pytest.raises(FileError, match=r"cannot write '.*resume_state_4\.pt': No space left on device"):
        train(tmp_path)
    for done in (2, 3, 4):  # it was tried again after each iteration
        assert checkpoint_iteration(tmp_path / f"model_{done}.pt") == done


@pytest.mark.parametrize("there", ["older", "newer", "broken", "none"])
def test_the_best_policy_to_beat_is_one_that_there_is(tmp_path, there):
    runner, _ = train(tmp_path / "before")
    runner.best.rank = (0.5, 1.0)
    save_torch(tmp_path / "before" / "resume_state_4.pt", runner.resume_state())
    best = tmp_path / "before" / BEST
    if there == "broken":
        best.write_bytes(b"no model")
    elif there != "none":
        save_torch(best, {"iter": {"older": 3, "newer": 5}[there]})
    after, _ = resumed(tmp_path / "before", log_dir=tmp_path / "after")
    assert after.best.rank == ((0.5, 1.0) if there == "older" else None)
    assert (tmp_path / "after" / BEST).is_file() == (there == "older")


@pytest.mark.parametrize("kind", ["gru", "lstm"])
def test_the_memory_of_recurrent_networks_continues_with_the_episodes(tmp_path, kind):
    cfg = AgentCfg()
    settings = {k: v for k, v in vars(cfg.policy).items() if k != "class_name"}
    cfg.policy = RslRlPpoActorCriticRecurrentCfg(**settings, rnn_type=kind, rnn_hidden_dim=6, rnn_num_layers=1)
    before, _ = train(tmp_path, cfg=cfg)
    after = LiftLabRunner(PointEnv(), to_rsl_rl(cfg))
    after.load(str(tmp_path / "model_4.pt"))
    assert "continuing the episodes" in after.load_resume_state(tmp_path / "model_4.pt")
    for network in ("actor", "critic"):
        ours, theirs = (getattr(runner.alg, network).get_hidden_state() for runner in (after, before))
        pairs = zip(ours, theirs, strict=True) if kind == "lstm" else [(ours, theirs)]
        assert all(torch.equal(a, b) and b.any() for a, b in pairs)
    assert after.learn(1)


def test_the_schedule_of_curiosity_continues_where_it_was(tmp_path):
    cfg = AgentCfg()
    schedule = RslRlRndCfg.LinearWeightScheduleCfg(initial_step=0, final_step=100, final_value=0.0)
    cfg.algorithm.rnd_cfg = RslRlRndCfg(weight=1.0, weight_schedule=schedule, num_outputs=4)
    cfg.obs_groups = {"policy": ["policy"], "rnd_state": ["policy"]}
    before, _ = train(tmp_path, cfg=cfg)
    after = LiftLabRunner(PointEnv(), to_rsl_rl(cfg))
    after.load(str(tmp_path / "model_4.pt"))
    assert after.alg.rnd.update_counter == before.alg.rnd.update_counter == 32
    assert after.alg.rnd.weight == before.alg.rnd.weight < 0.02  # of a step of 0.02 s


class NotesReturns(PointEnv):
    """Notes the sums of rewards of its episodes in the order in which they end."""

    def __init__(self):
        super().__init__()
        self.sums, self.returns = torch.zeros(self.num_envs), []

    def step(self, actions):
        obs, reward, done, extras = super().step(actions)
        self.sums += reward
        self.returns += self.sums[done > 0].tolist()
        self.sums[done > 0] = 0.0
        return obs, reward, done, extras


def test_curves_tell_the_environments_rewards_from_those_of_curiosity(tmp_path):
    cfg, env = AgentCfg(), NotesReturns()
    cfg.algorithm.rnd_cfg = RslRlRndCfg(weight=1.0, num_outputs=4)
    cfg.obs_groups = {"policy": ["policy"], "rnd_state": ["policy"]}
    LiftLabRunner(env, to_rsl_rl(cfg), log_dir=tmp_path).learn(12)
    ends = {tag: values[-1] for tag, (_, values) in read_scalars(tmp_path).items()}
    assert len(env.returns) > 100
    assert ends["Rnd/mean_extrinsic_reward"] == pytest.approx(sum(env.returns[-100:]) / 100, rel=1e-4)
    assert ends["Rnd/mean_intrinsic_reward"] > 0.0
    total = ends["Rnd/mean_extrinsic_reward"] + ends["Rnd/mean_intrinsic_reward"]
    assert ends["Train/mean_reward"] == pytest.approx(total, rel=1e-5)


def test_the_scale_of_curious_rewards_continues_where_it_was(tmp_path):
    cfg = AgentCfg()
    cfg.algorithm.rnd_cfg = RslRlRndCfg(weight=1.0, num_outputs=4, reward_normalization=True)
    cfg.obs_groups = {"policy": ["policy"], "rnd_state": ["policy"]}
    before, _ = train(tmp_path, cfg=cfg)
    after, said = resumed(tmp_path, cfg)
    assert said == "continuing the episodes of iteration 4"
    ours, theirs = (runner.alg.rnd.reward_normalizer.disc_avg.avg for runner in (after, before))
    assert theirs.shape == (32,)
    assert torch.equal(ours, theirs)
