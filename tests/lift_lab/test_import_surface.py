"""The names that Isaac Lab's task files import exist here in the same module paths."""

import importlib
import math

import pytest

from lift_lab.utils.errors import LiftLabError

SURFACE = {
    "sim": """SimulationCfg SimulationContext UsdFileCfg GroundPlaneCfg CuboidCfg SphereCfg CapsuleCfg CylinderCfg
        ConeCfg DomeLightCfg DistantLightCfg PinholeCameraCfg
        RigidBodyMaterialCfg RigidBodyPropertiesCfg MassPropertiesCfg
        ArticulationRootPropertiesCfg CollisionPropertiesCfg PreviewSurfaceCfg PhysxCfg RenderCfg""",
    "sim.spawners": "UsdFileCfg GroundPlaneCfg CuboidCfg SphereCfg PreviewSurfaceCfg RigidBodyMaterialCfg DomeLightCfg",
    "sim.spawners.from_files.from_files_cfg": "UsdFileCfg GroundPlaneCfg UrdfFileCfg MjcfFileCfg",
    "sim.schemas.schemas_cfg": """RigidBodyPropertiesCfg MassPropertiesCfg ArticulationRootPropertiesCfg
        CollisionPropertiesCfg JointDrivePropertiesCfg""",
    "assets": """Articulation ArticulationCfg ArticulationData RigidObject RigidObjectCfg RigidObjectData AssetBase
        AssetBaseCfg DeformableObject DeformableObjectCfg RigidObjectCollection RigidObjectCollectionCfg SurfaceGripper
        SurfaceGripperCfg""",
    "assets.articulation": "Articulation ArticulationCfg ArticulationData",
    "actuators": """ActuatorBase ActuatorBaseCfg ImplicitActuator ImplicitActuatorCfg IdealPDActuator IdealPDActuatorCfg
        DCMotor DCMotorCfg DelayedPDActuator DelayedPDActuatorCfg RemotizedPDActuator RemotizedPDActuatorCfg
        ActuatorNetMLP ActuatorNetMLPCfg ActuatorNetLSTM ActuatorNetLSTMCfg""",
    "actuators.actuator_cfg": "ImplicitActuatorCfg IdealPDActuatorCfg DCMotorCfg",
    "actuators.actuator_pd_cfg": "ImplicitActuatorCfg IdealPDActuatorCfg DCMotorCfg DelayedPDActuatorCfg",
    "actuators.actuator_net_cfg": "ActuatorNetMLPCfg ActuatorNetLSTMCfg",
    "envs": """ManagerBasedEnv ManagerBasedEnvCfg ManagerBasedRLEnv ManagerBasedRLEnvCfg ViewerCfg mdp
        DirectRLEnv DirectRLEnvCfg DirectMARLEnv DirectMARLEnvCfg multi_agent_to_single_agent""",
    "envs.utils.io_descriptors": "generic_io_descriptor record_shape record_dtype record_joint_names",
    "envs.mdp": """joint_pos_rel generated_commands modify_reward_weight imu_lin_acc reset_scene_to_default time_out
        randomize_rigid_body_com randomize_actuator_gains push_by_setting_velocity apply_external_force_torque""",
    "envs.mdp.actions.actions_cfg": """JointPositionActionCfg BinaryJointPositionActionCfg
        DifferentialInverseKinematicsActionCfg OperationalSpaceControllerActionCfg SurfaceGripperBinaryActionCfg""",
    "managers": """ActionTermCfg CommandTermCfg CurriculumTermCfg EventTermCfg ObservationTermCfg RewardTermCfg
        TerminationTermCfg ActionManager CommandManager CurriculumManager EventManager ObservationManager RewardManager
        TerminationManager ObservationGroupCfg SceneEntityCfg ManagerTermBase RecorderManager RecorderTerm
        RecorderTermCfg RecorderManagerBaseCfg ActionTerm CommandTerm""",
    "scene": "InteractiveScene InteractiveSceneCfg",
    "sensors": """FrameTransformer FrameTransformerCfg FrameTransformerData OffsetCfg ContactSensor ContactSensorCfg
        ContactSensorData Imu ImuCfg ImuData Camera CameraCfg TiledCamera TiledCameraCfg RayCaster RayCasterCfg
        RayCasterCamera RayCasterCameraCfg MultiMeshRayCasterCfg SensorBase SensorBaseCfg patterns""",
    "sensors.frame_transformer": "FrameTransformer FrameTransformerCfg FrameTransformerData OffsetCfg",
    "sensors.frame_transformer.frame_transformer_cfg": "FrameTransformerCfg OffsetCfg",
    "sensors.frame_transformer.frame_transformer_data": "FrameTransformerData",
    "sensors.contact_sensor.contact_sensor_cfg": "ContactSensorCfg",
    "sensors.imu.imu_cfg": "ImuCfg",
    "sensors.camera.camera_cfg": "CameraCfg",
    "sensors.camera.tiled_camera_cfg": "TiledCameraCfg",
    "sensors.ray_caster.patterns": "GridPatternCfg LidarPatternCfg BpearlPatternCfg PinholeCameraPatternCfg",
    "markers": "VisualizationMarkers VisualizationMarkersCfg",
    "markers.config": "FRAME_MARKER_CFG SPHERE_MARKER_CFG CUBOID_MARKER_CFG RAY_CASTER_MARKER_CFG",
    "controllers": """DifferentialIKController DifferentialIKControllerCfg OperationalSpaceController
        OperationalSpaceControllerCfg""",
    "controllers.differential_ik_cfg": "DifferentialIKControllerCfg",
    "controllers.operational_space_cfg": "OperationalSpaceControllerCfg",
    "devices": """DeviceBase DeviceCfg DevicesCfg Se2KeyboardCfg Se3KeyboardCfg Se3GamepadCfg Se3SpaceMouseCfg
        HaplyDeviceCfg OpenXRDeviceCfg ManusViveCfg RetargeterCfg create_teleop_device""",
    "devices.device_base": "DeviceBase DeviceCfg DevicesCfg",
    "devices.gamepad": "Se3Gamepad Se3GamepadCfg Se2GamepadCfg",
    "devices.keyboard": "Se3Keyboard Se3KeyboardCfg Se2KeyboardCfg",
    "devices.spacemouse": "Se3SpaceMouse Se3SpaceMouseCfg Se2SpaceMouseCfg",
    "devices.openxr": "OpenXRDevice OpenXRDeviceCfg XrCfg XrAnchorRotationMode remove_camera_configs",
    "devices.openxr.openxr_device": "OpenXRDeviceCfg",
    "devices.openxr.xr_cfg": "XrCfg XrAnchorRotationMode",
    "devices.openxr.retargeters": "GripperRetargeterCfg Se3AbsRetargeterCfg Se3RelRetargeterCfg",
    "devices.openxr.retargeters.manipulator.se3_abs_retargeter": "Se3AbsRetargeterCfg",
    "sim.spawners.wrappers": "MultiAssetSpawnerCfg MultiUsdFileCfg",
    "terrains": """TerrainImporter TerrainImporterCfg TerrainGeneratorCfg SubTerrainBaseCfg HfRandomUniformTerrainCfg
        HfWaveTerrainCfg MeshPlaneTerrainCfg MeshPyramidStairsTerrainCfg MeshRepeatedBoxesTerrainCfg""",
    "terrains.config.rough": "ROUGH_TERRAINS_CFG",
    "utils": "configclass",
    "utils.assets": "ISAAC_NUCLEUS_DIR ISAACLAB_NUCLEUS_DIR NVIDIA_NUCLEUS_DIR check_file_path retrieve_file_path",
    "utils.math": "quat_apply quat_mul subtract_frame_transforms combine_frame_transforms sample_uniform wrap_to_pi",
    "utils.noise": "AdditiveUniformNoiseCfg AdditiveGaussianNoiseCfg NoiseModelCfg",
    "utils.modifiers": "ModifierCfg",
    "utils.string": "resolve_matching_names resolve_matching_names_values",
    "utils.dict": "class_to_dict update_class_from_dict print_dict",
    "utils.io": "dump_yaml load_yaml",
    "utils.buffers": "CircularBuffer DelayBuffer TimestampedBuffer",
    "utils.timer": "Timer",
    "app": "AppLauncher",
}
OTHER_ROOTS = {
    "lift_lab_assets": "FRANKA_PANDA_CFG FRANKA_PANDA_HIGH_PD_CFG CARTPOLE_CFG",
    "lift_lab_assets.robots.franka": "FRANKA_PANDA_CFG FRANKA_PANDA_HIGH_PD_CFG",
    "lift_lab_assets.robots.cartpole": "CARTPOLE_CFG",
    "lift_lab_rl.rsl_rl": """RslRlOnPolicyRunnerCfg RslRlPpoActorCriticCfg RslRlPpoAlgorithmCfg RslRlSymmetryCfg
        RslRlDistillationRunnerCfg RslRlDistillationStudentTeacherCfg RslRlDistillationAlgorithmCfg
        RslRlVecEnvWrapper export_policy_as_jit export_policy_as_onnx""",
}
MODULES = {f"lift_lab.{module}": names for module, names in SURFACE.items()} | OTHER_ROOTS


