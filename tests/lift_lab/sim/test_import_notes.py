"""What an asset loses reaches the log when a spawner loads it."""

from __future__ import annotations

import logging

import pytest

import lift_lab.sim as sim_utils
from lift_lab.usd import load
from lift_lab_assets.files import ASSETS_USD_DIR

USD = """#usda 1.0
(
    defaultPrim = "robot"
    metersPerUnit = 1
    upAxis = "Z"
)
def Xform "robot"
{{
    def Cube "base" (prepend apiSchemas = ["PhysicsRigidBodyAPI", {collision}])
    {{
        double size = 0.2
        float physxRigidBody:linearDamping = 0.5
        float physxRigidBody:sleepThreshold = 0.5
    }}
    def RevolutePhysicsJoint "hinge"
    {{
        rel physics:body0 = </robot/base>
    }}
}}
"""


@pytest.fixture
def warnings(caplog):
    """Messages at WARNING since the last call."""

    def since() -> list[str]:
        found = [record.getMessage() for record in caplog.records if record.levelno >= logging.WARNING]
        caplog.clear()
        return found

    return since


def test_what_a_file_loses_is_logged_once_a_kind(tmp_path, warnings):
    path = tmp_path / "robot.usda"
    path.write_text(USD.format(collision=""))
    cfg = sim_utils.UsdFileCfg(usd_path=str(path))
    cfg.func("/World/envs/env_0/Robot", cfg)
    found = warnings()
    assert len(found) == 4
    assert all("/World/envs/env_0/Robot" in line and str(path) in line and "\n" not in line for line in found)
    for line, part in zip(
        found,
        (
            "linearDamping on </robot/base>",
            "RevolutePhysicsJoint on </robot/hinge>",
            "physics:mass",
            "nothing can touch: base",
        ),
        strict=True,
    ):
        assert part in line
    cfg.func("/World/envs/env_0/Other", cfg)
    assert warnings() == []


def test_a_file_that_loses_nothing_is_silent(tmp_path, warnings):
    path = tmp_path / "robot.usda"
    text = USD.format(collision='"PhysicsCollisionAPI"').replace("linearDamping", "maxLinearVelocity")
    path.write_text(text.replace("RevolutePhysicsJoint", "Scope").replace("rel physics:body0 = </robot/base>", ""))
    cfg = sim_utils.UsdFileCfg(usd_path=str(path))
    cfg.func("/World/Robot", cfg)
    assert warnings() == []


@pytest.mark.parametrize("name", sorted(path.name for path in ASSETS_USD_DIR.glob("*.usd*")))
def test_the_assets_that_ship_lose_nothing(name):
    assert load(ASSETS_USD_DIR / name)[1].summary() == []


@pytest.mark.parametrize(
    ("shape", "settings"),
    [
        (sim_utils.CuboidCfg, {"size": (0.1, 0.1, 0.1)}),
        (sim_utils.SphereCfg, {"radius": 0.1}),
        (sim_utils.CapsuleCfg, {"radius": 0.1, "height": 0.1}),
        (sim_utils.CylinderCfg, {"radius": 0.1, "height": 0.1}),
        (sim_utils.MeshCuboidCfg, {"size": (0.1, 0.1, 0.1)}),
    ],
)
def test_a_rigid_shape_without_collider_is_named(shape, settings, warnings):
    name = f"{{ENV_REGEX_NS}}/{shape.__name__}"
    rigid = {"rigid_props": sim_utils.RigidBodyPropertiesCfg(), "mass_props": sim_utils.MassPropertiesCfg(mass=1.0)}
    cfg = shape(**settings, **rigid)
    cfg.func(name, cfg)
    (line,) = [line for line in warnings() if "without a collider" in line]
    assert name in line
    # A picture that does not move, and a body whose colliders are there or switched off, are meant so.
    for meant in ({}, {**rigid, "collision_props": sim_utils.CollisionPropertiesCfg(collision_enabled=False)}):
        cfg = shape(**settings, **meant)
        cfg.func(f"{name}Meant", cfg)
        assert warnings() == []


def test_a_shapes_material_that_the_model_has_inexactly_is_logged(warnings):
    material = sim_utils.RigidBodyMaterialCfg(static_friction=1.0, dynamic_friction=0.5, restitution=0.5)
    cfg = sim_utils.CuboidCfg(
        size=(0.1, 0.1, 0.1), physics_material=material, collision_props=sim_utils.CollisionPropertiesCfg()
    )
    cfg.func("/World/TwoFrictions", cfg)
    (line,) = warnings()  # the restitution is among the ignored settings of the environment
    assert "dynamic friction 0.5 is used, not 1" in line
