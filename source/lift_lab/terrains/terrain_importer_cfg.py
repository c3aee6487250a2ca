"""Config of a terrain (names of Isaac Lab's); planes are simulated."""

from __future__ import annotations

from dataclasses import MISSING
from typing import Any, Literal

import mujoco

from lift_lab.sim.spawners import GroundPlaneCfg, RigidBodyMaterialCfg, VisualMaterialCfg
from lift_lab.sim.spawners.file_options import adopt_scene_options
from lift_lab.utils import configclass
from lift_lab.utils.errors import ConfigError


@configclass
class TerrainImporterCfg:
    """A terrain that all environments stand on."""

    collision_group: int = -1
    prim_path: str = MISSING
    num_envs: int = 1
    terrain_type: Literal["generator", "plane", "usd"] = "plane"
    terrain_generator: Any = None
    usd_path: str | None = None
    env_spacing: float | None = None
    use_terrain_origins: bool = True
    visual_material: VisualMaterialCfg | None = None
    physics_material: RigidBodyMaterialCfg = RigidBodyMaterialCfg()
    max_init_terrain_level: int | None = None
    debug_vis: bool = False

    def spawn_into(self, spec: mujoco.MjSpec, name: str) -> None:
        """Lay the terrain into a scene's spec.

        Raises:
            ConfigError: the terrain is no plane.
        """
        if self.terrain_type != "plane":
            raise ConfigError(f"scene.{name}.terrain_type '{self.terrain_type}' is not supported; choose 'plane'")
        cfg = GroundPlaneCfg(physics_material=self.physics_material, color=None)
        spawned = cfg.func(self.prim_path, cfg)
        adopt_scene_options(spawned, spec, f"scene.{name}")
        spec.attach(spawned.spec, prefix=f"{name}/", frame=spec.worldbody.add_frame())