@pytest.mark.parametrize("module", MODULES)
def test_a_module_holds_isaac_labs_names(module):
    found = importlib.import_module(module)
    assert [name for name in MODULES[module].split() if not hasattr(found, name)] == []


def _camera():
    from lift_lab.sensors import CameraCfg

    return CameraCfg(prim_path="{ENV_REGEX_NS}/Cam", spawn=None, width=4, height=4)


def _ray_caster():
    from lift_lab.sensors import RayCasterCfg, patterns

    return RayCasterCfg(
        prim_path="{ENV_REGEX_NS}/Robot/base",
        mesh_prim_paths=["/World/ground"],
        pattern_cfg=patterns.GridPatternCfg(resolution=0.1, size=(1.6, 1.0)),
    )


def _collection():
    from lift_lab.assets import RigidObjectCfg, RigidObjectCollectionCfg

    return RigidObjectCollectionCfg(rigid_objects={"red": RigidObjectCfg(prim_path="{ENV_REGEX_NS}/Red")})


def _gripper():
    from lift_lab.assets import SurfaceGripperCfg

    return SurfaceGripperCfg(prim_path="{ENV_REGEX_NS}/Robot/gripper")


def _keyboard():
    from lift_lab.devices.keyboard import Se3KeyboardCfg

    return Se3KeyboardCfg(gripper_term=False, sim_device="auto")


