"""Porting replaces the names of Isaac Lab's packages and no other byte, and lists what lift_lab does not have."""

import ast
import os
import re
import sys

import pytest

from lift_lab.app import cli
from lift_lab.isaac.finder import names_of
from lift_lab.isaac.table import TABLE
from lift_lab_cli import port
from lift_lab_cli.port.rename import new_name
from lift_lab_cli.port.rename import port as port_text
from lift_lab_cli.port.support import problem, reason_of

BEFORE = b'''\
# isaaclab in a comment stays, and so does isaaclab.sim
"""Terms of :class:`isaaclab.envs.ManagerBasedRLEnv`; see https://isaac-sim.github.io/isaaclab.html."""
import isaaclab.sim  as  sim_utils, os
from isaaclab.assets import (ArticulationCfg,   # layout   stays
    RigidObjectCfg)
from isaaclab_tasks.utils import \\
    parse_env_cfg
import isaaclab.utils.math
from isaaclab_assets.robots.franka import FRANKA_PANDA_CFG as _CFG
from my_isaaclab import isaaclab_like
\tif_tabs = 1
'''.replace(b"\tif_tabs", b"if_tabs")
AFTER = b'''\
# isaaclab in a comment stays, and so does isaaclab.sim
"""Terms of :class:`lift_lab.envs.ManagerBasedRLEnv`; see https://isaac-sim.github.io/isaaclab.html."""
import lift_lab.sim  as  sim_utils, os
from lift_lab.assets import (ArticulationCfg,   # layout   stays
    RigidObjectCfg)
from lift_lab_tasks.utils import \\
    parse_env_cfg
import lift_lab.utils.math
from lift_lab_assets.robots.franka import FRANKA_PANDA_CFG as _CFG
from my_isaaclab import isaaclab_like
if_tabs = 1
'''


def test_names_are_replaced_and_nothing_else():
    found = port_text(BEFORE)
    assert found.data == AFTER
    assert (found.renamed, found.problem) == (6, None)


@pytest.mark.parametrize(
    ("before", "after"),
    [
        ('x = "isaaclab_tasks.lift.cfg:Cfg"', 'x = "lift_lab_tasks.lift.cfg:Cfg"'),
        ("x = 'isaaclab.envs:ManagerBasedRLEnv'", "x = 'lift_lab.envs:ManagerBasedRLEnv'"),
        ('x = f"isaaclab_tasks.{name}:Cfg"', 'x = f"lift_lab_tasks.{name}:Cfg"'),
        ('x = f"{a} isaaclab_rl.{name}" "isaaclab.b"', 'x = f"{a} lift_lab_rl.{name}" "lift_lab.b"'),
        ('x = import_module("isaaclab_rl")', 'x = import_module("lift_lab_rl")'),
        ('x = "logs/isaaclab/run", "my-isaaclab.x", "isaaclab is a framework"', None),
        ("import isaaclab\ny = isaaclab.sim.X", "import lift_lab\ny = lift_lab.sim.X"),
        ("import isaaclab.sim\nü = 'é', isaaclab.sim.X", "import lift_lab.sim\nü = 'é', lift_lab.sim.X"),
        ("isaaclab = 1\ny = isaaclab.real", None),
        ("from . import isaaclab\nfrom .isaaclab import x\ny = isaaclab.z", None),
        ("from omni.isaac.lab.utils import configclass", "from lift_lab.utils import configclass"),
        (
            "from omni.isaac.lab_tasks.utils.wrappers.rsl_rl import RslRlVecEnvWrapper",
            "from lift_lab_rl.rsl_rl import RslRlVecEnvWrapper",
        ),
        ("import omni.isaac.lab.sim\nomni.isaac.lab.sim.X()", "import lift_lab.sim\nlift_lab.sim.X()"),
        ("from omni.isaac.core import World\nimport omni.usd", None),
        ("if x:\r\n    import isaaclab.sim as s\r\n", "if x:\r\n    import lift_lab.sim as s\r\n"),
    ],
)
def test_a_line_is_renamed(before, after):
    after = before if after is None else after
    found = port_text(before.encode())
    assert found.data.decode() == after
    assert port_text(found.data).data == found.data, "a second time changes nothing"
    ast.parse(found.data)


def test_other_encodings_and_marks_stay():
    latin = "# -*- coding: latin-1 -*-\nimport isaaclab.sim as s  # \xe9\n".encode("latin-1")
    assert port_text(latin).data == latin.replace(b"isaaclab", b"lift_lab")
    marked = b"\xef\xbb\xbfimport isaaclab.sim as s\n"
    assert port_text(marked).data == marked.replace(b"isaaclab", b"lift_lab")


