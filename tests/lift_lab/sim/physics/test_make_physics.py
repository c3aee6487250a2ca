"""Choosing an engine."""

from __future__ import annotations

import subprocess
import sys

import mujoco
import pytest

from lift_lab.sim.physics import RANDOMIZABLE_FIELDS, make_physics
from lift_lab.sim.physics.base import DERIVED_FIELDS, STATE_FIELDS
from lift_lab.utils.errors import ConfigError, PhysicsError


def test_the_cpu_runs_native_without_importing_warp():
    code = (
        "import sys, mujoco, lift_lab.sim.physics as p;"
        "m = mujoco.MjModel.from_xml_string('<mujoco/>');"
        "assert p.make_physics(m, 2).name == 'native';"
        "assert not {'warp', 'mujoco_warp'} & set(sys.modules)"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"kind": "natvie"}, "unknown physics 'natvie'.*'native'"),
        ({"device": "cuda:0", "kind": "native"}, "native physics runs on device 'cpu', not 'cuda:0'"),
        ({"num_envs": 0}, "num_envs must be at least 1, got 0"),
        ({"num_threads": 0}, "num_threads must be at least 1, got 0"),
        ({"kind": "warp", "njmax": 0}, "njmax must be at least 1, got 0"),
    ],
)
def test_wrong_options_are_refused(model: mujoco.MjModel, options: dict, message: str):
    with pytest.raises(ConfigError, match=message):
        make_physics(model, **{"num_envs": 2, **options})


def test_a_feature_that_warp_lacks_is_named():
    model = mujoco.MjModel.from_xml_string("<mujoco><option solver='PGS'/></mujoco>")
    with pytest.raises(PhysicsError, match=r"warp physics cannot run this model: .*PGS.*; choose physics 'native'"):
        make_physics(model, 1, kind="warp")


def test_the_callers_model_is_left_alone(model: mujoco.MjModel):
    physics = make_physics(model, 1)
    assert not model.opt.disableflags & mujoco.mjtDisableBit.mjDSBL_AUTORESET
    assert physics.model is not model


def test_every_listed_field_exists_in_both_engines(model: mujoco.MjModel):
    import mujoco_warp
    from mujoco.batch import DATA_FIELDS, MODEL_FIELDS

    in_warp = {f.name for f in __import__("dataclasses").fields(mujoco_warp.Data)}
    for name in (*STATE_FIELDS, *DERIVED_FIELDS):
        assert name in DATA_FIELDS
        assert name in in_warp
    for name in RANDOMIZABLE_FIELDS:
        assert name in MODEL_FIELDS
