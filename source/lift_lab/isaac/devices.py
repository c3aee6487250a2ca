"""Teleoperation devices and their retargeters."""

from collections.abc import Callable, Mapping
from enum import Enum
from typing import Any, ClassVar

from lift_lab.sensors import CameraCfg
from lift_lab.utils import ConfigBase, configclass
from lift_lab.utils.errors import NotFoundError, suggest
from lift_lab.utils.ranges import FINITE, FRACTION, NOT_NEGATIVE, POSITIVE, Ranges

from .finder import place
from .refused import Refused
from .table import DEVICES, RETARGETERS


class RetargeterBase(Refused):
    """Base of what turns a device's data into robot commands."""

    missing = RETARGETERS


class GripperRetargeter(RetargeterBase): ...


class Se3AbsRetargeter(RetargeterBase): ...


class Se3RelRetargeter(RetargeterBase): ...


@configclass
class RetargeterCfg(ConfigBase):
    """Base of retargeter configs."""

    retargeter_type: type[RetargeterBase] | None = None
    """The retargeter."""
    sim_device: str = "cpu"
    """Torch device of the commands."""


class DeviceBase(Refused):
    """Base of devices."""

    missing = DEVICES

    class TrackingTarget(Enum):
        """Target that a tracking device follows."""

        HAND_LEFT = 0
        HAND_RIGHT = 1
        HEAD = 2
        CONTROLLER_LEFT = 3
        CONTROLLER_RIGHT = 4


class HaplyDevice(DeviceBase): ...


class ManusVive(DeviceBase): ...


class OpenXRDevice(DeviceBase): ...


class Se2Gamepad(DeviceBase): ...


class Se3Gamepad(DeviceBase): ...


class Se2Keyboard(DeviceBase): ...


class Se3Keyboard(DeviceBase): ...


class Se2SpaceMouse(DeviceBase): ...


class Se3SpaceMouse(DeviceBase): ...


@configclass
class DeviceCfg(ConfigBase):
    """Base of device configs."""

    class_type: type[DeviceBase] | None = None
    """The device."""
    teleoperation_active_default: bool = True
    """Whether teleoperation starts switched on."""
    sim_device: str = "cpu"
    """Torch device of the commands."""
    retargeters: list[RetargeterCfg] | None = []
    """Converter from the device's data to robot commands."""


@configclass
class DevicesCfg(ConfigBase):
    """The teleoperation devices of an environment, by name."""

    devices: dict[str, DeviceCfg] = {}


@configclass
class Se2GamepadCfg(DeviceCfg):
    """A gamepad that drives a mobile base."""

    class_type: type[DeviceBase] | None = Se2Gamepad
    v_x_sensitivity: float = 1.0
    v_y_sensitivity: float = 1.0
    omega_z_sensitivity: float = 1.0
    dead_zone: float = 0.01

    _ranges: ClassVar[Ranges] = {
        "v_x_sensitivity v_y_sensitivity omega_z_sensitivity": FINITE,
        "dead_zone": NOT_NEGATIVE,
    }


@configclass
class Se3GamepadCfg(DeviceCfg):
    """A gamepad that moves an end effector."""

    class_type: type[DeviceBase] | None = Se3Gamepad
    gripper_term: bool = True
    dead_zone: float = 0.01
    pos_sensitivity: float = 1.0
    rot_sensitivity: float = 1.6

    _ranges: ClassVar[Ranges] = {"dead_zone": NOT_NEGATIVE, "pos_sensitivity rot_sensitivity": FINITE}


@configclass
class HaplyDeviceCfg(DeviceCfg):
    """A Haply haptic device."""

    class_type: type[DeviceBase] | None = HaplyDevice
    websocket_uri: str = "ws://localhost:10001"
    pos_sensitivity: float = 1.0
    data_rate: float = 200.0
    limit_force: float = 2.0

    _ranges: ClassVar[Ranges] = {"pos_sensitivity": FINITE, "data_rate": POSITIVE, "limit_force": NOT_NEGATIVE}


@configclass
class Se2KeyboardCfg(DeviceCfg):
    """A keyboard that drives a mobile base."""

    class_type: type[DeviceBase] | None = Se2Keyboard
    v_x_sensitivity: float = 0.8
    v_y_sensitivity: float = 0.4
    omega_z_sensitivity: float = 1.0

    _ranges: ClassVar[Ranges] = {"v_x_sensitivity v_y_sensitivity omega_z_sensitivity": FINITE}


@configclass
class Se3KeyboardCfg(DeviceCfg):
    """A keyboard that moves an end effector."""

    class_type: type[DeviceBase] | None = Se3Keyboard
    gripper_term: bool = True
    pos_sensitivity: float = 0.4
    rot_sensitivity: float = 0.8

    _ranges: ClassVar[Ranges] = {"pos_sensitivity rot_sensitivity": FINITE}


@configclass
class Se2SpaceMouseCfg(DeviceCfg):
    """A space mouse that drives a mobile base."""

    class_type: type[DeviceBase] | None = Se2SpaceMouse
    v_x_sensitivity: float = 0.8
    v_y_sensitivity: float = 0.4
    omega_z_sensitivity: float = 1.0

    _ranges: ClassVar[Ranges] = {"v_x_sensitivity v_y_sensitivity omega_z_sensitivity": FINITE}