@pytest.mark.parametrize("data", [b"import isaaclab.sim as\n", b"\xff\xfe\x00", b"x = '\x00'", b"import isaaclab\n  y"])
def test_what_is_no_python_stays_as_it_is(data):
    found = port_text(data)
    assert found.problem
    assert (found.data, found.renamed) == (data, 0)


def test_the_longest_name_decides():
    assert new_name("isaaclab_tasks.utils") == "lift_lab_tasks.utils"
    assert new_name("omni.isaac.lab_assets.franka.X") == "lift_lab_assets.robots.franka.X"
    assert new_name("isaaclabs.sim") is None
    assert new_name("omni.isaac.labs") is None


# -- what is not supported


def test_every_reason_of_the_table_reads_as_a_sentence():
    for entry in TABLE:
        for row in entry.modules:
            for name in names_of(entry, row):
                text = reason_of(f"lift_lab.{row}", name)
                assert text is not None
                assert not re.search(r"[{}]|''|prim_path", text), text


@pytest.mark.parametrize(
    ("module", "name", "expected"),
    [
        ("lift_lab.sensors", "CameraCfg", "image sensors are not simulated; remove the camera from the scene"),
        ("lift_lab.sensors", "ContactSensorCfg", None),
        ("lift_lab.sim", "UrdfFileCfg", "URDF and MJCF files are not loaded; convert them to USD and use UsdFileCfg"),
        ("lift_lab.sim", "UsdFileCfg.func", None),
        ("lift_lab.envs", "mdp.height_scan", "mdp.height_scan needs a ray caster, which is not simulated"),
        ("lift_lab.envs.mdp", "joint_pos_rel", None),
        ("lift_lab.managers", "SceneEntityCgf", "lift_lab.managers has no such name; did you mean 'SceneEntityCfg'"),
        ("lift_lab.controllers.pink_ik", "PinkIKController", "there is no module lift_lab.controllers.pink_ik"),
        ("lift_lab_assets.robots.anymal", "ANYMAL_C_CFG", "there is no module lift_lab_assets.robots.anymal"),
        ("lift_lab.managers.SceneEntityCfg", "resolve", None),
        ("isaacsim.core.utils.stage", "get_current_stage", "Isaac Sim is not supported"),
        ("torch.nn", "Nothing", None),
    ],
)
def test_a_name_is_supported_or_said_why_not(module, name, expected):
    found = problem(module, name)
    assert (found is None) == (expected is None)
    assert expected is None or found.startswith(expected)


# -- the command


@pytest.fixture
def call(monkeypatch, capsys, tmp_path):
    """Runs the command in a folder; returns exit status, output and errors."""
    monkeypatch.chdir(tmp_path)

    def run(*args):
        monkeypatch.setattr(sys, "argv", ["lift-lab port", *map(str, args)])
        with pytest.raises(SystemExit) as ended:
            cli.run(port.main)
        captured = capsys.readouterr()
        return ended.value.code, captured.out, captured.err

    return run


@pytest.fixture
def package(tmp_path):
    """A package with a local ``mdp``, data, a broken file and a name that is not supported."""
    folder = tmp_path / "my_task"
    files = {
        "__init__.py": 'import gymnasium as gym\n\nENTRY = "isaaclab.envs:ManagerBasedRLEnv"\n',
        "env_cfg.py": (
            "import isaaclab.sim as sim_utils\n"
            "from isaaclab.sensors import CameraCfg, FrameTransformerCfg\n"
            "import my_task.mdp as mdp\n"
            "from . import mdp as terms\n"
            "X = mdp.height_scan, mdp.own, mdp.joint_pos_rel, terms.image\n"
            "Y = sim_utils.PinholeCameraCfg(), sim_utils.UsdFileCfg()\n"
        ),
        "mdp/__init__.py": "from isaaclab.envs.mdp import *\nfrom .rewards import *\n",
        "mdp/rewards.py": "def own(env):\n    return env\n",
        "broken.py": "import isaaclab.sim as\n",
        "config/extension.toml": '[dependencies]\n"isaaclab" = {}\n',
        "data.bin": "\0isaaclab",
    }
    for name, text in files.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text)
    (folder / "__pycache__").mkdir()
    (folder / "__pycache__" / "x.pyc").touch()
    return folder


