"""Tasks that a module of the user's registers, by ``MODULE:ID``."""

import sys

import gymnasium as gym
import pytest

from lift_lab.utils.errors import NotFoundError
from lift_lab_cli.list_envs import tasks_of
from lift_lab_tasks.utils import import_user_module, parse_env_cfg, task_kwargs

REGISTER = """
import gymnasium as gym

gym.register(
    id="Own-Pole",
    entry_point="lift_lab.envs:ManagerBasedRLEnv",
    kwargs={"env_cfg_entry_point": "own_tasks.settings:OwnEnvCfg"},
)
"""
SETTINGS = """
from lift_lab.utils import configclass
from lift_lab_tasks.manager_based.classic.cartpole.cartpole_env_cfg import CartpoleEnvCfg


@configclass
class OwnEnvCfg(CartpoleEnvCfg):
    def __post_init__(self):
        super().__post_init__()
        self.episode_length_s = 1.25
"""


@pytest.fixture(autouse=True)
def place(tmp_path, monkeypatch):
    """The current folder: it has a package of tasks and is not on the module path."""
    import lift_lab_tasks  # noqa: F401

    (tmp_path / "own_tasks").mkdir()
    (tmp_path / "own_tasks" / "__init__.py").write_text(REGISTER)
    (tmp_path / "own_tasks" / "settings.py").write_text(SETTINGS)
    (tmp_path / "broken_task.py").write_text("import a_package_that_is_not_there\n")
    (tmp_path / "empty_task.py").write_text("")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", [entry for entry in sys.path if entry not in ("", str(tmp_path))])
    yield tmp_path
    for name in ("own_tasks", "own_tasks.settings", "broken_task", "empty_task"):
        sys.modules.pop(name, None)
    gym.registry.pop("Own-Pole", None)


def test_a_package_in_the_current_folder_is_found(place):
    assert parse_env_cfg("own_tasks:Own-Pole", device="cpu", num_envs=2).episode_length_s == 1.25
    assert str(place) in sys.path


def test_the_tasks_of_a_module_are_listed_as_they_are_called():
    assert tasks_of("own_tasks") == ["own_tasks:Own-Pole"]


@pytest.mark.parametrize(
    ("module", "message"),
    [
        ("own_task", "no module 'own_task' in '{place}' or among the installed packages; did you mean 'own_tasks'"),
        ("own_tasks.setings", "no module 'own_tasks.setings' in the package 'own_tasks'; did you mean 'settings'?"),
        ("empty_task.py", "no module 'empty_task.py'; did you mean 'empty_task'?"),
        ("own_tasks/settings", "no module 'own_tasks/settings' in '{place}'"),
        (".own_tasks", "no module '.own_tasks' in '{place}'"),
        ("broken_task", "cannot import the module 'broken_task': No module named 'a_package_that_is_not_there'"),
    ],
)
def test_a_module_that_cannot_be_imported_is_named_with_the_nearest(place, module, message):
    with pytest.raises(NotFoundError) as caught:
        import_user_module(module)
    assert message.format(place=place) in str(caught.value)


def test_a_module_without_tasks_is_named():
    with pytest.raises(NotFoundError, match="'empty_task' registers no task"):
        tasks_of("empty_task")


def test_a_wrong_id_is_answered_with_those_of_the_module_first():
    with pytest.raises(NotFoundError, match="unknown task 'Own-Pol'; did you mean 'Own-Pole'"):
        task_kwargs("own_tasks:Own-Pol")
    with pytest.raises(NotFoundError, match="unknown task 'qqq'; choose one of: 'Own-Pole', "):
        task_kwargs("own_tasks:qqq")


def test_an_id_without_its_module_is_answered_with_the_way_to_give_it():
    with pytest.raises(NotFoundError, match=r"a task of your own needs its module: MODULE:ID"):
        task_kwargs("Own-Pole-2")
