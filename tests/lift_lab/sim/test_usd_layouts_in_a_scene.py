"""Layouts of other importers' USD files in a running scene, on both engines."""

from __future__ import annotations

import pytest
import torch

import lift_lab.sim as sim_utils
from lift_lab.assets import ArticulationCfg, AssetBaseCfg
from lift_lab.scene import InteractiveScene, InteractiveSceneCfg
from lift_lab.utils import configclass

USD = """#usda 1.0
(
    defaultPrim = "box"
    metersPerUnit = 1
    upAxis = "Z"
)
class Xform "shapes"
{
    def Cube "cube"
    {
        double size = 0.2
    }
}
def Xform "box"
{
    def Xform "base" (prepend apiSchemas = ["PhysicsRigidBodyAPI", "PhysicsMassAPI"])
    {
        float physics:mass = 2
        def Xform "collisions" (
            prepend apiSchemas = ["PhysicsCollisionAPI"]
            instanceable = true
            prepend references = </shapes>
        )
        {
        }
        def PhysicsFixedJoint "frame_joint"
        {
            rel physics:body0 = </box/base>
            rel physics:body1 = </box/frame>
            point3f physics:localPos0 = (0, 0, 0.3)
        }
    }
    def Xform "frame" (prepend apiSchemas = ["PhysicsRigidBodyAPI", "PhysicsMassAPI", "NewtonMassAPI"])
    {
        double[] newton:inertia = [0, 0, 0, 0, 0, 0]
        float physics:mass = 1e-9
        double3 xformOp:translate = (0, 0, 0.3)
        uniform token[] xformOpOrder = ["xformOp:translate"]
    }
}
"""


@pytest.mark.parametrize("physics", ["native", pytest.param("warp", marks=pytest.mark.slow)])
def test_inherited_colliders_and_massless_frames_live_in_a_scene(tmp_path, physics):
    """A box of 0.2 m, whose CollisionAPI is on an instanced Xform, rests on the ground with its frame above it."""
    path = tmp_path / "box.usda"
    path.write_text(USD)

    @configclass
    class SceneCfg(InteractiveSceneCfg):
        ground = AssetBaseCfg(prim_path="/World/ground", spawn=sim_utils.GroundPlaneCfg())
        box = ArticulationCfg(
            prim_path="{ENV_REGEX_NS}/Box",
            spawn=sim_utils.UsdFileCfg(usd_path=str(path)),
            init_state=ArticulationCfg.InitialStateCfg(pos=(0.0, 0.0, 0.12)),
            actuators={},
        )

    sim = sim_utils.SimulationContext(sim_utils.SimulationCfg(device="cpu", dt=0.005, physics=physics))
    scene = InteractiveScene(SceneCfg(num_envs=2, env_spacing=2.0))
    sim.reset()
    for _ in range(80):
        sim.step()
        scene.update(0.005)
    expected = torch.tensor([[0.1, 0.4]]).repeat(2, 1)
    torch.testing.assert_close(sim.physics.field("xpos")[:, -2:, 2], expected, atol=2e-3, rtol=0)
    sim.close()
