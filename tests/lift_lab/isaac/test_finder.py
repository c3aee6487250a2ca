"""The import hook: every name of the table, wrong names, files that win, and nothing loaded too early."""

import ast
import copy
import importlib
import importlib.util
import pickle
import subprocess
import sys
import types
from pathlib import Path

import pytest

import lift_lab
from lift_lab.isaac.finder import MODULES, TableFinder, TableLoader
from lift_lab.isaac.table import TABLE
from lift_lab.utils.errors import LiftLabError

ROOT = Path(lift_lab.__file__).parent


def is_served(module: str) -> bool:
    return isinstance(importlib.import_module(module).__loader__, TableLoader)


@pytest.mark.parametrize("module", MODULES)
def test_a_module_has_every_name_of_its_row(module):
    found = importlib.import_module(module)
    scope: dict = {}
    exec(f"from {module} import *", scope)
    for name in MODULES[module]:
        assert scope[name] is getattr(found, name)
        assert name in dir(found)
        if isinstance(scope[name], type):
            home = importlib.import_module(scope[name].__module__)
            assert getattr(home, name) is scope[name]
            assert "isaac" not in home.__name__


@pytest.mark.parametrize("module", ["sensors", "assets", "terrains", "sim.spawners", "envs", "envs.mdp"])
def test_a_star_import_of_a_real_package_brings_its_names_and_no_helper(module):
    scope: dict = {}
    exec(f"from lift_lab.{module} import *", scope)
    modules = {name for name, value in scope.items() if isinstance(value, types.ModuleType)}
    assert modules <= {"mdp", "patterns"}  # Isaac Lab exports these two
    assert not {"attributes_of", "TYPE_CHECKING", "annotations"} & scope.keys()


def test_the_table_lists_nothing_that_a_file_defines():
    """A name that becomes real leaves the table."""
    for module, names in MODULES.items():
        if is_served(module):
            continue
        tree = ast.parse(Path(importlib.import_module(module).__file__).read_text())
        defined = {node.name for node in tree.body if isinstance(node, (ast.ClassDef, ast.FunctionDef))}
        assert not defined & set(names), module


def test_every_reason_is_one_line_that_names_its_subject():
    for entry in TABLE:
        assert "{" in entry.reason
        assert "\n" not in entry.reason


@pytest.mark.parametrize(
    ("module", "wrong", "nearest"),
    [
        ("lift_lab.devices", "Se3KeybordCfg", "Se3KeyboardCfg"),
        ("lift_lab.devices.keyboard.se3_keyboard", "Se3KeybordCfg", "Se3KeyboardCfg"),
        ("lift_lab.sensors.camera", "CamraCfg", "CameraCfg"),
        ("lift_lab.devices", "keybord", "keyboard"),
    ],
)
def test_a_wrong_name_is_an_error_with_the_nearest(module, wrong, nearest):
    found = importlib.import_module(module)
    assert not hasattr(found, wrong)
    with pytest.raises(AttributeError, match=f"'{module}' has no '{wrong}'; did you mean '{nearest}'"):
        getattr(found, wrong)
    with pytest.raises(ImportError, match=f"'{module}' has no '{wrong}'; did you mean '{nearest}'"):
        exec(f"from {module} import {wrong}")
    with pytest.raises(ModuleNotFoundError, match=f"'{module}' has no '{wrong}'"):
        importlib.import_module(f"{module}.{wrong}")


def test_a_wrong_name_in_a_real_module_is_one_as_well():
    from lift_lab import sensors

    with pytest.raises(AttributeError, match=r"'lift_lab.sensors' has no 'CameraCgf'; did you mean 'CameraCfg'"):
        sensors.CameraCgf  # noqa: B018
    assert importlib.util.find_spec("lift_lab.nothing") is None


