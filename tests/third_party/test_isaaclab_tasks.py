"""Isaac Lab 2.3's own task packages run here after ``lift-lab port``, which renames their import root.

The packages are read from the ``source`` folder that the environment variable ``LIFT_LAB_ISAACLAB_SOURCE`` names, from
an installed copy of Isaac Lab, or from its released wheel (3 MB), which is fetched once into pytest's cache; where none
can be had the tests are skipped. The renamed copies live in a temporary folder.
"""

import importlib
import importlib.util
import os
import re
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import gymnasium as gym
import pytest
import torch
from pxr import Gf, Usd, UsdGeom, UsdPhysics

import lift_lab.sim as sim_utils
from lift_lab.actuators import DelayedPDActuatorCfg
from lift_lab.assets import ArticulationCfg
from lift_lab.envs import ManagerBasedRLEnv
from lift_lab_cli.port.rename import port
from lift_lab_tasks.utils import load_cfg_from_registry

TASKS_ROOT = "lift_lab_tasks_of_isaaclab"  # our own tasks keep the name lift_lab_tasks
PACKAGES = (
    "manager_based/manipulation/lift",
    "manager_based/manipulation/reach",
    "manager_based/manipulation/cabinet",
    "manager_based/classic/cartpole",
)
VELOCITY = "manager_based/locomotion/velocity"
"""Its robots have no asset here; the task itself is made with a robot of the test's."""
RELEASE = "2.3.2.post1"
FETCH_SECONDS = 120
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


def _installed() -> Path | None:
    """Folder of the package ``isaaclab_tasks``, without importing it (that would start Omniverse)."""
    source = os.environ.get("LIFT_LAB_ISAACLAB_SOURCE")
    candidates = [Path(source) / "isaaclab_tasks" / "isaaclab_tasks"] if source else []
    for name in ("isaaclab_tasks", "isaaclab"):
        spec = importlib.util.find_spec(name)
        for folder in (spec.submodule_search_locations or []) if spec else []:
            candidates += [Path(folder), Path(folder) / "source" / "isaaclab_tasks" / "isaaclab_tasks"]
    return next((c for c in candidates if (c / "manager_based" / "manipulation").is_dir()), None)


def _fetched(folder: Path) -> Path:
    """The same folder from the released wheel, which is for Python 3.11 and read here with any.

    Args:
        folder: where the wheel is kept; an earlier run's is used again.
    """
    if not list(folder.glob("isaaclab-*.whl")):
        command = [sys.executable, "-m", "pip", "download", "--quiet", "--disable-pip-version-check", "--no-deps"]
        command += ["--only-binary=:all:", "--python-version=3.11", "--platform=manylinux_2_35_x86_64"]
        command += [f"--dest={folder}", f"isaaclab=={RELEASE}"]
        try:
            subprocess.run(command, check=True, capture_output=True, text=True, timeout=FETCH_SECONDS)
        except subprocess.TimeoutExpired:
            pytest.skip(f"Isaac Lab {RELEASE} was not downloaded within {FETCH_SECONDS} s")
        except subprocess.CalledProcessError as error:
            pytest.skip(f"Isaac Lab {RELEASE} cannot be downloaded: {error.stderr.strip().splitlines()[-1:]}")
    tasks = folder / "isaaclab" / "source" / "isaaclab_tasks" / "isaaclab_tasks"
    if not tasks.is_dir():
        with zipfile.ZipFile(next(folder.glob("isaaclab-*.whl"))) as wheel:
            inside = tasks.relative_to(folder).as_posix()
            wheel.extractall(folder, [name for name in wheel.namelist() if name.startswith(f"{inside}/manager_based/")])
    return tasks


def _renamed(text: str) -> str:
    """What ``lift-lab port`` makes of a file, and the tasks get a root beside our own tasks'."""
    return re.sub(r"\blift_lab_tasks\b", TASKS_ROOT, port(text.encode()).data.decode())


@pytest.fixture(scope="module")
def isaaclab_task_ids(tmp_path_factory, pytestconfig):
    """Ids of Isaac Lab's tasks, registered from renamed copies of its task packages."""
    cache = getattr(pytestconfig, "cache", None)  # none with -p no:cacheprovider
    original = _installed() or _fetched(cache.mkdir("isaaclab") if cache else tmp_path_factory.mktemp("wheel"))
    root = tmp_path_factory.mktemp("isaaclab") / TASKS_ROOT
    for package in (*PACKAGES, VELOCITY):
        target = root / package
        left_out = ("__pycache__", "config") if package == VELOCITY else ("__pycache__",)
        shutil.copytree(original / package, target, ignore=shutil.ignore_patterns(*left_out))
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


