"""Engines are found by name, and say themselves which settings they honour."""

from __future__ import annotations

import dataclasses

import gymnasium as gym
import mujoco
import numpy as np
import pytest

import lift_lab.sim as sim_utils
import lift_lab_tasks  # noqa: F401
from lift_lab.sim.engines import engine_class, engine_names
from lift_lab.sim.ignored import ignored_settings
from lift_lab.sim.physics import make_physics
from lift_lab.sim.physics.native import NativePhysics
from lift_lab.sim.physics.warp import LEAST_TOLERANCE
from lift_lab.utils.errors import ConfigError, StateMismatchError
from lift_lab_rl.rsl_rl import LiftLabRunner, RslRlVecEnvWrapper, to_rsl_rl
from lift_lab_tasks.utils import load_cfg_from_registry, parse_env_cfg

_MODEL = """
<mujoco><worldbody><geom type="plane" size="1 1 1"/>
<body pos="0 0 0.2"><freejoint/><geom size="0.1"/></body></worldbody></mujoco>
"""


@pytest.fixture
def packages(tmp_path, monkeypatch):
    """Installs packages that add an engine: folders with the entry points of a distribution."""

    class Packages:
        def add(self, name, place):
            folder = tmp_path / f"{name}_engine-1.0.dist-info"
            folder.mkdir()
            (folder / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}-engine\nVersion: 1.0\n")
            (folder / "entry_points.txt").write_text(f"[lift_lab.physics]\n{name} = {place}\n")

    monkeypatch.syspath_prepend(str(tmp_path))
    return Packages()


def _context(physics, num_threads=None, **mujoco_settings):
    cfg = sim_utils.SimulationCfg(device="cpu", physics=physics, num_threads=num_threads)
    cfg.mujoco = sim_utils.MujocoCfg(**mujoco_settings)
    return sim_utils.SimulationContext(cfg)


def test_a_tolerance_that_warp_would_raise_is_refused_there_and_taken_elsewhere():
    with pytest.raises(ConfigError, match=r"sim\.mujoco\.tolerance: .* would raise 1e-09 to 1e-06; set 1e-06 or more"):
        _context("warp", tolerance=1e-9)
    for physics, tolerance in (("warp", 1e-6), ("warp", 1e-4), ("native", 1e-9)):
        spec = mujoco.MjSpec()
        _context(physics, tolerance=tolerance).configure(spec)
        assert spec.option.tolerance == tolerance


def test_a_solver_that_warp_lacks_is_refused_before_anything_is_built():
    with pytest.raises(ConfigError, match=r"sim\.mujoco\.solver: .* no 'PGS'; choose one of CG, Newton"):
        _context("warp", solver="PGS")
    _context("native", solver="PGS")


@pytest.mark.parametrize(
    ("physics", "settings", "path"),
    [
        ("native", {"nconmax": 7}, "sim.mujoco.nconmax"),
        ("native", {"njmax": 7}, "sim.mujoco.njmax"),
        ("warp", {"num_threads": 1}, "sim.num_threads"),
    ],
)
def test_settings_without_effect_are_reported(physics, settings, path, monkeypatch):
    monkeypatch.setattr("lift_lab.sim.ignored._pending", {})
    monkeypatch.setattr("lift_lab.sim.ignored._reported", {})
    _context(physics)
    assert path not in ignored_settings()
    _context(physics, **settings)
    assert path in ignored_settings()


def test_warp_holds_every_option_as_it_is_set_but_the_tolerance():
    """If mujoco_warp comes to change another one, this names it."""
    model = mujoco.MjModel.from_xml_string(_MODEL)
    option = model.opt
    option.timestep, option.gravity, option.wind, option.magnetic = 0.003, (0.1, 0.2, -3.0), (1, 2, 3), (0.4, 0.5, 0.6)
    option.density, option.viscosity, option.impratio = 1.3, 0.01, 1e-3
    option.tolerance, option.ls_tolerance, option.noslip_tolerance, option.ccd_tolerance = 1e-9, 1e-5, 1e-9, 1e-9
    option.iterations, option.ls_iterations, option.ccd_iterations = 1000, 77, 99
    option.cone, option.solver = mujoco.mjtCone.mjCONE_ELLIPTIC, mujoco.mjtSolver.mjSOL_CG
    option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICIT
    option.disableflags = int(mujoco.mjtDisableBit.mjDSBL_EULERDAMP | mujoco.mjtDisableBit.mjDSBL_ISLAND)
    physics = make_physics(model, 1, kind="warp")
    on_device, changed = physics._m.opt, {}
    for field in dataclasses.fields(on_device):
        if not hasattr(option, field.name) and field.name != "impratio_invsqrt":
            continue
        found = getattr(on_device, field.name)
        found = np.ravel(found.numpy() if hasattr(found, "numpy") else found)
        wanted = 1 / np.sqrt(option.impratio) if field.name == "impratio_invsqrt" else getattr(option, field.name)
        if not np.allclose(found, wanted, rtol=1e-6, atol=0):
            changed[field.name] = found.tolist()
    assert changed == {"tolerance": [pytest.approx(LEAST_TOLERANCE)]}
    assert physics.model.opt.tolerance == LEAST_TOLERANCE  # the model tells what runs


