"""The table of unsupported names: reason, module path in Isaac Lab, names."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

if TYPE_CHECKING:
    from lift_lab.utils.errors import ConfigError


class Unsupported(NamedTuple):
    """Names that are missing for one reason."""

    file: str
    """File of this package that defines them."""
    reason: str
    """Message of the error. In braces: ``name`` of the class, ``cfg``, ``prim_path``."""
    modules: dict[str, str]
    """Module below ``lift_lab`` -> its names. ``*`` stands for all names of the modules below it."""

    def error(self, **subject: Any) -> ConfigError:
        """The error that using one of the names raises.

        Args:
            **subject: values for the braces of the reason.
        """
        from lift_lab.utils.errors import ConfigError

        return ConfigError(self.reason.format(**subject))


DEVICES = Unsupported(
    "devices",
    "{name}: teleoperation devices are not supported",
    {
        "devices": "DeviceBase DeviceCfg DevicesCfg HaplyDevice HaplyDeviceCfg ManusVive ManusViveCfg OpenXRDevice "
        "OpenXRDeviceCfg Se2Gamepad Se2GamepadCfg Se2Keyboard Se2KeyboardCfg Se2SpaceMouse Se2SpaceMouseCfg Se3Gamepad "
        "Se3GamepadCfg Se3Keyboard Se3KeyboardCfg Se3SpaceMouse Se3SpaceMouseCfg create_teleop_device",
        "devices.device_base": "DeviceBase DeviceCfg DevicesCfg",
        "devices.gamepad": "*",
        "devices.gamepad.se2_gamepad": "Se2Gamepad Se2GamepadCfg",
        "devices.gamepad.se3_gamepad": "Se3Gamepad Se3GamepadCfg",
        "devices.haply": "*",
        "devices.haply.se3_haply": "HaplyDevice HaplyDeviceCfg",
        "devices.keyboard": "*",
        "devices.keyboard.se2_keyboard": "Se2Keyboard Se2KeyboardCfg",
        "devices.keyboard.se3_keyboard": "Se3Keyboard Se3KeyboardCfg",
        "devices.openxr": "*",
        "devices.openxr.manus_vive": "ManusVive ManusViveCfg",
        "devices.openxr.openxr_device": "OpenXRDevice OpenXRDeviceCfg",
        "devices.openxr.xr_cfg": "XrAnchorRotationMode XrCfg remove_camera_configs",
        "devices.spacemouse": "*",
        "devices.spacemouse.se2_spacemouse": "Se2SpaceMouse Se2SpaceMouseCfg",
        "devices.spacemouse.se3_spacemouse": "Se3SpaceMouse Se3SpaceMouseCfg",
        "devices.teleop_device_factory": "create_teleop_device",
    },
)

RETARGETERS = Unsupported(
    "devices",
    "{name}: retargeting of teleoperation devices is not supported",
    {
        "devices": "RetargeterBase RetargeterCfg",
        "devices.retargeter_base": "RetargeterBase RetargeterCfg",
        "devices.openxr.retargeters": "*",
        "devices.openxr.retargeters.manipulator": "*",
        "devices.openxr.retargeters.manipulator.gripper_retargeter": "GripperRetargeter GripperRetargeterCfg",
        "devices.openxr.retargeters.manipulator.se3_abs_retargeter": "Se3AbsRetargeter Se3AbsRetargeterCfg",
        "devices.openxr.retargeters.manipulator.se3_rel_retargeter": "Se3RelRetargeter Se3RelRetargeterCfg",
    },
)

CAMERAS = Unsupported(
    "sensors",
    "'{cfg.prim_path}': image sensors are not simulated; remove the camera from the scene",
    {
        "sensors": "Camera CameraCfg TiledCamera TiledCameraCfg",
        "sensors.camera": "*",
        "sensors.camera.camera": "Camera",
        "sensors.camera.camera_cfg": "CameraCfg",
        "sensors.camera.tiled_camera": "TiledCamera",
        "sensors.camera.tiled_camera_cfg": "TiledCameraCfg",
    },
)

CAMERA_PRIMS = Unsupported(
    "spawners",
    "{prim_path}: camera sensors are not supported; remove {name} from the scene",
    {
        "sim.spawners": "FisheyeCameraCfg PinholeCameraCfg",
        "sim.spawners.sensors": "FisheyeCameraCfg PinholeCameraCfg",
        "sim.spawners.sensors.sensors_cfg": "FisheyeCameraCfg PinholeCameraCfg spawn_camera",
    },
)

OTHER_FILES = Unsupported(
    "spawners",
    "'{prim_path}': {kind} files are not loaded; convert '{cfg.asset_path}' to USD and use UsdFileCfg "
    "(docs/own_robot.md)",
    {
        "sim.spawners.from_files": "*",
        "sim.spawners.from_files.from_files": "spawn_from_mjcf spawn_from_urdf",
        "sim.spawners.from_files.from_files_cfg": "MjcfFileCfg UrdfFileCfg",
    },
)

RAY_CASTERS = Unsupported(
    "sensors",
    "'{cfg.prim_path}': ray casters are not simulated; remove the sensor from the scene",
    {
        "sensors": "MultiMeshRayCasterCameraCfg MultiMeshRayCasterCfg RayCaster RayCasterCamera RayCasterCameraCfg "
        "RayCasterCfg patterns",
        "sensors.ray_caster": "MultiMeshRayCasterCameraCfg MultiMeshRayCasterCfg RayCaster RayCasterCamera "
        "RayCasterCameraCfg RayCasterCfg patterns",
        "sensors.ray_caster.multi_mesh_ray_caster_camera_cfg": "MultiMeshRayCasterCameraCfg",
        "sensors.ray_caster.multi_mesh_ray_caster_cfg": "MultiMeshRayCasterCameraCfg MultiMeshRayCasterCfg",
        "sensors.ray_caster.ray_caster": "RayCaster",
        "sensors.ray_caster.ray_caster_camera": "RayCasterCamera",
        "sensors.ray_caster.ray_caster_camera_cfg": "RayCasterCameraCfg",
        "sensors.ray_caster.ray_caster_cfg": "RayCasterCfg",
    },
)

PATTERNS = Unsupported(
    "patterns",
    RAY_CASTERS.reason,
    {
        "sensors.ray_caster.patterns": "*",
        "sensors.ray_caster.patterns.patterns_cfg": "BpearlPatternCfg GridPatternCfg LidarPatternCfg PatternBaseCfg "
        "PinholeCameraPatternCfg",
    },
)

TERRAINS = Unsupported(
    "terrains",
    "{name}: terrains are not generated; use terrain_type='plane'",
    {
        "terrains": "*",
        "terrains.config": "",
        "terrains.config.rough": "ROUGH_TERRAINS_CFG",
        "terrains.height_field": "*",
        "terrains.height_field.hf_terrains_cfg": "HfDiscreteObstaclesTerrainCfg HfInvertedPyramidSlopedTerrainCfg "
        "HfInvertedPyramidStairsTerrainCfg HfPyramidSlopedTerrainCfg HfPyramidStairsTerrainCfg "
        "HfRandomUniformTerrainCfg HfSteppingStonesTerrainCfg HfTerrainBaseCfg HfWaveTerrainCfg",
        "terrains.sub_terrain_cfg": "FlatPatchSamplingCfg SubTerrainBaseCfg",
        "terrains.terrain_generator_cfg": "TerrainGeneratorCfg",
        "terrains.trimesh": "*",
        "terrains.trimesh.mesh_terrains_cfg": "MeshBoxTerrainCfg MeshFloatingRingTerrainCfg MeshGapTerrainCfg "
        "MeshInvertedPyramidStairsTerrainCfg MeshPitTerrainCfg MeshPlaneTerrainCfg MeshPyramidStairsTerrainCfg "
        "MeshRailsTerrainCfg MeshRandomGridTerrainCfg MeshRepeatedBoxesTerrainCfg MeshRepeatedCylindersTerrainCfg "
        "MeshRepeatedObjectsTerrainCfg MeshRepeatedPyramidsTerrainCfg MeshStarTerrainCfg",
    },
)

COLLECTIONS = Unsupported(
    "assets",
    "rigid object collections are not supported: give {objects} a field of the scene each",
    {
        "assets": "RigidObjectCollection RigidObjectCollectionCfg",
        "assets.rigid_object_collection": "*",
        "assets.rigid_object_collection.rigid_object_collection": "RigidObjectCollection",
        "assets.rigid_object_collection.rigid_object_collection_cfg": "RigidObjectCollectionCfg",
    },
)

SURFACE_GRIPPERS = Unsupported(
    "assets",
    "'{cfg.prim_path}': surface grippers are not simulated",
    {
        "assets": "SurfaceGripper SurfaceGripperCfg",
        "assets.surface_gripper": "*",
        "assets.surface_gripper.surface_gripper": "SurfaceGripper",
        "assets.surface_gripper.surface_gripper_cfg": "SurfaceGripperCfg",
    },
)

SEVERAL_ASSETS = Unsupported(
    "spawners",
    "'{prim_path}': all environments share one model; {instead}",
    {
        "sim.spawners": "MultiAssetSpawnerCfg MultiUsdFileCfg spawn_multi_asset spawn_multi_usd_file",
        "sim.spawners.wrappers": "*",
        "sim.spawners.wrappers.wrappers": "spawn_multi_asset spawn_multi_usd_file",
        "sim.spawners.wrappers.wrappers_cfg": "MultiAssetSpawnerCfg MultiUsdFileCfg",
    },
)

DIRECT = Unsupported(
    "envs",
    "{name}: only the manager-based workflow exists here; see ManagerBasedRLEnv",
    {
        "envs": "DirectMARLEnv DirectMARLEnvCfg DirectRLEnv DirectRLEnvCfg multi_agent_to_single_agent "
        "multi_agent_with_one_agent",
        "envs.direct_marl_env": "DirectMARLEnv",
        "envs.direct_marl_env_cfg": "DirectMARLEnvCfg",
        "envs.direct_rl_env": "DirectRLEnv",
        "envs.direct_rl_env_cfg": "DirectRLEnvCfg",
    },
)

GRIPPER_ACTIONS = Unsupported(
    "mdp",
    "mdp.{name}: surface grippers are not simulated; remove the action",
    {
        "envs.mdp.actions": "SurfaceGripperBinaryAction SurfaceGripperBinaryActionCfg",
        "envs.mdp.actions.actions_cfg": "SurfaceGripperBinaryActionCfg",
        "envs.mdp.actions.surface_gripper_actions": "SurfaceGripperBinaryAction",
    },
)

IMAGES = Unsupported(
    "mdp",
    "mdp.{name} needs images, and no camera is simulated; remove the term",
    {"envs.mdp": "image image_features"},
)
HEIGHTS = Unsupported(
    "mdp",
    "mdp.{name} needs a ray caster, which is not simulated; remove the term",
    {"envs.mdp": "height_scan"},
)
WRENCHES = Unsupported(
    "mdp",
    "mdp.{name} needs joint reaction wrenches, which assets do not read; remove the term",
    {"envs.mdp": "body_incoming_wrench"},
)
SCALES = Unsupported(
    "mdp",
    "mdp.{name} needs shapes that differ between environments, which share one model; remove the term",
    {"envs.mdp": "randomize_rigid_body_scale"},
)
TENDONS = Unsupported(
    "mdp",
    "mdp.{name} needs articulations with tendons; remove the term",
    {"envs.mdp": "randomize_fixed_tendon_parameters"},
)
LOOKS = Unsupported(
    "mdp",
    "mdp.{name} needs a renderer of textures and colours, and there is none; remove the term",
    {"envs.mdp": "randomize_visual_color randomize_visual_texture_material"},
)
PATCHES = Unsupported(
    "mdp",
    "mdp.{name} needs a generated terrain, and grounds are planes; remove the term",
    {"envs.mdp": "reset_root_state_from_terrain"},
)

TABLE = tuple(entry for entry in globals().values() if isinstance(entry, Unsupported))
