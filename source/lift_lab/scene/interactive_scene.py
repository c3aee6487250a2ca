"""A scene: built from a config into one MjSpec, then handles to its entities in every environment.

Each environment is simulated about its own origin. ``env_origins`` is added to world positions when they are read, and
subtracted when they are written.
"""

from __future__ import annotations

from typing import Any, ClassVar

import mujoco
import torch

from lift_lab.assets import Articulation, AssetBase, AssetBaseCfg, DeformableObject, RigidObject
from lift_lab.sensors import SensorBase, SensorBaseCfg
from lift_lab.sensors.sensor_base import AssetPath
from lift_lab.sim import SimulationContext, note_ignored
from lift_lab.sim.physics.memory import LEAST_BYTES, check_fits
from lift_lab.terrains import TerrainImporter, TerrainImporterCfg
from lift_lab.terrains.terrain_importer import grid_origins
from lift_lab.utils.configclass import validate
from lift_lab.utils.errors import ConfigError, NotFoundError, suggest
from lift_lab.utils.indexing import EnvIds
from lift_lab.utils.saved_state import Stateful

from .interactive_scene_cfg import InteractiveSceneCfg

State = dict[str, dict[str, dict[str, torch.Tensor]]]


class InteractiveScene(Stateful):
    """Entities of an environment, each by the name of its config field: ``scene["robot"]``.

    The scene is built into :attr:`spec` at construction; :meth:`SimulationContext.reset` compiles it.
    """

    unsaved_attributes: ClassVar[frozenset[str]] = frozenset(
        {"num_envs", "device", "_articulations", "_rigid_objects", "_deformable_objects", "_statics", "_sensors"}
        | {"_movables", "_entities", "_terrain", "_terrain_field"}
    )

    def __init__(self, cfg: InteractiveSceneCfg):
        """Build all entities.

        Raises:
            ConfigError: no simulation exists yet, an entity cannot be built, or the environments
                cannot fit into memory.
        """
        sim = SimulationContext.instance()
        if sim is None:
            raise ConfigError("make a SimulationContext before an InteractiveScene")
        validate(cfg, "scene")
        check_fits("scene.num_envs", cfg.num_envs, LEAST_BYTES, sim.device)
        self.cfg = cfg
        self.sim = sim
        self.num_envs: int = cfg.num_envs
        self.device: str = sim.device
        self.spec: mujoco.MjSpec = mujoco.MjSpec()
        sim.configure(self.spec)  # its options hold for every asset that joins
        self._origins = grid_origins(cfg.num_envs, cfg.env_spacing, self.device)
        self._articulations: dict[str, Articulation] = {}
        self._rigid_objects: dict[str, RigidObject] = {}
        self._deformable_objects: dict[str, DeformableObject] = {}
        self._statics: dict[str, AssetBase] = {}
        self._sensors: dict[str, SensorBase] = {}
        self._movables: dict[str, Articulation | RigidObject | DeformableObject] = {}
        self._entities: dict[str, Any] = {}
        self._terrain: TerrainImporter | None = None
        self._terrain_field = ""
        if cfg.clone_in_fabric:
            note_ignored("scene.clone_in_fabric", "Omniverse Fabric")
        if not cfg.replicate_physics:
            note_ignored("scene.replicate_physics", "all environments share one model")
        self._build()
        sim.set_scene(self)

    def _build(self) -> None:
        entities = [(n, v) for n, v in vars(self.cfg).items() if n not in InteractiveSceneCfg.__dataclass_fields__]
        other_names = self._other_names(dict(entities))
        for name, cfg in entities:
            if cfg is None or isinstance(cfg, SensorBaseCfg) or name in other_names:
                continue
            if isinstance(cfg, TerrainImporterCfg):
                self._add_terrain(cfg, name)
                continue
            if not isinstance(cfg, AssetBaseCfg):
                raise ConfigError(f"scene.{name}: {type(cfg).__name__} is no asset, sensor or terrain config")
            asset = cfg.class_type(cfg)
            asset.spawn_into(self.spec, name)
            if isinstance(asset, Articulation):
                self._articulations[name] = asset
            elif isinstance(asset, RigidObject):
                self._rigid_objects[name] = asset
            elif isinstance(asset, DeformableObject):
                self._deformable_objects[name] = asset
            else:
                self._statics[name] = asset
        self._movables = {**self._articulations, **self._rigid_objects, **self._deformable_objects}
        for name, cfg in entities:
            if isinstance(cfg, SensorBaseCfg):
                sensor = cfg.class_type(cfg)
                sensor.build(self.spec, name, self._prim_paths)
                self._sensors[name] = sensor
        terrain = {} if self._terrain is None else {"terrain": self._terrain}
        self._entities = {**terrain, **self._movables, **self._sensors, **self._statics}
        self._entities.update({other: self._entities[name] for other, name in other_names.items()})

    def _add_terrain(self, cfg: TerrainImporterCfg, name: str) -> None:
        cfg.spawn_into(self.spec, name)
        cfg = cfg.copy()
        cfg.num_envs, cfg.env_spacing = self.num_envs, self.cfg.env_spacing
        terrain = cfg.class_type(cfg)
        terrain.name = name
        self._terrain, self._terrain_field = terrain, name
        self._origins = terrain.env_origins

    @staticmethod
    def _other_names(entities: dict[str, Any]) -> dict[str, str]:
        """Fields that name what a later field spawns: field -> that field.

        As in Isaac Lab, two fields of one prim path are one thing, such as a config that was kept for the next line
        of a class body and so became a field itself.

        Raises:
            ConfigError: the fields of one prim path say different things.
        """
        names: dict[str, str] = {}
        owners: dict[str, str] = {}
        for name, cfg in reversed(entities.items()):
            if not isinstance(cfg, AssetBaseCfg) or cfg.class_type is AssetBase:
                continue
            owner = owners.setdefault(cfg.prim_path, name)
            if owner == name:
                continue
            if cfg != entities[owner]:
                raise ConfigError(
                    f"scene.{name} and scene.{owner} are two different assets at '{cfg.prim_path}': give each a"
                    " prim_path of its own, or set one of the fields to None"
                )
            names[name] = owner
        return names

    @property
    def _prim_paths(self) -> dict[str, str]:
        assets = {**self._movables, **self._statics}
        paths: dict[str, str] = {name: AssetPath(a.cfg.prim_path, a.stage_paths) for name, a in assets.items()}
        return paths if self._terrain is None else {**paths, self._terrain_field: self._terrain.cfg.prim_path}

    def initialize(self) -> None:
        """Find all entities in the compiled model (called by :meth:`SimulationContext.reset`)."""
        physics = self.sim.physics
        for asset in (*self._movables.values(), *self._statics.values()):
            asset.initialize(physics, self._origins)
        for sensor in self._sensors.values():
            sensor.initialize(physics, self._origins)

    # -- what it holds

    @property
    def physics_dt(self) -> float:
        """Physics step in seconds."""
        return self.sim.get_physics_dt()

    @property
    def env_origins(self) -> torch.Tensor:
        """Origins of the environments in the world in m, shape (num_envs, 3)."""
        return self._origins

    @property
    def env_ns(self) -> str:
        """Isaac Lab's namespace of the environments."""
        return "/World/envs"

    @property
    def env_regex_ns(self) -> str:
        """Isaac Lab's pattern for every environment's prim."""
        return f"{self.env_ns}/env_.*"

    @property
    def env_prim_paths(self) -> list[str]:
        """Isaac Lab's prim path of each environment."""
        return [f"{self.env_ns}/env_{i}" for i in range(self.num_envs)]

    @property
    def articulations(self) -> dict[str, Articulation]:
        """Articulations by name."""
        return self._articulations

    @property
    def rigid_objects(self) -> dict[str, RigidObject]:
        """Rigid objects by name."""
        return self._rigid_objects

    @property
    def deformable_objects(self) -> dict[str, DeformableObject]:
        """Deformable objects by name."""
        return self._deformable_objects

    @property
    def rigid_object_collections(self) -> dict[str, Any]:
        """Isaac Lab's collections of rigid objects: none, ever."""
        return {}

    @property
    def surface_grippers(self) -> dict[str, Any]:
        """Isaac Lab's suction grippers: none, ever."""
        return {}

    @property
    def sensors(self) -> dict[str, Any]:
        """Sensors by name."""
        return self._sensors

    @property
    def extras(self) -> dict[str, AssetBase]:
        """Static things by name."""
        return self._statics

    @property
    def terrain(self) -> TerrainImporter | None:
        """The terrain, or None."""
        return self._terrain

    @property
    def substep_entities(self) -> list[str]:
        """Names of the entities that compute something after each physics step, so that steps cannot be fused."""
        assets = [name for name, asset in self._articulations.items() if asset.has_explicit_actuators]
        return assets + [name for name, sensor in self._sensors.items() if sensor.needs_every_substep]

    def keys(self) -> list[str]:
        """Names of all entities."""
        return list(self._entities)

    def __contains__(self, key: str) -> bool:
        return key in self._entities

    def __getitem__(self, key: str) -> Any:
        """The entity called ``key``.

        Raises:
            NotFoundError: there is none.
        """
        entity = self._entities.get(key)
        if entity is None:
            raise NotFoundError(f"the scene has no entity '{key}'; {suggest(key, self.keys())}")
        return entity

    def __str__(self) -> str:
        lines = [f"Scene of {self.num_envs} environments, {self.cfg.env_spacing} m apart:"]
        lines += [f"  {name}: {type(self[name]).__name__}" for name in self.keys()]
        return "\n".join(lines)

    # -- stepping

    def reset(self, env_ids: EnvIds = None) -> None:
        """Reset the entities' own buffers of some environments; the simulated state stays."""
        for asset in self._movables.values():
            asset.reset(env_ids)
        for sensor in self._sensors.values():
            sensor.reset(env_ids)

    def start_episodes(self, env_ids: torch.Tensor) -> None:
        """Report the start state of some reset environments (a LongTensor) to their actuators."""
        for articulation in self._articulations.values():
            articulation.start_episodes(env_ids)

    def write_data_to_sim(self) -> None:
        """Send targets and wrenches of all assets to the engine."""
        for asset in self._movables.values():
            asset.write_data_to_sim()

    def update(self, dt: float) -> None:
        """Update all entities after the engine has moved on by ``dt`` seconds."""
        for asset in self._movables.values():
            asset.update(dt)
        for sensor in self._sensors.values():
            sensor.update(dt)

    # -- state

    def get_state(self, is_relative: bool = False) -> State:
        """State of all assets, as Isaac Lab's: kind -> name -> ``root_pose``, ``root_velocity``, joints or nodes.

        Args:
            is_relative: whether positions are relative to the environments' origins.
        """
        state: State = {"articulation": {}, "deformable_object": {}, "rigid_object": {}}
        for kind, group in (("articulation", self._articulations), ("rigid_object", self._rigid_objects)):
            for name, asset in group.items():
                pose = asset.data.root_pose_w.clone()
                if is_relative:
                    pose[:, :3] -= self._origins
                entry = {"root_pose": pose, "root_velocity": asset.data.root_vel_w.clone()}
                if isinstance(asset, Articulation):
                    entry["joint_position"] = asset.data.joint_pos.clone()
                    entry["joint_velocity"] = asset.data.joint_vel.clone()
                state[kind][name] = entry
        for name, asset in self._deformable_objects.items():
            position = asset.data.nodal_pos_w.clone()
            if is_relative:
                position -= self._origins[:, None]
            entry = {"nodal_position": position, "nodal_velocity": asset.data.nodal_vel_w.clone()}
            state["deformable_object"][name] = entry
        return state

    @property
    def state(self) -> State:
        """State of all assets in the world frame."""
        return self.get_state(is_relative=False)

    def reset_to(self, state: State, env_ids: EnvIds = None, is_relative: bool = False) -> None:
        """Put assets into a state as :meth:`get_state` gives it.

        Raises:
            NotFoundError: the state names an asset that the scene does not have.
        """
        ids = torch.arange(self.num_envs, device=self.device) if env_ids is None else torch.as_tensor(env_ids)
        for group in state.values():
            for name, entry in group.items():
                asset = self[name]
                if isinstance(asset, DeformableObject):
                    origins = self._origins[ids, None] if is_relative else 0.0
                    asset.write_nodal_pos_to_sim(entry["nodal_position"] + origins, ids)
                    asset.write_nodal_velocity_to_sim(entry["nodal_velocity"], ids)
                    continue
                pose = entry["root_pose"].clone()
                if is_relative:
                    pose[:, :3] += self._origins[ids]
                if asset.has_movable_root:
                    asset.write_root_pose_to_sim(pose, ids)
                    asset.write_root_velocity_to_sim(entry["root_velocity"], ids)
                if "joint_position" in entry:
                    asset.write_joint_state_to_sim(entry["joint_position"], entry["joint_velocity"], env_ids=ids)
                    asset.set_joint_position_target(entry["joint_position"], env_ids=ids)
                    asset.set_joint_velocity_target(entry["joint_velocity"], env_ids=ids)
        self.start_episodes(ids)
