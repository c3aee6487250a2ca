"""Settings that an engine would change are errors, and those that it does not use are reported."""

from __future__ import annotations

import dataclasses

import mujoco
import numpy as np
import pytest

import lift_lab.sim as sim_utils
from lift_lab.sim.engine_settings import WARP_LEAST_TOLERANCE
from lift_lab.sim.ignored import ignored_settings
from lift_lab.sim.physics import make_physics
from lift_lab.utils.errors import ConfigError

_MODEL = """
<mujoco><worldbody><geom type="plane" size="1 1 1"/>
<body pos="0 0 0.2"><freejoint/><geom size="0.1"/></body></worldbody></mujoco>
"""


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
    assert changed == {"tolerance": [pytest.approx(WARP_LEAST_TOLERANCE)]}
    assert physics.model.opt.tolerance == WARP_LEAST_TOLERANCE  # the model tells what runs
