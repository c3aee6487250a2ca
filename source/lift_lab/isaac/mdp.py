"""Terms that need features which are not simulated. An environment with such a term raises an error with the reason."""

from typing import Any, ClassVar, NoReturn

from lift_lab.managers import ActionTerm, ActionTermCfg, ManagerTermBase
from lift_lab.utils import configclass
from lift_lab.utils.ranges import FINITE, Ranges

from .finder import place
from .refused import Refused
from .table import GRIPPER_ACTIONS, HEIGHTS, IMAGES, LOOKS, PATCHES, SCALES, TENDONS, WRENCHES


class _Term(Refused, ManagerTermBase):
    def __call__(self, env: Any, *args: Any, **params: Any) -> NoReturn:
        """Never reached: there is no such term. The signature takes whatever a config gives."""
        raise NotImplementedError


class image(_Term):
    """Observation of camera images."""

    missing = IMAGES


class image_features(_Term):
    """Observation of features of camera images."""

    missing = IMAGES


class height_scan(_Term):
    """Observation of the ground's height around a sensor."""

    missing = HEIGHTS


class body_incoming_wrench(_Term):
    """Observation of the wrench that a joint passes to its body."""

    missing = WRENCHES


class randomize_rigid_body_scale(_Term):
    """Event that scales objects before the simulation starts."""

    missing = SCALES


class randomize_fixed_tendon_parameters(_Term):
    """Event that changes tendons."""

    missing = TENDONS


class randomize_visual_texture_material(_Term):
    """Event that changes textures."""

    missing = LOOKS


class randomize_visual_color(_Term):
    """Event that changes colours."""

    missing = LOOKS


class reset_root_state_from_terrain(_Term):
    """Event that puts roots onto flat patches of the terrain."""

    missing = PATCHES


class SurfaceGripperBinaryAction(Refused, ActionTerm):
    """Action that opens and closes a surface gripper."""

    missing = GRIPPER_ACTIONS


@configclass
class SurfaceGripperBinaryActionCfg(ActionTermCfg):
    """Config of a surface gripper's action."""

    class_type: type = SurfaceGripperBinaryAction
    open_command: float = -1.0
    """Command that opens the gripper."""
    close_command: float = 1.0
    """Command that closes it."""

    _ranges: ClassVar[Ranges] = {"open_command close_command": FINITE}


place(__name__)