def _author_quadruped(path: Path) -> None:
    """A box on four legs of two links, named as Isaac Lab's velocity task wants: base, .*THIGH, .*FOOT."""
    stage = Usd.Stage.CreateNew(str(path))
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.z)
    root = UsdGeom.Xform.Define(stage, "/Dog").GetPrim()
    stage.SetDefaultPrim(root)
    UsdPhysics.ArticulationRootAPI.Apply(root)

    def link(name, at, size, mass):
        body = UsdGeom.Xform.Define(stage, f"/Dog/{name}")
        body.AddTranslateOp().Set(Gf.Vec3d(*at))
        UsdPhysics.RigidBodyAPI.Apply(body.GetPrim())
        UsdPhysics.MassAPI.Apply(body.GetPrim()).CreateMassAttr(mass)
        shape = UsdGeom.Cube.Define(stage, f"/Dog/{name}/shape")
        shape.CreateSizeAttr(1.0)
        shape.AddTranslateOp().Set(Gf.Vec3d(0, 0, 0 if name == "base" else -size[2] / 2))
        shape.AddScaleOp().Set(Gf.Vec3f(*size))
        UsdPhysics.CollisionAPI.Apply(shape.GetPrim())

    def hinge(name, parent, child, at):
        joint = UsdPhysics.RevoluteJoint.Define(stage, f"/Dog/{name}")
        joint.CreateBody0Rel().SetTargets([f"/Dog/{parent}"])
        joint.CreateBody1Rel().SetTargets([f"/Dog/{child}"])
        joint.CreateLocalPos0Attr(Gf.Vec3f(*at))
        joint.CreateAxisAttr("Y")
        joint.CreateLowerLimitAttr(-90.0)
        joint.CreateUpperLimitAttr(90.0)

    link("base", (0, 0, 0), (0.5, 0.25, 0.1), 12.0)
    for leg, x, y in (("LF", 0.22, 0.15), ("RF", 0.22, -0.15), ("LH", -0.22, 0.15), ("RH", -0.22, -0.15)):
        link(f"{leg}_THIGH", (x, y, 0), (0.03, 0.03, 0.2), 0.6)
        link(f"{leg}_FOOT", (x, y, -0.25), (0.03, 0.03, 0.2), 0.3)
        hinge(f"{leg}_HFE", "base", f"{leg}_THIGH", (x, y, 0))
        hinge(f"{leg}_KFE", f"{leg}_THIGH", f"{leg}_FOOT", (0, 0, -0.25))
    stage.Save()


def _on_the_flat(cfg):
    """What the package's own flat variants change: a plane, and no rays that measure a terrain."""
    cfg.scene.terrain.terrain_type = "plane"
    cfg.scene.terrain.terrain_generator = None
    cfg.scene.height_scanner = None
    cfg.observations.policy.height_scan = None
    cfg.curriculum.terrain_levels = None
    return cfg


def test_isaac_labs_velocity_task_runs_on_the_flat_with_a_robot_of_ones_own(isaaclab_task_ids, tmp_path):
    _author_quadruped(tmp_path / "dog.usda")
    module = importlib.import_module(f"{TASKS_ROOT}.{VELOCITY.replace('/', '.')}.velocity_env_cfg")
    cfg = _on_the_flat(module.LocomotionVelocityRoughEnvCfg())
    cfg.scene.robot = ArticulationCfg(
        prim_path="{ENV_REGEX_NS}/Robot",
        spawn=sim_utils.UsdFileCfg(usd_path=str(tmp_path / "dog.usda"), activate_contact_sensors=True),
        init_state=ArticulationCfg.InitialStateCfg(pos=(0.0, 0.0, 0.5)),
        actuators={
            "legs": DelayedPDActuatorCfg(
                joint_names_expr=[".*"], stiffness=40.0, damping=2.0, effort_limit=40.0, min_delay=0, max_delay=4
            )
        },
    )
    joints = 8
    _run(cfg, joints, 12 + 3 * joints, lambda cfg: ManagerBasedRLEnv(cfg))


@pytest.mark.parametrize(("task", "num_actions", "num_observations"), TASKS, ids=[task[0] for task in TASKS])
def test_an_isaac_lab_task_runs_after_renaming_its_import_root(isaaclab_task_ids, task, num_actions, num_observations):
    assert task in isaaclab_task_ids
    cfg = load_cfg_from_registry(task, "env_cfg_entry_point")
    _run(cfg, num_actions, num_observations, lambda cfg: gym.make(task, cfg=cfg).unwrapped)


def _run(cfg, num_actions, num_observations, make):
    """Make the environment and step random actions; everything stays finite and has the sizes expected."""
    cfg.scene.num_envs = NUM_ENVS
    cfg.sim.device = "cpu"
    cfg.seed = 7
    env = make(cfg)
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
