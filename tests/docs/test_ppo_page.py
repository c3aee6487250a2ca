"""The page on PPO shows a script that runs, files that exist and settings that there are."""

import re
from pathlib import Path
from types import SimpleNamespace

import lift_lab_tasks  # noqa: F401
from lift_lab.envs.mirror import MirrorCfg
from lift_lab_rl.rsl_rl import to_rsl_rl
from lift_lab_tasks.utils import load_cfg_from_registry
from lift_lab_tasks.utils.hydra import compose

ROOT = Path(__file__).resolve().parents[2]
PAGE = (ROOT / "docs" / "ppo.md").read_text()
FOLDER = ROOT / "source" / "lift_lab_rl" / "rsl_rl"


def test_the_blocks_of_python_run():
    mirror, runner = re.findall(r"^```python\n(.*?)^```$", PAGE, flags=re.DOTALL | re.MULTILINE)
    names = {"env_cfg": SimpleNamespace()}
    exec(compile(mirror, "ppo.md", "exec"), names)
    assert isinstance(names["env_cfg"].mirror, MirrorCfg)
    names = {}
    exec(compile(runner, "ppo.md", "exec"), names)
    assert names["runner"].current_learning_iteration == 1  # rsl_rl counts one less


def test_the_command_with_rsl_rls_ppo_is_accepted():
    (command,) = re.findall(r"--task Lift-Cube-Franka (.*?)\n\n", PAGE.replace("\\\n", " "), flags=re.DOTALL)
    _, agent = compose("Lift-Cube-Franka", "rsl_rl_cfg_entry_point", command.split())
    assert to_rsl_rl(agent, ["policy"])["algorithm"]["class_name"] == "PPO"


def test_every_file_and_setting_that_is_named_exists():
    (diagram,) = re.findall(r"^```text\n(.*?)^```$", PAGE, flags=re.DOTALL | re.MULTILINE)
    files = set(re.findall(r"\w+\.py", diagram)) - {"train.py"}
    assert len(files) > 10
    assert [name for name in files if not (FOLDER / name).is_file()] == []
    agent = load_cfg_from_registry("Cartpole", "rsl_rl_cfg_entry_point")
    for path in re.findall(r"`agent\.([\w.]+)", PAGE):
        value = agent
        for name in path.split("."):
            assert hasattr(value, name), f"agent.{path}"
            value = getattr(value, name)
