"""Simulation options in an asset's file: the scene's hold, the report says so, MuJoCo prints nothing."""

from __future__ import annotations

import logging

import mujoco
import numpy as np
import pytest
from pxr import Gf, Sdf, Usd, UsdGeom, UsdPhysics

import lift_lab.sim as sim_utils
from lift_lab.assets import RigidObjectCfg
from lift_lab.scene import InteractiveScene, InteractiveSceneCfg
from lift_lab.sim.spawners.spawner_cfg import RigidObjectSpawnerCfg, Spawned
from lift_lab.usd import load
from lift_lab.utils import configclass

_TYPES = Sdf.ValueTypeNames


@configclass
class _SceneCfg(InteractiveSceneCfg):
    body: RigidObjectCfg | None = None


def _ball(path, **attributes):
    """A ball with a physics scene of its own; attributes as (type, value)."""
    stage = Usd.Stage.CreateNew(str(path))
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    UsdGeom.SetStageUpAxis(stage, "Z")
    body = UsdGeom.Xform.Define(stage, "/Ball").GetPrim()
    stage.SetDefaultPrim(body)
    UsdPhysics.RigidBodyAPI.Apply(body)
    UsdPhysics.MassAPI.Apply(body).CreateMassAttr(0.1)
    sphere = UsdGeom.Sphere.Define(stage, "/Ball/shape")
    sphere.CreateRadiusAttr(0.02)
    UsdPhysics.CollisionAPI.Apply(sphere.GetPrim())
    scene = UsdPhysics.Scene.Define(stage, "/Ball/Scene").GetPrim()
    scene.AddAppliedSchema("MjcSceneAPI")
    for name, (kind, value) in attributes.items():
        name = name.replace("__", ":")
        attribute = scene.GetAttribute(name)
        (attribute if attribute else scene.CreateAttribute(name, kind)).Set(value)
    stage.Save()
    return str(path)


def _start(spawn, **settings):
    cfg = sim_utils.SimulationCfg(device="cpu", dt=0.002, **settings)
    sim = sim_utils.SimulationContext(cfg)
    body = RigidObjectCfg(prim_path="{ENV_REGEX_NS}/Body", spawn=spawn)
    scene = InteractiveScene(_SceneCfg(num_envs=2, env_spacing=2.0, body=body))
    sim.reset()
    return sim, scene


_ALL = {
    "physics__gravityMagnitude": (_TYPES.Float, 3.0),
    "mjc__option__timestep": (_TYPES.Double, 0.005),
    "mjc__option__integrator": (_TYPES.Token, "rk4"),
    "mjc__option__cone": (_TYPES.Token, "elliptic"),
    "mjc__option__impratio": (_TYPES.Double, 7.0),
    "mjc__option__density": (_TYPES.Double, 1.2),
    "mjc__flag__contact": (_TYPES.Bool, False),
}


@pytest.fixture
def ball(tmp_path):
    return _ball(tmp_path / "ball.usda", **_ALL)


def test_the_options_of_the_scene_hold_and_nothing_is_printed(ball, capfd, recwarn):
    alone = load(ball)[0].option
    assert (alone.timestep, alone.cone, alone.density) == (0.005, int(mujoco.mjtCone.mjCONE_ELLIPTIC), 1.2)
    sim, _ = _start(sim_utils.UsdFileCfg(usd_path=ball), gravity=(0.0, 0.0, -9.0))
    blank = mujoco.MjSpec().option
    option = sim.model.opt
    assert (option.timestep, option.impratio, option.density) == (0.002, 1.0, blank.density)
    assert option.integrator == int(mujoco.mjtIntegrator.mjINT_IMPLICITFAST)
    assert option.cone == int(mujoco.mjtCone.mjCONE_PYRAMIDAL)
    np.testing.assert_allclose(option.gravity, [0.0, 0.0, -9.0])
    assert not option.disableflags & int(mujoco.mjtDisableBit.mjDSBL_CONTACT)
    out, err = capfd.readouterr()
    assert "conflict" not in out + err
    assert not [w for w in recwarn if "conflict" in str(w.message)]