def contents(folder):
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def test_a_package_is_written_and_reported(call, package, tmp_path):
    before = contents(package)
    status, out, err = call("my_task", "--out", "ported/my_task")
    assert (status, err) == (0, "")
    after = contents(tmp_path / "ported" / "my_task")
    changed = {name for name in after if after[name] != before[name]}
    assert {*before} - {*after} == {"__pycache__/x.pyc"}
    assert changed == {"__init__.py", "env_cfg.py", "mdp/__init__.py"}
    assert b"from lift_lab.sensors import CameraCfg" in after["env_cfg.py"]
    assert contents(package) == before
    assert out.splitlines() == [
        "Python files: 5, of which 3 change; names renamed: 4",
        "other files, unchanged: 2",
        "not parsed, unchanged: ported/my_task/broken.py: line 1: invalid syntax",
        "change by hand: ported/my_task/config/extension.toml:2: names isaaclab",
        "names that lift_lab does not support: 4",
        "  ported/my_task/env_cfg.py:2: lift_lab.sensors.CameraCfg: image sensors are not simulated; remove the camera "
        "from the scene",
        "  ported/my_task/env_cfg.py:5: my_task.mdp.height_scan: mdp.height_scan needs a ray caster, which is not "
        "simulated; remove the term",
        "  ported/my_task/env_cfg.py:5: mdp.image: mdp.image needs images, and no camera is simulated; remove the term",
        "  ported/my_task/env_cfg.py:6: lift_lab.sim.PinholeCameraCfg: camera sensors are not supported; remove "
        "PinholeCameraCfg from the scene",
        "written: ported/my_task",
    ]
    assert sorted(path.name for path in (tmp_path / "ported").iterdir()) == ["my_task"]


def test_what_is_no_file_is_named_and_left_out(call, tmp_path):
    """Editors leave links to nothing beside a file that is open."""
    folder = tmp_path / "theirs"
    (folder / "mdp").mkdir(parents=True)
    (folder / "a.py").write_text("import isaaclab.sim\n")
    (folder / ".#a.py").symlink_to("me@host.123")
    (folder / "same").symlink_to("mdp")
    os.mkfifo(folder / "pipe.py")
    code, printed, _ = call(folder, "--out", tmp_path / "out")
    assert code == 0
    for name, kind in ((".#a.py", "link to nothing"), ("same", "link to a folder"), ("pipe.py", "not a regular file")):
        assert f"{kind}, left out: {folder / name}" in printed
    assert [path.name for path in (tmp_path / "out").iterdir()] == ["a.py"]


def test_in_place_gives_the_same_and_only_if_asked(call, package, tmp_path):
    before = contents(package)
    status, out, _ = call("my_task")
    assert status == 0
    assert out.endswith("nothing written: --out DIR writes the ported files\n")
    assert contents(package) == before
    call("my_task", "--out", "ported")
    assert call("my_task", "--in_place")[0] == 0
    del before["__pycache__/x.pyc"]
    assert {**contents(package), "__pycache__/x.pyc": b""} == {
        **contents(tmp_path / "ported"),
        "__pycache__/x.pyc": b"",
    }
    status, out, _ = call("my_task", "--in_place")
    assert out.startswith("Python files: 5, of which 0 change; names renamed: 0\n")


@pytest.mark.parametrize(
    ("args", "message"),
    [
        (["nothing"], "the folder 'nothing' does not exist"),
        (["my_task/data.bin"], "the folder 'my_task/data.bin' is a file: give its folder"),
        (["my_task/config"], "the folder 'my_task/config' holds no Python file"),
        (["my_task", "--out", "my_task"], "--out 'my_task' lies in 'my_task': choose a folder outside, or --in_place"),
        (["my_task", "--out", "my_task/new"], "--out 'my_task/new' lies in 'my_task'"),
        (["my_task", "--out", "."], "--out '.' exists already: choose a new folder"),
        (["my_task", "--out", "my_task/../full"], "exists already"),
        (["my_task", "--out", "a", "--in_place"], "--out and --in_place both say where the result goes: give one"),
        (["my_task", "env.x=1"], "unexpected argument 'env.x=1'"),
        (["newer", "--out", "a"], "newer/cfg.py:1 uses isaaclab_newton.physics of Isaac Lab 3.0"),
    ],
)
def test_a_mistake_is_one_line_and_writes_nothing(call, package, tmp_path, args, message):
    (tmp_path / "full").mkdir()
    (tmp_path / "full" / "file").touch()
    (tmp_path / "newer").mkdir()
    (tmp_path / "newer" / "cfg.py").write_text("from isaaclab_newton.physics import NewtonCfg\n")
    before = contents(tmp_path)
    status, out, err = call(*args)
    assert (status, out) == (2, "")
    assert message in err
    assert err.count("\n") == 1
    assert contents(tmp_path) == before


def test_a_module_of_the_folder_under_isaac_labs_name_is_pointed_out(call, tmp_path):
    folder = tmp_path / "my_task" / "config"
    folder.mkdir(parents=True)
    (tmp_path / "my_task" / "env_cfg.py").write_text("class Cfg: ...\n")
    (folder / "franka.py").write_text("from isaaclab_tasks.manager_based.my_task.env_cfg import Cfg\n")
    _, out, _ = call("my_task")
    assert "but the folder has env_cfg.py: import it by the name of your own package" in out