def _headset():
    from lift_lab.devices.openxr import OpenXRDeviceCfg, XrCfg
    from lift_lab.devices.openxr.retargeters import Se3AbsRetargeterCfg

    return OpenXRDeviceCfg(xr_cfg=XrCfg(anchor_pos=(0.0, 0.0, -1.0)), retargeters=[Se3AbsRetargeterCfg()])


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (_camera, "image sensors are not simulated"),
        (_ray_caster, "ray casters are not simulated"),
        (_collection, "rigid object collections are not supported: give 'red' a field of the scene each"),
        (_gripper, "surface grippers are not simulated"),
        (_keyboard, "Se3Keyboard: teleoperation devices are not supported"),
        (_headset, "OpenXRDevice: teleoperation devices are not supported"),
    ],
)
def test_a_config_of_what_is_missing_holds_data_and_its_object_says_so(make, message):
    cfg = make()
    cfg.validate()
    assert cfg.copy().to_dict() == cfg.to_dict()
    with pytest.raises(LiftLabError, match=message):
        cfg.class_type(cfg)


def test_what_only_isaac_labs_spawners_and_terrains_make_says_so_when_it_is_spawned():
    from lift_lab.terrains.config.rough import ROUGH_TERRAINS_CFG

    import lift_lab.sim as sim_utils

    urdf = sim_utils.UrdfFileCfg(asset_path="arm.urdf", fix_base=True)
    mjcf = sim_utils.MjcfFileCfg(asset_path="arm.xml", fix_base=True)
    several = sim_utils.MultiAssetSpawnerCfg(assets_cfg=[sim_utils.SphereCfg(radius=0.1)])
    files = sim_utils.MultiUsdFileCfg(usd_path=["a.usd", "b.usd"])
    for spawner, message in (
        (urdf, "URDF files are not loaded; convert 'arm.urdf' to USD"),
        (mjcf, "MJCF files are not loaded; convert 'arm.xml' to USD"),
        (several, "all environments share one model; spawn one of the assets_cfg"),
        (files, "all environments share one model; name one of the files"),
    ):
        spawner.validate()
        with pytest.raises(LiftLabError, match=message):
            spawner.func("/World/Object", spawner)
    ROUGH_TERRAINS_CFG.validate()
    stairs = ROUGH_TERRAINS_CFG.sub_terrains["pyramid_stairs"]
    with pytest.raises(LiftLabError, match="MeshPyramidStairsTerrainCfg: terrains are not generated"):
        stairs.function(0.5, stairs)


