"""Folders of runs: one for each run, and found again whatever they are called."""

from concurrent.futures import ThreadPoolExecutor
from types import SimpleNamespace

import pytest

from lift_lab.utils.errors import ConfigError, FileError
from lift_lab_tasks.utils import runs
from lift_lab_tasks.utils.library_runs import find_model


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
    empty, used = runs.new_run_dir(agent("a")), runs.new_run_dir(agent("b"))
    (used / "model_1.pt").touch()
    runs.discard_if_empty(empty)
    runs.discard_if_empty(used)
    assert not empty.exists()
    assert used.exists()


def test_a_folder_that_cannot_be_made_is_named(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(ConfigError, match="'a/b' cannot be part of a folder's name"):
        runs.new_run_dir(agent("a/b"))
    (tmp_path / "logs").touch()
    with pytest.raises(FileError, match="logs"):
        runs.new_run_dir(agent())


@pytest.mark.parametrize("name", ["2026-01-01_lr=1e-3+x", "2026-01-01_(a)"])
def test_the_folder_of_a_run_is_a_path_and_no_expression(tmp_path, monkeypatch, name):
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
    assert find_model(tmp_path, None, None, *patterns) == tmp_path / "2026-01-02" / "model_5_steps.zip"
    (tmp_path / "2026-01-02" / "model.zip").touch()
    assert find_model(tmp_path, None, None, *patterns) == tmp_path / "2026-01-02" / "model.zip"
    assert find_model(tmp_path, None, "2026-01-01", *patterns) == tmp_path / "2026-01-01" / "model.zip"