class ThirdPhysics(NativePhysics):
    """An engine of another package, with a setting of its own."""

    name = "third"

    @classmethod
    def options_of(cls, cfg):
        return {"num_threads": 1}


def test_an_engine_of_another_package_trains_a_task(packages):
    packages.add("third", f"{__name__}:ThirdPhysics")
    assert engine_names() == ["native", "warp", "third"]
    cfg = parse_env_cfg("Cartpole", "cpu", 4)
    cfg.seed, cfg.sim.physics = 1, "third"
    env = gym.make("Cartpole", cfg=cfg)
    assert type(env.unwrapped.sim.physics) is ThirdPhysics
    agent_cfg = load_cfg_from_registry("Cartpole", "rsl_rl_cfg_entry_point")
    agent_cfg.device = "cpu"
    wrapped = RslRlVecEnvWrapper(env)
    runner = LiftLabRunner(wrapped, to_rsl_rl(agent_cfg, wrapped.get_observations().keys()))
    assert runner.learn(1)
    state = env.unwrapped.sim.physics.state_dict()
    env.unwrapped.sim.physics.load_state_dict(state)
    with pytest.raises(StateMismatchError, match="the saved state is of the engine 'native', this is 'third'"):
        env.unwrapped.sim.physics.load_state_dict(state | {"engine": "native"})
    env.close()


def test_an_unknown_engine_is_one_error_with_the_choices(packages):
    packages.add("third", "somewhere:Third")
    cfg = sim_utils.SimulationCfg(device="cpu", physics="thrid")
    with pytest.raises(
        ConfigError, match=r"^sim\.physics is 'thrid'; it must be one of 'native', 'warp', 'third', or null$"
    ):
        sim_utils.SimulationContext(cfg)
    with pytest.raises(ConfigError, match=r"^unknown physics 'thrid'; did you mean 'third'\?$"):
        engine_class("thrid", "cpu")
    with pytest.raises(
        ConfigError, match=r"^no physics engine is the default on device 'mps'; name one in sim\.physics$"
    ):
        engine_class(None, "mps")


@pytest.mark.parametrize(
    ("place", "message"),
    [
        ("nowhere_at_all:Third", "from 'nowhere_at_all:Third': ModuleNotFoundError: No module named"),
        (f"{__name__}:Missing", "AttributeError: module '.*' has no attribute 'Missing'"),
        ("lift_lab.utils.errors:ConfigError", "'lift_lab.utils.errors:ConfigError' is no sub-class of Physics"),
    ],
)
def test_a_broken_entry_point_is_an_error_only_when_it_is_asked_for(packages, place, message):
    packages.add("broken", place)
    assert engine_class(None, "cpu").name == "native"
    with pytest.raises(ConfigError, match=f"^the physics engine 'broken' cannot be loaded.*{message}") as caught:
        engine_class("broken", "cpu")
    assert "\n" not in str(caught.value)


def test_one_name_of_two_packages_is_refused(packages):
    packages.add("warp", "other:Warp")
    with pytest.raises(ConfigError, match=r"^several packages have a physics engine 'warp': .*, other:Warp$"):
        engine_class("warp", "cpu")


def test_an_option_that_an_engine_does_not_have_is_named():
    model = mujoco.MjModel.from_xml_string(_MODEL)
    with pytest.raises(
        ConfigError, match=r"^the physics engine 'native' has no option 'njmax'; choose one of: 'num_thr"
    ):
        make_physics(model, 1, njmax=3)
