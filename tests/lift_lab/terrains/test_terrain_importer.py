"""A scene's terrain is an object with Isaac Lab's attributes, made from the config's class."""

import pytest
import torch

import lift_lab.sim as sim_utils
from lift_lab.assets import RigidObjectCfg
from lift_lab.markers import VisualizationMarkers
from lift_lab.scene import InteractiveScene, InteractiveSceneCfg
from lift_lab.sensors import ContactSensorCfg
from lift_lab.terrains import TerrainImporter, TerrainImporterCfg
from lift_lab.utils import configclass
from lift_lab.utils.errors import ConfigError, UnknownAttributeError


class _Shifted(TerrainImporter):
    """A terrain of a user's own, which puts all environments 5 m higher."""

    def __init__(self, cfg):
        super().__init__(cfg)
        self.env_origins[:, 2] = 5.0


@configclass
class _SceneCfg(InteractiveSceneCfg):
    terrain: TerrainImporterCfg = TerrainImporterCfg(prim_path="/World/ground")
    ball: RigidObjectCfg = RigidObjectCfg(
        prim_path="{ENV_REGEX_NS}/Ball",
        init_state=RigidObjectCfg.InitialStateCfg(pos=(0.0, 0.0, 0.099)),
        spawn=sim_utils.SphereCfg(
            radius=0.1,
            rigid_props=sim_utils.RigidBodyPropertiesCfg(),
            mass_props=sim_utils.MassPropertiesCfg(mass=1.0),
            collision_props=sim_utils.CollisionPropertiesCfg(),
        ),
    )
    contact: ContactSensorCfg = ContactSensorCfg(
        prim_path="{ENV_REGEX_NS}/Ball", filter_prim_paths_expr=["/World/ground"]
    )


@pytest.fixture
def sim():
    sim = sim_utils.SimulationContext(sim_utils.SimulationCfg(device="cpu", physics="native", dt=0.002))
    yield sim
    sim.close()


def _scene(sim, **terrain):
    cfg = _SceneCfg(num_envs=4, env_spacing=3.0)
    for name, value in terrain.items():
        setattr(cfg.terrain, name, value)
    scene = InteractiveScene(cfg)
    sim.reset()
    scene.update(0.0)
    return scene


def test_the_terrain_is_an_importer_and_its_origins_are_the_scene_s(sim):
    scene = _scene(sim)
    terrain = scene.terrain
    assert type(terrain) is TerrainImporter
    assert scene["terrain"] is terrain
    assert terrain.env_origins is scene.env_origins
    corners = torch.tensor([[-1.5, -1.5, 0.0], [-1.5, 1.5, 0.0], [1.5, -1.5, 0.0], [1.5, 1.5, 0.0]])
    torch.testing.assert_close(terrain.env_origins, corners)
    assert (terrain.cfg.terrain_type, terrain.cfg.num_envs, terrain.cfg.env_spacing) == ("plane", 4, 3.0)
    assert scene.cfg.terrain.num_envs == 1  # the scene's config is left as it was
    assert (terrain.terrain_prim_paths, terrain.terrain_names) == (["/World/ground/terrain"], ["'terrain'"])
    assert (terrain.terrain_origins, terrain.flat_patches, terrain.device) == (None, {}, "cpu")
    ids, yes = torch.tensor([0, 2]), torch.ones(2, dtype=torch.bool)
    terrain.update_env_origins(ids, yes, ~yes)  # a plane has no harder place to go to
    torch.testing.assert_close(scene.env_origins, corners)
    sim.physics.step(10)
    scene.update(0.02)
    torch.testing.assert_close(
        scene["contact"].data.force_matrix_w[:, 0, 0, 2], torch.full((4,), 9.81), atol=2.0, rtol=0
    )


def test_a_class_of_one_s_own_places_the_environments(sim):
    scene = _scene(sim, class_type=_Shifted)
    assert type(scene.terrain) is _Shifted
    assert scene.env_origins[:, 2].tolist() == [5.0] * 4
    torch.testing.assert_close(scene["ball"].data.root_pos_w[:, 2], torch.full((4,), 5.099))


@pytest.mark.parametrize("shown", [False, True])
def test_origins_are_drawn_where_the_config_asks_for_them(sim, shown):
    terrain = _scene(sim, debug_vis=shown).terrain
    terrain.update_debug_vis()
    drawn = [group for group in VisualizationMarkers.of(sim) if group.is_visible() and group.count]
    assert len(drawn) == shown
    if shown:
        torch.testing.assert_close(drawn[0].positions_w, terrain.env_origins)


def test_what_cannot_be_made_or_is_not_there_is_named(sim):
    with pytest.raises(ConfigError, match=r"scene.terrain.terrain_type 'generator' is not supported; choose 'plane'"):
        _scene(sim, terrain_type="generator")
    with pytest.raises(ConfigError, match="'/World/ground': env_spacing must be set"):
        TerrainImporter(TerrainImporterCfg(prim_path="/World/ground"))
    terrain = TerrainImporter(TerrainImporterCfg(prim_path="/World/ground", num_envs=2, env_spacing=1.0))
    with pytest.raises(UnknownAttributeError, match="no 'env_origin'; did you mean 'env_origins'"):
        _ = terrain.env_origin
