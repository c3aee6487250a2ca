"""A disk that is full for a while costs warnings, and neither the training nor a point of its curves."""

import contextlib
import resource
import signal
import subprocess
import sys

import pytest
import torch
from point_task import AgentCfg, PointEnv, train
from tensorboard.backend.event_processing.event_accumulator import EventAccumulator

from lift_lab.utils.errors import FileError
from lift_lab.utils.io import dump_yaml, load_yaml, remove_dead_temporaries, temporary_path
from lift_lab_rl.files import load_torch, save_torch
from lift_lab_rl.rsl_rl import LiftLabRunner, curve_files, saving, to_rsl_rl
from lift_lab_rl.rsl_rl.curve_files import CurveWriter
from lift_lab_rl.rsl_rl.saving import CheckpointSaver
from lift_lab_tasks.utils import runs


@contextlib.contextmanager
def room_for(size):
    """No file may become larger: the kernel writes what fits and then refuses, as on a full disk. `size` in bytes."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)


def points(folder, tag):
    """(iteration, value) of a curve."""
    events = EventAccumulator(str(folder), size_guidance={"scalars": 0})
    events.Reload()
    return [(event.step, event.value) for event in events.Scalars(tag)]


# -- curves


def test_curves_have_every_point_after_the_disk_was_full(tmp_path, capsys):
    writer = CurveWriter(str(tmp_path))
    for step in range(30):
        writer.add_scalar("a/b", step * 0.5, step)
        with room_for(500 if 5 <= step < 20 else resource.RLIM_INFINITY):
            writer.flush()
        if step == 12:  # whoever reads meanwhile finds whole records
            written = points(tmp_path, "a/b")
            assert 5 <= len(written) < 12
            assert written == [(k, k * 0.5) for k in range(len(written))]
    writer.close()
    assert points(tmp_path, "a/b") == [(k, k * 0.5) for k in range(30)]
    assert len(list(tmp_path.iterdir())) == 1
    warned = capsys.readouterr().err.splitlines()
    assert len(warned) == 1
    assert "File too large; the training goes on" in warned[0]


def test_points_that_never_fit_are_counted(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(curve_files, "MOST_WAITING", 10)
    with room_for(0):
        writer = CurveWriter(str(tmp_path))
        for step in range(25):
            writer.add_scalar("a", 1.0, step)
            writer.flush()
        writer.close()
    assert capsys.readouterr().err.splitlines()[-1].startswith("warning: 26 points of curves are missing in")


def test_a_folder_that_is_gone_costs_curves_only(tmp_path, capsys):
    (tmp_path / "file").touch()
    writer = CurveWriter(str(tmp_path / "file" / "run"))
    writer.add_scalar("a", 1.0, 1)
    writer.flush()
    writer.close()
    assert "Not a directory" in capsys.readouterr().err


# -- checkpoints


def trained(folder, full=range(0), iterations=8):
    """Train with a disk that is full in some iterations; what the runner was."""
    torch.manual_seed(7)
    runner = LiftLabRunner(PointEnv(), to_rsl_rl(AgentCfg()), folder)
    with contextlib.ExitStack() as stack:

        def on_iteration(done):
            stack.close()
            if done in full:
                stack.enter_context(room_for(1000))

        assert runner.learn(iterations, on_iteration=on_iteration)
    return runner


def test_a_checkpoint_that_does_not_fit_is_written_after_a_later_iteration(tmp_path, capsys):
    trained(tmp_path / "whole")
    capsys.readouterr()
    trained(tmp_path / "full", full=range(3, 7))
    warnings = capsys.readouterr().err.splitlines()
    assert {path.name for path in (tmp_path / "full").glob("model_?.pt")} == {"model_2.pt", "model_7.pt", "model_8.pt"}
    assert [path.name for path in (tmp_path / "full").glob(".*")] == []
    same = [load_torch(tmp_path / run / "model_8.pt") for run in ("whole", "full")]
    assert str(same[0]) == str(same[1])
    assert sum("trying again after each iteration" in line for line in warnings) == 1
    assert warnings[-1] == "checkpoints are written again"
    assert [step for step, _ in points(tmp_path / "full", "Loss/value")] == list(range(1, 9))


class Disk:
    """Saves that fail a number of times."""

    def __init__(self, failures):
        self.failures, self.calls, self.slept = failures, 0, []

    def save(self):
        self.calls += 1
        if self.calls <= self.failures:
            raise FileError("cannot write 'model.pt': No space left on device")


@pytest.fixture
def saver(monkeypatch):
    """Makes a saver on a disk with so many failures; time does not pass."""

    def make(failures):
        disk = Disk(failures)
        monkeypatch.setattr(saving.time, "sleep", disk.slept.append)
        return CheckpointSaver(disk.save, 10), disk

    return make


def test_after_a_failure_every_iteration_tries(saver):
    saver, disk = saver(2)
    for done in range(8, 15):
        saver.after_iteration(done, 100, None)
    assert disk.calls == 3  # at 10 and 11 in vain, at 12


def test_the_last_checkpoint_is_waited_for_and_then_missed_in_one_line(saver, capsys):
    one, disk = saver(3)
    assert one.after_iteration(100, 100, None)
    assert disk.slept == [1.0, 2.0, 4.0]
    two, disk = saver(99)
    with pytest.raises(FileError, match=r"No space left on device \(after iteration 100, tried for 60 s\)"):
        two.after_iteration(100, 100, None)
    assert sum(disk.slept) == 60.0


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_user_who_stops_a_training_does_not_wait_long(saver, number):
    saver, disk = saver(99)
    with pytest.raises(FileError, match="after iteration 7, tried for 7 s"):
        saver.after_iteration(7, 100, number)
    assert sum(disk.slept) == 7.0


def test_a_training_without_a_terminal_goes_on_until_it_is_saved(saver):
    saver, disk = saver(2)
    assert [saver.after_iteration(done, 100, signal.SIGHUP) for done in (7, 8, 9)] == [False, False, True]
    assert disk.slept == []


def test_a_best_policy_that_does_not_fit_is_tried_again_with_the_next(tmp_path, capsys):
    torch.manual_seed(7)
    runner = LiftLabRunner(PointEnv(), to_rsl_rl(AgentCfg()), tmp_path)
    with room_for(1000), pytest.raises(FileError):
        runner.save(str(tmp_path / "model_best.pt"))
    runner.best.is_new = lambda _: True
    runner.best.rank = (0.5, 1.0)
    report = type("Report", (), {"terms": {}, "iteration": 10, "mean_reward": 1.0, "success": None})()
    with room_for(1000):
        runner.best.update(report, lambda: runner.save(str(tmp_path / "model_best.pt")))
    assert runner.best.rank == (0.5, 1.0)
    assert "tried again with the next better policy" in capsys.readouterr().err
    runner.best.update(report, lambda: runner.save(str(tmp_path / "model_best.pt")))
    assert (tmp_path / "model_best.pt").is_file()


# -- other files


def test_settings_are_whole_or_as_before(tmp_path):
    path = tmp_path / "params" / "env.yaml"
    dump_yaml(path, {"a": 1})
    with room_for(100), pytest.raises(FileError, match=r"cannot write '.*env\.yaml': File too large"):
        dump_yaml(path, {"a": "x" * 5000})
    assert load_yaml(path) == {"a": 1}
    assert [entry.name for entry in path.parent.iterdir()] == ["env.yaml"]


def test_half_written_files_of_dead_processes_are_removed(tmp_path):
    folder = tmp_path / "run" / "params"
    folder.mkdir(parents=True)
    code = "import sys; from pathlib import Path; from lift_lab.utils.io import temporary_path as t\n"
    code += "for name in sys.argv[1:]: t(Path(name)).write_text('half')"
    subprocess.run([sys.executable, "-c", code, folder / "env.yaml", folder.parent / "model_3.pt"], check=True)
    own = temporary_path(folder / "agent.yaml")
    foreign = folder / ".agent.yaml.another-host-1.tmp"
    others = [own, foreign, folder / "env.yaml", folder / ".hidden", folder / ".name.tmp"]
    for path in others:
        path.touch()
    assert len(remove_dead_temporaries(tmp_path)) == 2
    assert sorted(path for path in tmp_path.rglob("*") if path.is_file()) == sorted(others)


def test_a_new_run_removes_what_a_killed_one_left(tmp_path):
    left = tmp_path / "2026-01-01" / temporary_path(tmp_path / "model_3.pt").name.replace("-", "-9999999", 1)
    left.parent.mkdir()
    left.touch()
    (left.parent / "model_2.pt").touch()
    runs.make_run_dir(tmp_path, "again")
    assert [path.name for path in left.parent.iterdir()] == ["model_2.pt"]


# -- damaged runs


def agent_cfg():
    return type("Cfg", (), {"experiment_name": "point"})()


@pytest.fixture
def experiment(tmp_path, monkeypatch):
    """Two trained runs; the folder of their experiment."""
    monkeypatch.chdir(tmp_path)
    folder = runs.experiment_dir(agent_cfg())
    for name in ("2026-01-01", "2026-01-02"):
        train(folder / name, iterations=4)
    return folder


def found(say, wanted="latest", task=None):
    path = runs.find_checkpoint(agent_cfg(), wanted, task=task, say=say)
    return f"{path.parent.name}/{path.name}"


@pytest.mark.parametrize("wanted", ["latest", r"model_\d+\.pt"])  # the second is what agents are configured with
def test_latest_skips_damaged_files_with_one_line_a_run(experiment, wanted):
    said = []
    assert found(said.append, wanted) == "2026-01-02/model_4.pt"
    assert said == []
    newest = experiment / "2026-01-02"
    (newest / "model_4.pt").write_bytes((newest / "model_4.pt").read_bytes()[:-100])
    assert found(said.append, wanted) == "2026-01-02/model_2.pt"
    assert len(said) == 1
    assert said[0].startswith("warning: skipped, in run '2026-01-02': cannot read '")
    save_torch(newest / "model_2.pt", {"iter": "two"})
    said.clear()
    assert found(said.append, wanted) == "2026-01-01/model_4.pt"
    assert len(said) == 1
    with pytest.raises(FileError, match="model_4"):  # a file that the user names is not replaced by another
        load_torch(runs.find_checkpoint(agent_cfg(), str(newest / "model_4.pt")))
    assert runs.find_checkpoint(agent_cfg(), "model_4.pt") == newest / "model_4.pt"


@pytest.mark.parametrize("content", [b"a: [", b"\xff\xfe\x00", b"- 1"])
def test_a_run_whose_settings_are_damaged_is_skipped(experiment, content):
    said = []
    (experiment / "2026-01-02" / "params").mkdir()
    (experiment / "2026-01-02" / "params" / "run.yaml").write_bytes(content)
    for task in (None, "Point"):
        assert found(said.append, task=task) == "2026-01-01/model_4.pt"
    assert len(said) == 2
    assert "run.yaml" in said[0]


def test_without_any_whole_checkpoint_it_says_so(experiment):
    for path in experiment.glob("*/model_*.pt"):
        path.write_bytes(b"")
    with pytest.raises(FileError, match=r"every checkpoint in '.*point' that matches .* is damaged"):
        found([].append)
