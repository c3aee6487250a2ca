"""Two fields of a scene at one prim path are one thing, as in Isaac Lab."""

import pytest
import torch

import lift_lab.sim as sim_utils
from lift_lab.assets import AssetBaseCfg, RigidObjectCfg
from lift_lab.scene import InteractiveScene, InteractiveSceneCfg
from lift_lab.utils import configclass
from lift_lab.utils.errors import ConfigError


def _ball(name: str) -> RigidObjectCfg:
    return RigidObjectCfg(
        prim_path=f"{{ENV_REGEX_NS}}/{name}",
        spawn=sim_utils.SphereCfg(
            radius=0.1,
            rigid_props=sim_utils.RigidBodyPropertiesCfg(),
            collision_props=sim_utils.CollisionPropertiesCfg(),
        ),
    )


def _start(cfg: InteractiveSceneCfg):
    sim = sim_utils.SimulationContext(sim_utils.SimulationCfg(device="cpu", gravity=(0.0, 0.0, 0.0)))
    scene = InteractiveScene(cfg)
    sim.reset()
    return sim, scene


@configclass
class _KeptCfg(InteractiveSceneCfg):
    _first = _ball("Ball")
    _first.init_state.pos = (0.0, 0.0, 1.0)
    ball = _first
    other = _ball("Other")
    light = AssetBaseCfg(prim_path="/World/light", spawn=sim_utils.DomeLightCfg())
    lamp = AssetBaseCfg(prim_path="/World/light", spawn=sim_utils.DomeLightCfg(intensity=1.0))


def test_a_config_kept_for_the_next_line_of_a_class_is_not_a_second_asset():
    sim, scene = _start(_KeptCfg(num_envs=2, env_spacing=1.0))
    assert sim.model.nbody == 3  # the world, the ball and the other
    assert list(scene.rigid_objects) == ["ball", "other"]
    assert scene["_first"] is scene["ball"]
    sim.step()  # two balls at one place would push each other away
    scene.update(sim.get_physics_dt())
    torch.testing.assert_close(scene["ball"].data.root_pos_w - scene.env_origins, torch.tensor([[0.0, 0.0, 1.0]] * 2))


def test_two_different_assets_at_one_prim_path_are_named():
    cfg = _KeptCfg(num_envs=1, env_spacing=1.0)
    cfg.ball.init_state.pos = (1.0, 0.0, 1.0)
    with pytest.raises(ConfigError, match=r"scene\._first and scene\.ball are two different assets at '.*/Ball'"):
        _start(cfg)


def test_what_a_scene_never_holds_is_empty():
    _, scene = _start(_KeptCfg(num_envs=1, env_spacing=1.0))
    assert scene.rigid_object_collections == {}
    assert scene.surface_grippers == {}