def test_configs_can_be_copied_and_pickled_and_changed():
    from lift_lab.devices import DevicesCfg, Se3KeyboardCfg
    from lift_lab.sensors import CameraCfg
    from lift_lab.terrains import MeshRepeatedBoxesTerrainCfg

    camera = CameraCfg(prim_path="/Cam", spawn=None, width=4, height=4, offset=CameraCfg.OffsetCfg(pos=(1.0, 0.0, 0.0)))
    boxes = MeshRepeatedBoxesTerrainCfg(
        object_params_start=MeshRepeatedBoxesTerrainCfg.ObjectCfg(num_objects=3, height=0.1, size=(0.5, 0.5)),
        object_params_end=MeshRepeatedBoxesTerrainCfg.ObjectCfg(num_objects=9, height=0.2, size=(0.5, 0.5)),
    )
    for cfg in (camera, boxes, DevicesCfg(devices={"keys": Se3KeyboardCfg()})):
        for other in (copy.deepcopy(cfg), pickle.loads(pickle.dumps(cfg))):
            assert type(other) is type(cfg)
            assert other.to_dict() == cfg.to_dict()
    assert camera.to_dict()["class_type"] == "lift_lab.sensors.camera.camera:Camera"
    camera.from_dict({"width": 8, "offset": {"convention": "world"}, "class_type": "lift_lab.sensors:TiledCamera"})
    assert (camera.width, camera.offset.convention, camera.class_type.__name__) == (8, "world", "TiledCamera")
    with pytest.raises(LiftLabError, match=r"offset\.convention"):
        camera.from_dict({"offset": {"convention": "wrold"}})
    camera.width = 0
    with pytest.raises(LiftLabError, match="width is 0"):
        camera.validate()


def test_every_class_and_function_of_the_table_can_be_pickled():
    wrong = []
    for module, names in MODULES.items():
        for name in names:
            value = getattr(importlib.import_module(module), name)
            if isinstance(value, (type, types.FunctionType)) and pickle.loads(pickle.dumps(value)) is not value:
                wrong.append(f"{module}.{name}")
    assert not wrong


def test_types_can_be_asked_for_and_subclassed():
    import gymnasium as gym

    from lift_lab.envs import DirectRLEnv, DirectRLEnvCfg, mdp
    from lift_lab.managers import ActionTerm, ManagerTermBase
    from lift_lab.sensors import Camera, CameraCfg, SensorBase, SensorBaseCfg, TiledCamera
    from lift_lab.utils import configclass

    class MyCamera(TiledCamera):
        def __init__(self, cfg, extra):
            raise AssertionError("never reached")

    @configclass
    class MyEnvCfg(DirectRLEnvCfg):
        decimation = 2

    assert issubclass(Camera, SensorBase)
    assert issubclass(CameraCfg, SensorBaseCfg)
    assert issubclass(DirectRLEnv, gym.Env)
    assert issubclass(mdp.image, ManagerTermBase)
    assert issubclass(mdp.SurfaceGripperBinaryAction, ActionTerm)
    with pytest.raises(LiftLabError, match="'/Cam': image sensors are not simulated"):
        MyCamera(cfg=CameraCfg(prim_path="/Cam"), extra=1)
    with pytest.raises(LiftLabError, match="MyEnvCfg: only the manager-based workflow exists here"):
        MyEnvCfg()


def test_a_file_wins_over_the_table_and_an_empty_folder_does_not(tmp_path):
    def found():
        return TableFinder.find_spec("lift_lab.devices", [str(tmp_path)])

    (tmp_path / "devices" / "__pycache__").mkdir(parents=True)
    assert isinstance(found().loader, TableLoader)
    (tmp_path / "devices" / "__init__.py").touch()
    assert found() is None
    (tmp_path / "devices" / "__init__.py").unlink()
    (tmp_path / "devices.py").touch()
    assert found() is None


def test_a_file_of_one_module_wins_where_its_package_has_none(tmp_path):
    (tmp_path / "devices").mkdir()
    (tmp_path / "devices" / "gamepad.py").write_text("Se3Gamepad = 'real'\n")
    code = f"""
import lift_lab
lift_lab.__path__.insert(0, {str(tmp_path)!r})
from lift_lab.devices.gamepad import Se3Gamepad
from lift_lab.devices.keyboard import Se3Keyboard
print(Se3Gamepad, Se3Keyboard.__name__)"""
    out = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert out.stdout.split() == ["real", "Se3Keyboard"]


def test_nothing_is_loaded_before_a_name_is_asked_for():
    code = """
import sys, lift_lab
assert "torch" not in sys.modules and "lift_lab.utils" not in sys.modules
import lift_lab.sensors, lift_lab.terrains, lift_lab.devices.keyboard
print(*sorted(name for name in sys.modules if name.startswith("lift_lab.isaac.")))
"""
    out = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert set(out.stdout.split()) & {f"lift_lab.isaac.{name}" for name in ("devices", "sensors", "terrains")} == set()