def test_the_import_report_and_one_log_line_name_every_option_that_does_not_hold(ball, caplog):
    with caplog.at_level(logging.WARNING, "lift_lab.sim.spawners.file_options"):
        _, scene = _start(sim_utils.UsdFileCfg(usd_path=ball))
    notes = {note.attribute: (note.prim_path, note.reason) for note in scene["body"].spawned.report.ignored}
    names = {name.replace("__", ":") for name in _ALL}
    assert names <= set(notes)
    assert {notes[name][0] for name in names} == {"/Ball/Scene"}
    assert notes["mjc:option:timestep"][1] == "0.005 here; in a scene sim.dt (0.002) holds"
    assert notes["mjc:option:cone"][1] == "elliptic here; in a scene sim.mujoco.cone (pyramidal) holds"
    assert notes["mjc:option:density"][1] == "1.2 here; in a scene MuJoCo's default (0) holds"
    assert notes["mjc:flag:contact"][1] == "off here; in a scene MuJoCo's default (on) holds"
    (line,) = caplog.messages
    assert line.startswith("scene.body: options of its file do not hold in a scene")
    assert all(name in line for name in names)


def test_options_that_agree_with_the_scene_are_no_news(tmp_path, caplog):
    agreeing = {
        "physics__gravityMagnitude": (_TYPES.Float, 9.81),
        "physics__gravityDirection": (_TYPES.Vector3f, Gf.Vec3f(0, 0, -1)),
        "mjc__option__timestep": (_TYPES.Double, 0.002),
        "mjc__option__integrator": (_TYPES.Token, "implicitfast"),
        "mjc__flag__contact": (_TYPES.Bool, True),
    }
    path = _ball(tmp_path / "ball.usda", **agreeing)
    with caplog.at_level(logging.WARNING, "lift_lab.sim.spawners.file_options"):
        _, scene = _start(sim_utils.UsdFileCfg(usd_path=path))
    assert not caplog.messages
    assert not [note for note in scene["body"].spawned.report.ignored if "in a scene" in note.reason]


def test_keyframes_stay_behind_and_the_report_says_so(tmp_path, capfd):
    path = _ball(tmp_path / "ball.usda")
    stage = Usd.Stage.Open(path)
    key = stage.DefinePrim("/Ball/home", "MjcKeyframe")
    key.CreateAttribute("mjc:qpos", _TYPES.DoubleArray).Set([0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 0.0])
    stage.Save()
    assert load(path)[0].compile().nkey == 1
    sim, scene = _start(sim_utils.UsdFileCfg(usd_path=path))
    assert sim.model.nkey == 0
    notes = [(n.prim_path, n.reason) for n in scene["body"].spawned.report.ignored if n.attribute == "MjcKeyframe"]
    assert notes == [("/Ball/home", "in a scene init_state holds")]
    out, err = capfd.readouterr()
    assert "WARNING: " not in out + err


def _from_mjcf(prim_path, cfg):
    return Spawned(
        mujoco.MjSpec.from_string(
            '<mujoco><option timestep="0.01" wind="1 0 0"/><visual><map znear="0.3"/></visual><size memory="3M"/>'
            '<worldbody><body name="Body"><freejoint/><geom size="0.1"/></body></worldbody></mujoco>'
        )
    )


def test_a_spawner_of_ones_own_brings_options_that_do_not_hold_either(capfd, caplog):
    with caplog.at_level(logging.WARNING, "lift_lab.sim.spawners.file_options"):
        sim, _ = _start(RigidObjectSpawnerCfg(func=_from_mjcf))
    assert sim.model.opt.timestep == 0.002
    np.testing.assert_allclose(sim.model.opt.wind, 0.0)
    (line,) = caplog.messages
    assert "timestep 0.01 (here 0.002)" in line
    assert "wind 1 0 0 (here 0 0 0)" in line
    out, err = capfd.readouterr()
    assert "conflict" not in out + err
