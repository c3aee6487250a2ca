"""Contact margins of one environment hold a body of one or of several colliders above the table, on both engines."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Literal, cast

import pytest
import torch
from pxr import Usd, UsdGeom, UsdPhysics

import lift_lab.sim as sim_utils
from lift_lab.assets import AssetBaseCfg, RigidObjectCfg
from lift_lab.envs import ManagerBasedEnv, mdp
from lift_lab.managers import SceneEntityCfg
from lift_lab.scene import InteractiveScene, InteractiveSceneCfg
from lift_lab.utils import configclass

RADIUS, MARGIN = 0.02, 0.04


@configclass
class _SceneCfg(InteractiveSceneCfg):
    ground: AssetBaseCfg = AssetBaseCfg(prim_path="/World/ground", spawn=sim_utils.GroundPlaneCfg())
    body: RigidObjectCfg | None = None


def _write_spheres(path: Path, count: int) -> str:
    """Write a body of spheres side by side."""
    stage = Usd.Stage.CreateNew(str(path))
    UsdGeom.SetStageMetersPerUnit(stage, 1)
    UsdGeom.SetStageUpAxis(stage, "Z")
    body = UsdGeom.Xform.Define(stage, "/Body").GetPrim()
    stage.SetDefaultPrim(body)
    UsdPhysics.RigidBodyAPI.Apply(body)
    UsdPhysics.MassAPI.Apply(body).CreateMassAttr(0.1)
    for i in range(count):
        sphere = UsdGeom.Sphere.Define(stage, f"/Body/s{i}")
        sphere.CreateRadiusAttr(RADIUS)
        sphere.AddTranslateOp().Set((0.05 * (i % 3), 0.05 * (i // 3), 0.0))
        UsdPhysics.CollisionAPI.Apply(sphere.GetPrim())
    stage.Save()
    return str(path)


@pytest.fixture
def scene(tmp_path: Path) -> Iterator[Callable[..., InteractiveScene]]:
    made: list[InteractiveScene] = []

    def make(engine: Literal["native", "warp"], count: int) -> InteractiveScene:
        sim = sim_utils.SimulationContext(sim_utils.SimulationCfg(device="cpu", physics=engine, dt=0.002))
        spawn = sim_utils.UsdFileCfg(usd_path=_write_spheres(tmp_path / "body.usda", count))
        state = RigidObjectCfg.InitialStateCfg(pos=(0.0, 0.0, RADIUS + MARGIN))
        body = RigidObjectCfg(prim_path="{ENV_REGEX_NS}/Body", spawn=spawn, init_state=state)
        made.append(InteractiveScene(_SceneCfg(num_envs=2, env_spacing=3.0, body=body)))
        sim.reset()
        made[-1].update(0.0)
        return made[-1]

    yield make
    for one in made:
        one.sim.close()


def _rest_heights(scene: InteractiveScene) -> list[float]:
    """Let the bodies fall and come to rest."""
    scene.sim.physics.step(200)
    scene.update(0.4)
    return scene["body"].data.root_pos_w[:, 2].tolist()


@pytest.mark.parametrize(("engine", "count"), [("native", 1), ("native", 6), ("warp", 6)])
def test_a_margin_of_one_environment_lifts_its_body_only(scene, engine, count):
    ours = scene(engine, count)
    ours.sim.physics.step(1)
    ours["body"].write_collider_margin_to_sim(torch.tensor([MARGIN]), env_ids=torch.tensor([1]))
    assert _rest_heights(ours) == pytest.approx([RADIUS, RADIUS + MARGIN], abs=1e-3)


@pytest.mark.parametrize("engine", ["native", "warp"])
def test_the_event_term_sets_margins_of_a_body_with_several_colliders(scene, engine):
    ours = scene(engine, 6)
    env = cast(ManagerBasedEnv, SimpleNamespace(scene=ours, num_envs=2, device="cpu"))
    asset = SceneEntityCfg("body")
    asset.resolve(ours)
    margins = (MARGIN, MARGIN)
    mdp.randomize_rigid_body_collider_offsets(env, torch.tensor([1]), asset, rest_offset_distribution_params=margins)
    assert _rest_heights(ours) == pytest.approx([RADIUS, RADIUS + MARGIN], abs=1e-3)
