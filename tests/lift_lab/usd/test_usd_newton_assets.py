"""USD files that others wrote: those in the newton wheel, read in place where LIFT_LAB_NEWTON_ASSETS points to it."""

from __future__ import annotations

import os
from pathlib import Path

import mujoco
import numpy as np
import pytest

from lift_lab.usd import load

ROOT = os.environ.get("LIFT_LAB_NEWTON_ASSETS", "")
pytestmark = pytest.mark.skipif(not ROOT, reason="LIFT_LAB_NEWTON_ASSETS names no folder with newton's USD files")


def _file(name: str) -> Path:
    found = sorted(Path(ROOT).rglob(name))
    if not found:
        pytest.skip(f"no {name} under LIFT_LAB_NEWTON_ASSETS")
    return found[-1]


def _model(name: str):
    spec, report = load(_file(name))
    return spec.compile(), report


def test_every_file_imports_and_compiles():
    files = sorted(p for p in Path(ROOT).rglob("*.usd*") if p.name != "ant_multi.usda")
    assert len(files) > 10
    for path in files:
        spec, _ = load(path)
        model = spec.compile()
        data = mujoco.MjData(model)
        mujoco.mj_forward(model, data)
        assert np.isfinite(data.qacc).all(), path


@pytest.mark.parametrize(
    ("name", "nv", "nu"),
    [("cartpole.usda", 2, 0), ("ant.usda", 14, 8), ("humanoid.usda", 27, 16), ("humanoid_mjc.usda", 27, 21)],
)
def test_well_known_robots_have_their_degrees_of_freedom(name, nv, nu):
    model, _ = _model(name)
    assert (model.nv, model.nu) == (nv, nu)


def test_sixty_four_ants_are_sixty_four_equal_trees():
    model, report = _model("ant_multi.usda")
    assert (model.nv, len(report.root_bodies)) == (64 * 14, 64)
    masses = model.body_subtreemass[[model.body(name).id for name in report.root_bodies]]
    np.testing.assert_allclose(masses, masses[0], rtol=1e-6)


def test_the_four_bar_closes_its_loop():
    model, _ = _model("boxes_fourbar.usda")
    assert model.eq_type.tolist() == [int(mujoco.mjtEq.mjEQ_CONNECT)] * 2
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    assert np.abs(data.efc_pos[: data.ne]).max() < 1e-4


def test_a_revolute_and_the_equivalent_d6_pendulum_have_the_same_dynamics():
    model, _ = _model("pendulum_revolute_vs_d6.usda")
    hinges = [i for i in range(model.njnt) if model.jnt_type[i] == mujoco.mjtJoint.mjJNT_HINGE]
    if len(hinges) == 2:
        a, b = hinges
        np.testing.assert_allclose(model.jnt_range[a], model.jnt_range[b], atol=1e-6)


def test_mirrored_meshes_weigh_the_same():
    model, _ = _model("negative_scale_mesh_pair.usda")
    assert model.body_mass[1] == pytest.approx(model.body_mass[2], rel=1e-6)
    np.testing.assert_allclose(model.body_inertia[1], model.body_inertia[2], rtol=1e-5)
