"""Isaac Lab 2.3's own task packages run here with nothing but their import root renamed.

The packages are read from an installed copy of Isaac Lab, or from the ``source`` folder that the environment variable
``LIFT_LAB_ISAACLAB_SOURCE`` names; without either the tests are skipped. The renamed copies live in a temporary folder.
"""

import importlib
import importlib.util
import os
import re
import shutil
import sys
from pathlib import Path

import gymnasium as gym
import pytest
import torch

from lift_lab_tasks.utils import load_cfg_from_registry

TASKS_ROOT = "lift_lab_tasks_of_isaaclab"  # our own tasks keep the name lift_lab_tasks
PACKAGES = (
    "manager_based/manipulation/lift",
    "manager_based/manipulation/reach",
    "manager_based/manipulation/cabinet",
    "manager_based/classic/cartpole",
)
NUM_ENVS = 3
NUM_STEPS = 100

PANDA = 9
"""Joints of the Panda: seven of the arm, two fingers."""
POSE = 7
"""A position and a quaternion."""

# observation: joint positions and velocities, what the task adds, the last action
LIFT = 2 * PANDA + 3 + POSE  # the object's position, the goal
REACH = 2 * PANDA + POSE  # the goal
CABINET = 2 * PANDA + 2 + 3  # the drawer's position and velocity, the hand's way to the handle
GRIPPER = 1
OSC = POSE + 6  # a pose and its stiffnesses

TASKS = [
    # id, size of an action, size of an observation
    ("Isaac-Lift-Cube-Franka-v0", 7 + GRIPPER, LIFT + 7 + GRIPPER),
    ("Isaac-Lift-Cube-Franka-Play-v0", 7 + GRIPPER, LIFT + 7 + GRIPPER),
    ("Isaac-Lift-Cube-Franka-IK-Abs-v0", POSE + GRIPPER, LIFT + POSE + GRIPPER),
    ("Isaac-Lift-Cube-Franka-IK-Rel-v0", 6 + GRIPPER, LIFT + 6 + GRIPPER),
    ("Isaac-Reach-Franka-v0", 7, REACH + 7),
    ("Isaac-Reach-Franka-IK-Abs-v0", POSE, REACH + POSE),
    ("Isaac-Reach-Franka-IK-Rel-v0", 6, REACH + 6),
    ("Isaac-Reach-Franka-OSC-v0", OSC, POSE + OSC),  # the task drops the joints from its observations
    ("Isaac-Cartpole-v0", 1, 4),
    ("Isaac-Open-Drawer-Franka-v0", 7 + GRIPPER, CABINET + 7 + GRIPPER),
    ("Isaac-Open-Drawer-Franka-IK-Abs-v0", POSE + GRIPPER, CABINET + POSE + GRIPPER),
    ("Isaac-Open-Drawer-Franka-IK-Rel-v0", 6 + GRIPPER, CABINET + 6 + GRIPPER),
]


def _isaaclab_tasks() -> Path | None:
    """Folder of the package ``isaaclab_tasks``, without importing it (that would start Omniverse)."""
    source = os.environ.get("LIFT_LAB_ISAACLAB_SOURCE")
    candidates = []
    if source:
        candidates.append(Path(source) / "isaaclab_tasks" / "isaaclab_tasks")
    for name in ("isaaclab_tasks", "isaaclab"):
        spec = importlib.util.find_spec(name)
        for folder in (spec.submodule_search_locations or []) if spec else []:
            candidates += [Path(folder), Path(folder) / "source" / "isaaclab_tasks" / "isaaclab_tasks"]
    return next((c for c in candidates if (c / "manager_based" / "manipulation").is_dir()), None)


def _renamed(text: str) -> str:
    """The one change: ``isaaclab`` becomes ``lift_lab``, and the tasks get a root beside our own tasks'."""
    text = re.sub(r"\bisaaclab_tasks\b", TASKS_ROOT, text)
    return re.sub(r"\bisaaclab(?=_assets\b|_rl\b|\b)", "lift_lab", text)


@pytest.fixture(scope="module")
def isaaclab_task_ids(tmp_path_factory):
    """Ids of Isaac Lab's tasks, registered from renamed copies of its task packages."""
    original = _isaaclab_tasks()
    if original is None:
        pytest.skip("Isaac Lab is not installed and LIFT_LAB_ISAACLAB_SOURCE does not name its source folder")
    root = tmp_path_factory.mktemp("isaaclab") / TASKS_ROOT
    for package in PACKAGES:
        target = root / package
        shutil.copytree(original / package, target, ignore=shutil.ignore_patterns("__pycache__"))
        for file in target.rglob("*.py"):
            file.write_text(_renamed(file.read_text()))
        for folder in (root, *(root / p for p in Path(package).parents if p != Path())):
            (folder / "__init__.py").touch()
    before = set(gym.registry)
    sys.path.insert(0, str(root.parent))
    try:
        for package in PACKAGES:
            for init in sorted((root / package).rglob("__init__.py")):
                if init.parent.name in ("mdp", "agents"):
                    continue  # imported by what uses them
                importlib.import_module(".".join(init.parent.relative_to(root.parent).parts))
        yield set(gym.registry) - before
    finally:
        sys.path.remove(str(root.parent))
        for name in [n for n in sys.modules if n.split(".")[0] == TASKS_ROOT]:
            del sys.modules[name]
        for task in set(gym.registry) - before:
            del gym.registry[task]


@pytest.mark.parametrize(("task", "num_actions", "num_observations"), TASKS, ids=[task[0] for task in TASKS])
def test_an_isaac_lab_task_runs_after_renaming_its_import_root(isaaclab_task_ids, task, num_actions, num_observations):
    assert task in isaaclab_task_ids
    cfg = load_cfg_from_registry(task, "env_cfg_entry_point")
    cfg.scene.num_envs = NUM_ENVS
    cfg.sim.device = "cpu"
    cfg.seed = 7
    env = gym.make(task, cfg=cfg).unwrapped
    try:
        assert env.sim.physics.name == "native"
        assert env.single_action_space.shape == (num_actions,)
        observations, _ = env.reset()
        generator = torch.Generator().manual_seed(7)
        for _ in range(NUM_STEPS):
            assert observations["policy"].shape == (NUM_ENVS, num_observations)
            assert observations["policy"].isfinite().all()
            action = 2.0 * torch.rand(NUM_ENVS, num_actions, generator=generator) - 1.0
            observations, reward, terminated, truncated, extras = env.step(action)
            assert reward.shape == (NUM_ENVS,)
            assert reward.isfinite().all()
            assert not (terminated & truncated).any()
            failures = {k: v for k, v in extras.get("log", {}).items() if k.startswith("Metrics/physics/")}
            assert not any(failures.values())
        assert not env.sim.physics.health().failed.any()
    finally:
        env.close()


def test_every_config_class_of_the_packages_can_be_made(isaaclab_task_ids):
    """Also of variants whose robot or physics does not exist here: their files import and hold data."""
    made = set()
    for task in sorted(isaaclab_task_ids):
        for key, entry in gym.spec(task).kwargs.items():
            if isinstance(entry, str) and key in ("env_cfg_entry_point", "rsl_rl_cfg_entry_point"):
                if any(robot in entry for robot in ("openarm", "ur_10")):
                    continue  # robots without an asset here
                made.add(type(load_cfg_from_registry(task, key)).__name__)
    assert {"FrankaTeddyBearLiftEnvCfg", "CartpoleRGBCameraEnvCfg", "FrankaReachEnvCfg"} <= made