@configclass
class Se3SpaceMouseCfg(DeviceCfg):
    """A space mouse that moves an end effector."""

    class_type: type[DeviceBase] | None = Se3SpaceMouse
    gripper_term: bool = True
    pos_sensitivity: float = 0.4
    rot_sensitivity: float = 0.8

    _ranges: ClassVar[Ranges] = {"pos_sensitivity rot_sensitivity": FINITE}


class XrAnchorRotationMode(Enum):
    """Rotation of the anchor with the prim that it follows."""

    FIXED = "fixed"
    FOLLOW_PRIM = "follow_prim"
    FOLLOW_PRIM_SMOOTHED = "follow_prim_smoothed"
    CUSTOM = "custom_rotation"


@configclass
class XrCfg(ConfigBase):
    """Anchor of a headset's world in the scene."""

    anchor_pos: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Position in m."""
    anchor_rot: tuple[float, float, float, float] = (1.0, 0.0, 0.0, 0.0)
    """Orientation (w, x, y, z)."""
    anchor_prim_path: str | None = None
    anchor_rotation_mode: XrAnchorRotationMode = XrAnchorRotationMode.FIXED
    anchor_rotation_smoothing_time: float = 1.0
    anchor_rotation_custom_func: Callable[..., Any] | None = None
    near_plane: float = 0.15
    fixed_anchor_height: bool = True

    _ranges: ClassVar[Ranges] = {
        "anchor_pos anchor_rot": FINITE,
        "anchor_rotation_smoothing_time near_plane": NOT_NEGATIVE,
    }


@configclass
class ManusViveCfg(DeviceCfg):
    """Manus gloves with Vive trackers."""

    class_type: type[DeviceBase] | None = ManusVive
    xr_cfg: XrCfg | None = None


@configclass
class OpenXRDeviceCfg(DeviceCfg):
    """A headset or hand tracker over OpenXR."""

    class_type: type[DeviceBase] | None = OpenXRDevice
    xr_cfg: XrCfg | None = None


@configclass
class GripperRetargeterCfg(RetargeterCfg):
    """A pinch as a gripper command."""

    retargeter_type: type[RetargeterBase] | None = GripperRetargeter
    bound_hand: DeviceBase.TrackingTarget = DeviceBase.TrackingTarget.HAND_RIGHT


@configclass
class Se3AbsRetargeterCfg(RetargeterCfg):
    """A hand's pose as an end effector's pose."""

    retargeter_type: type[RetargeterBase] | None = Se3AbsRetargeter
    bound_hand: DeviceBase.TrackingTarget = DeviceBase.TrackingTarget.HAND_RIGHT
    zero_out_xy_rotation: bool = True
    use_wrist_rotation: bool = False
    use_wrist_position: bool = True
    enable_visualization: bool = False


@configclass
class Se3RelRetargeterCfg(RetargeterCfg):
    """A hand's motion as an end effector's motion."""

    retargeter_type: type[RetargeterBase] | None = Se3RelRetargeter
    bound_hand: DeviceBase.TrackingTarget = DeviceBase.TrackingTarget.HAND_RIGHT
    zero_out_xy_rotation: bool = True
    use_wrist_rotation: bool = False
    use_wrist_position: bool = True
    delta_pos_scale_factor: float = 10.0
    delta_rot_scale_factor: float = 10.0
    alpha_pos: float = 0.5
    alpha_rot: float = 0.5
    enable_visualization: bool = False

    _ranges: ClassVar[Ranges] = {
        "delta_pos_scale_factor delta_rot_scale_factor": FINITE,
        "alpha_pos alpha_rot": FRACTION,
    }


def create_teleop_device(
    device_name: str,
    devices_cfg: Mapping[str, DeviceCfg],
    callbacks: Mapping[str, Callable[[], Any]] | None = None,
) -> DeviceBase:
    """Refuse to make the device ``device_name``.

    Raises:
        NotFoundError: there is no config of that name.
        ConfigError: always otherwise.
    """
    if device_name not in devices_cfg:
        raise NotFoundError(f"no teleoperation device '{device_name}'; {suggest(device_name, devices_cfg)}")
    raise DEVICES.error(name=f"'{device_name}'")


def remove_camera_configs(env_cfg: Any) -> Any:
    """Set every camera of the scene to None and drop observation terms that read one.

    Args:
        env_cfg: an environment config, changed in place and returned.
    """
    cameras = [name for name, value in vars(env_cfg.scene).items() if isinstance(value, CameraCfg)]
    for name in cameras:
        setattr(env_cfg.scene, name, None)
    for group in vars(env_cfg.observations).values():
        for name, term in list(getattr(group, "__dict__", {}).items()):
            entities = getattr(term, "params", None) or {}
            if any(getattr(entity, "name", None) in cameras for entity in entities.values()):
                setattr(group, name, None)
    return env_cfg


place(__name__)
