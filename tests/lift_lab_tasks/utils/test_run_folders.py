"""Folders of runs: one for each run, and found again whatever they are called."""

from concurrent.futures import ThreadPoolExecutor
from types import SimpleNamespace

import pytest

from lift_lab.utils.errors import ConfigError, FileError
from lift_lab_tasks.utils import runs


@pytest.fixture
def any_content(monkeypatch):
    """Takes empty files for checkpoints."""
    monkeypatch.setattr("lift_lab_rl.rsl_rl.run_files.read_checkpoint", lambda _: {"iter": 1})


def agent(name=""):
    return SimpleNamespace(experiment_name="lift", run_name=name)


def test_runs_that_start_in_the_same_second_get_a_folder_each(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(runs.time, "strftime", lambda _: "2026-01-02_03-04-05")
    with ThreadPoolExecutor(4) as pool:
        folders = list(pool.map(lambda _: runs.new_run_dir(agent("try")), range(8)))
    names = {"2026-01-02_03-04-05_try", *(f"2026-01-02_03-04-05_try-{i}" for i in range(2, 9))}
    assert {folder.name for folder in folders} == names
    assert all(folder.is_dir() for folder in folders)


def test_what_wrote_nothing_leaves_no_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    empty, used, refused = (runs.new_run_dir(agent(name)) for name in "abc")
    for run in (empty, used):
        (run / "params").mkdir()
        (run / "params" / "env.yaml").touch()
    (used / "model_1.pt").touch()
    (refused / "events.out.tfevents.1").touch()  # skrl opens its log before it looks at its settings
    for run in (empty, used, refused):
        runs.discard_unused(run)
    assert not empty.exists()
    assert not refused.exists()
    assert used.exists()


def test_a_folder_that_cannot_be_made_is_named(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(ConfigError, match="'a/b' cannot be part of a folder's name"):
        runs.new_run_dir(agent("a/b"))
    (tmp_path / "logs").touch()
    with pytest.raises(FileError, match="logs"):
        runs.new_run_dir(agent())


@pytest.mark.parametrize("name", ["2026-01-01_lr=1e-3+x", "2026-01-01_(a)"])
def test_the_folder_of_a_run_is_a_path_and_no_expression(tmp_path, monkeypatch, any_content, name):
    (tmp_path / name).mkdir()
    (tmp_path / name / "model_3.pt").touch()
    assert runs.find_checkpoint(agent(), str(tmp_path / name)).parent.name == name
    monkeypatch.chdir(tmp_path / name)
    assert runs.find_checkpoint(agent(), ".").name == "model_3.pt"


def test_of_the_newest_run_the_best_file_it_has_is_taken(tmp_path):
    for run, names in {"2026-01-01": ["model.zip"], "2026-01-02": ["model_5_steps.zip"], "2026-01-03": []}.items():
        (tmp_path / run).mkdir()
        for name in names:
            (tmp_path / run / name).touch()
    patterns = (r"model\.zip", r"model_\d+_steps\.zip")
    assert runs.find_model(tmp_path, None, None, *patterns) == tmp_path / "2026-01-02" / "model_5_steps.zip"
    (tmp_path / "2026-01-02" / "model.zip").touch()
    assert runs.find_model(tmp_path, None, None, *patterns) == tmp_path / "2026-01-02" / "model.zip"
    assert runs.find_model(tmp_path, None, "2026-01-01", *patterns) == tmp_path / "2026-01-01" / "model.zip"


def of_task(folder, task, *files):
    """A run of a task with empty checkpoints."""
    (folder / "params").mkdir(parents=True)
    (folder / "params" / "run.yaml").write_text(f"task: {task}\noverrides: []\n")
    for name in files:
        (folder / name).touch()


def test_of_tasks_that_share_an_experiment_each_finds_its_own_runs_first(tmp_path, monkeypatch, any_content):
    monkeypatch.chdir(tmp_path)
    folder = runs.experiment_dir(agent())
    of_task(folder / "2026-01-01", "Lift", "model_5.pt")
    of_task(folder / "2026-01-02", "my_tasks:Lift-CL-Play", "model_7.pt", "model_best.pt")
    of_task(folder / "2026-01-03", "Lift-Soft", "model_5.pt")

    def found(wanted, task, run=None):
        path = runs.find_checkpoint(agent(), wanted, run, task)
        return f"{path.parent.name}/{path.name}"

    assert found(None, "Lift-Play") == "2026-01-01/model_5.pt"
    assert found("latest", "Lift-CL") == "2026-01-02/model_7.pt"
    assert found("model_5.pt", "Lift") == "2026-01-01/model_5.pt"
    assert found("model_5.pt", "Lift-CL") == "2026-01-03/model_5.pt"  # none of its own has it
    assert found("best", "Lift") == "2026-01-02/model_best.pt"
    assert found(None, "Lift", ".*-03") == "2026-01-03/model_5.pt"
    assert found(None, "Reach") == found(None, None) == "2026-01-03/model_5.pt"


def test_a_checkpoint_of_another_task_is_noted_in_one_line(tmp_path):
    of_task(tmp_path / "a", "Lift-CL-Play", "model_5.pt")
    (tmp_path / "b").mkdir()
    said = []
    for task in ("Lift-CL", "my_tasks:Lift-CL-Play", "Lift"):
        runs.note_other_task(tmp_path / "a" / "model_5.pt", task, said.append)
    runs.note_other_task(tmp_path / "b" / "model_5.pt", "Lift", said.append)  # its folder says nothing
    assert said == [f"'{tmp_path / 'a' / 'model_5.pt'}' was trained on Lift-CL"]


def test_a_folder_without_checkpoints_is_not_the_one_that_lacks_one(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(FileError, match="no checkpoint 'Pretrained'; did you mean 'pretrained'"):
        runs.find_checkpoint(agent(), "Pretrained", task="Lift")
    folder = runs.experiment_dir(agent())
    of_task(folder / "2026-01-01", "Lift", "model_8.pt")
    (folder / "pretrained" / "exported").mkdir(parents=True)
    with pytest.raises(FileError, match=r"no checkpoint in '.*2026-01-01' matches .*; did you mean 'model_8\.pt'"):
        runs.find_checkpoint(agent(), "model_9.pt", task="Lift")
    with pytest.raises(FileError, match="no checkpoint 'bset'; did you mean 'best'"):
        runs.find_checkpoint(agent(), "bset", task="Lift")