def test_the_direct_workflow_has_types_to_ask_for_and_no_environments():
    from lift_lab import envs

    assert not isinstance(envs.ManagerBasedRLEnvCfg, envs.DirectRLEnvCfg)
    for make in (envs.DirectRLEnvCfg, envs.DirectMARLEnvCfg, lambda: envs.DirectRLEnv(None)):
        with pytest.raises(LiftLabError, match="only the manager-based workflow exists here"):
            make()


def test_a_described_observation_term_is_the_term_itself():
    from lift_lab.envs.utils.io_descriptors import generic_io_descriptor, record_shape

    @generic_io_descriptor(units="rad", on_inspect=[record_shape])
    def height(env):
        return env

    @generic_io_descriptor
    def width(env):
        return env

    assert (height(3), width(4), height.__name__) == (3, 4, "height")


def test_a_terrain_pose_command_and_a_surface_gripper_action_say_what_is_missing():
    from lift_lab.envs import mdp

    pose = mdp.TerrainBasedPose2dCommandCfg(
        asset_name="robot",
        simple_heading=True,
        resampling_time_range=(1.0, 1.0),
        ranges=mdp.TerrainBasedPose2dCommandCfg.Ranges(heading=(-1.0, 1.0)),
    )
    for cfg, message in (
        (pose, "needs a generated terrain"),
        (mdp.SurfaceGripperBinaryActionCfg(asset_name="gripper"), "surface grippers are not simulated"),
    ):
        cfg.validate()
        with pytest.raises(LiftLabError, match=message):
            cfg.class_type(cfg, None)


def test_a_retargeter_and_an_unknown_device_say_so():
    from lift_lab.devices.openxr.retargeters import GripperRetargeterCfg

    from lift_lab.devices import create_teleop_device

    cfg = GripperRetargeterCfg()
    with pytest.raises(LiftLabError, match="GripperRetargeter: retargeting"):
        cfg.retargeter_type(cfg)
    with pytest.raises(LiftLabError, match="no teleoperation device 'keybord'; did you mean 'keyboard'"):
        create_teleop_device("keybord", {"keyboard": _keyboard()})
    with pytest.raises(LiftLabError, match="'keyboard': teleoperation devices are not supported"):
        create_teleop_device("keyboard", {"keyboard": _keyboard()})


def test_a_generated_terrain_is_data_and_a_scene_refuses_it():
    import mujoco

    from lift_lab.terrains import SubTerrainBaseCfg, TerrainGeneratorCfg, TerrainImporterCfg

    generator = TerrainGeneratorCfg(size=(8.0, 8.0), sub_terrains={"flat": SubTerrainBaseCfg(function=math.hypot)})
    cfg = TerrainImporterCfg(prim_path="/World/ground", terrain_type="generator", terrain_generator=generator)
    cfg.validate()
    with pytest.raises(LiftLabError, match="terrain_type 'generator' is not supported; choose 'plane'"):
        cfg.spawn_into(mujoco.MjSpec(), "terrain")


def test_cameras_are_removed_from_a_config_with_the_terms_that_read_them():
    from lift_lab.devices.openxr import remove_camera_configs

    from lift_lab.managers import ObservationGroupCfg, ObservationTermCfg, SceneEntityCfg
    from lift_lab.scene import InteractiveSceneCfg
    from lift_lab.utils import configclass

    @configclass
    class Scene(InteractiveSceneCfg):
        wrist = _camera()

    @configclass
    class Policy(ObservationGroupCfg):
        picture = ObservationTermCfg(func=math.hypot, params={"sensor_cfg": SceneEntityCfg("wrist")})
        state = ObservationTermCfg(func=math.hypot, params={"asset_cfg": SceneEntityCfg("robot")})

    @configclass
    class Observations:
        policy: Policy = Policy()

    @configclass
    class Env:
        scene: Scene = Scene(num_envs=1, env_spacing=1.0)
        observations: Observations = Observations()

    cfg = remove_camera_configs(Env())
    assert cfg.scene.wrist is None
    assert cfg.observations.policy.picture is None
    assert cfg.observations.policy.state is not None
