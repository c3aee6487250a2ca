"""The robot configurations, as data."""

import pkgutil
import re
import subprocess
import sys
from pathlib import Path

import pytest

import lift_lab_assets
from lift_lab.utils.errors import ConfigError
from lift_lab_assets import CARTPOLE_CFG, FRANKA_PANDA_CFG, FRANKA_PANDA_HIGH_PD_CFG, LIFT_LAB_ASSETS_USD_DIR, robots
from lift_lab_assets.robots.franka import FRANKA_PANDA_CFG as FROM_MODULE

PANDA_JOINTS = [*(f"panda_joint{i}" for i in range(1, 8)), "panda_finger_joint1", "panda_finger_joint2"]


def groups_of(cfg, joint: str) -> list[str]:
    return [
        name
        for name, group in cfg.actuators.items()
        if any(re.fullmatch(pattern, joint) for pattern in group.joint_names_expr)
    ]


def test_star_import_gives_isaac_labs_names():
    assert FROM_MODULE is FRANKA_PANDA_CFG
    for name in ("FRANKA_PANDA_CFG", "FRANKA_PANDA_HIGH_PD_CFG", "CARTPOLE_CFG"):
        assert hasattr(lift_lab_assets, name)
    assert not hasattr(lift_lab_assets, "ImplicitActuatorCfg")


@pytest.fixture
def robots_folder(tmp_path, monkeypatch):
    """A folder whose modules are found as if they were beside the shipped robots."""
    monkeypatch.setattr(robots, "__path__", [*robots.__path__, str(tmp_path)])
    robots.robot_configs.cache_clear()
    yield tmp_path
    robots.robot_configs.cache_clear()
    for module in [name for name in sys.modules if name.startswith("lift_lab_assets.robots.toy_")]:
        del sys.modules[module]


TOY = """
from lift_lab.assets import ArticulationCfg
from lift_lab_assets.robots.cartpole import CARTPOLE_CFG

{name} = ArticulationCfg(prim_path="/Toy", actuators={{}})
_PRIVATE_CFG = {name}.copy()
"""


def test_a_robot_of_a_new_file_is_found_without_a_list(robots_folder):
    (robots_folder / "toy_arm.py").write_text(TOY.format(name="TOY_ARM_CFG"))
    assert lift_lab_assets.TOY_ARM_CFG.prim_path == "/Toy"
    assert lift_lab_assets.CARTPOLE_CFG is CARTPOLE_CFG
    assert "TOY_ARM_CFG" in dir(lift_lab_assets)
    scope = {}
    exec("from lift_lab_assets import *", scope)
    assert scope["TOY_ARM_CFG"] is robots.TOY_ARM_CFG
    assert scope.keys() - {"__builtins__"} == {name for name in scope if name.isupper() and not name.startswith("_")}


def test_two_robots_of_one_name_are_refused(robots_folder):
    for name in ("toy_one", "toy_two"):
        (robots_folder / f"{name}.py").write_text(TOY.format(name="TOY_CFG"))
    with pytest.raises(ConfigError, match=r"'TOY_CFG' is a robot in toy_one.py and another one in toy_two.py"):
        lift_lab_assets.TOY_CFG  # noqa: B018


def test_a_wrong_robot_is_an_error_with_the_nearest():
    with pytest.raises(AttributeError, match="no robot 'FRANKA_PANDA'; did you mean 'FRANKA_PANDA_CFG'"):
        lift_lab_assets.FRANKA_PANDA  # noqa: B018


def test_importing_the_package_loads_no_robot():
    code = "import sys, lift_lab_assets; print([m for m in ('mujoco', 'lift_lab.sim') if m in sys.modules])"
    out = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert out.stdout.strip() == "[]"


@pytest.mark.parametrize("cfg", [FRANKA_PANDA_CFG, FRANKA_PANDA_HIGH_PD_CFG, CARTPOLE_CFG])
def test_spawned_file_ships_with_the_package(cfg):
    path = Path(cfg.spawn.usd_path)
    assert path.is_file()
    assert path.parent == Path(LIFT_LAB_ASSETS_USD_DIR)


@pytest.mark.parametrize("cfg", [FRANKA_PANDA_CFG, FRANKA_PANDA_HIGH_PD_CFG])
def test_each_joint_of_the_panda_is_in_one_group_and_has_an_initial_position(cfg):
    for joint in PANDA_JOINTS:
        assert len(groups_of(cfg, joint)) == 1, joint
        assert sum(bool(re.fullmatch(pattern, joint)) for pattern in cfg.init_state.joint_pos) == 1, joint


def test_initial_pose_of_the_panda_is_isaac_labs():
    pose = FRANKA_PANDA_CFG.init_state.joint_pos
    assert [pose[f"panda_joint{i}"] for i in range(1, 8)] == [0.0, -0.569, 0.0, -2.810, 0.0, 3.037, 0.741]
    assert pose["panda_finger_joint.*"] == 0.04


def test_panda_has_the_gains_that_learn_to_grasp():
    actuators = FRANKA_PANDA_CFG.actuators
    values = {name: (a.stiffness, a.damping, a.effort_limit_sim) for name, a in actuators.items()}
    assert values == {
        "panda_shoulder": (400.0, 160.0, 87.0),
        "panda_forearm": (400.0, 160.0, 12.0),
        "panda_hand": (350.0, 10.0, 70.0),
    }
    assert FRANKA_PANDA_CFG.spawn.rigid_props.disable_gravity is True


def test_high_pd_differs_only_in_the_arms_damping():
    arm = FRANKA_PANDA_HIGH_PD_CFG.actuators
    assert [arm[name].damping for name in ("panda_shoulder", "panda_forearm", "panda_hand")] == [
        80.0,
        80.0,
        10.0,
    ]
    assert FRANKA_PANDA_CFG.actuators["panda_shoulder"].damping == 160.0
    changed = FRANKA_PANDA_HIGH_PD_CFG.copy()
    changed.actuators["panda_shoulder"].damping = changed.actuators["panda_forearm"].damping = 160.0
    assert changed.to_dict() == FRANKA_PANDA_CFG.to_dict()


def test_cart_is_driven_by_effort_against_a_damper_and_the_pole_swings_freely():
    cart, pole = CARTPOLE_CFG.actuators["cart_actuator"], CARTPOLE_CFG.actuators["pole_actuator"]
    assert (cart.joint_names_expr, cart.stiffness, cart.damping) == (["slider_to_cart"], 0.0, 10.0)
    assert (pole.joint_names_expr, pole.stiffness, pole.damping) == (["cart_to_pole"], 0.0, 0.0)


def test_an_editor_sees_the_robots_of_every_module():
    text = Path(robots.__file__).read_text()
    modules = [info.name for info in pkgutil.iter_modules(robots.__path__)]
    assert modules
    assert [name for name in modules if f"    from .{name} import *\n" not in text] == []
