"""Config of a terrain (names of Isaac Lab's); planes are simulated."""

from __future__ import annotations

from typing import Any, ClassVar, Literal

import mujoco

from lift_lab.sim.spawners import GroundPlaneCfg, RigidBodyMaterialCfg, VisualMaterialCfg
from lift_lab.sim.spawners.file_options import adopt_scene_options
from lift_lab.utils import MISSING, ConfigBase, configclass
from lift_lab.utils.errors import ConfigError
from lift_lab.utils.ranges import COUNT, COUNT_OR_ZERO, NOT_NEGATIVE, WHOLE, Ranges

from .terrain_importer import TerrainImporter

__all__ = ["TerrainImporterCfg"]


@configclass
class TerrainImporterCfg(ConfigBase):
    """A terrain that all environments stand on."""

    class_type: type = TerrainImporter
    """Class of ``scene.terrain``."""
    collision_group: int = -1
    prim_path: str = MISSING
    """Prim path of the ground."""
    num_envs: int = 1
    """Set by the scene."""
    terrain_type: Literal["generator", "plane", "usd"] = "plane"
    """Kind of terrain. Only ``plane`` is supported."""
    terrain_generator: Any = None
    usd_path: str | None = None
    env_spacing: float | None = None
    """Set by the scene, in m."""
    use_terrain_origins: bool = True
    visual_material: VisualMaterialCfg | None = None
    physics_material: RigidBodyMaterialCfg = RigidBodyMaterialCfg()
    """Friction of the ground."""
    max_init_terrain_level: int | None = None
    debug_vis: bool = False
    """Whether films and viewers show the environments' origins."""

    _ranges: ClassVar[Ranges] = {
        "collision_group": WHOLE,
        "num_envs": COUNT,
        "env_spacing": NOT_NEGATIVE,
        "max_init_terrain_level": COUNT_OR_ZERO,
    }

    def spawn_into(self, spec: mujoco.MjSpec, name: str) -> None:
        """Lay the terrain into a scene's spec.

        Raises:
            ConfigError: the terrain is no plane.
        """
        self.check_type(f"scene.{name}.")
        cfg = GroundPlaneCfg(physics_material=self.physics_material, color=None)
        spawned = cfg.func(self.prim_path, cfg)
        adopt_scene_options(spawned, spec, f"scene.{name}")
        spec.attach(spawned.spec, prefix=f"{name}/", frame=spec.worldbody.add_frame())

    def check_type(self, where: str) -> None:
        """Check that the terrain can be made.

        Args:
            where: start of the message.

        Raises:
            ConfigError: the terrain is no plane.
        """
        if self.terrain_type != "plane":
            raise ConfigError(f"{where}terrain_type '{self.terrain_type}' is not supported; choose 'plane'")
