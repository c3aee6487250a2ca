"""Isaac Lab's terms that need what is not simulated here.

Their names exist, so that a task file can be imported and its other terms used; an environment whose config uses one
says which feature is missing.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NoReturn

from lift_lab.managers import ManagerTermBase
from lift_lab.utils.errors import ConfigError

if TYPE_CHECKING:
    from lift_lab.envs import ManagerBasedEnv


class UnsupportedTerm(ManagerTermBase):
    """A term that cannot be built."""

    needs: str = ""
    """The feature that it needs."""

    def __init__(self, cfg: Any, env: ManagerBasedEnv):
        """Refuse.

        Raises:
            ConfigError: always.
        """
        raise ConfigError(f"mdp.{type(self).__name__} needs {self.needs}; remove the term")

    def __call__(self, env: ManagerBasedEnv, *args: Any, **params: Any) -> NoReturn:
        """Never reached: the term cannot be built."""
        raise ConfigError(f"mdp.{type(self).__name__} needs {self.needs}")


_CAMERAS = "images, and no camera is simulated"
_RAYS = "a ray caster, which is not simulated"
_ONE_MODEL = "shapes that differ between environments, which share one model"
_LOOKS = "a renderer of textures and colours, and there is none"
_TERRAIN = "a generated terrain, and grounds are planes"


class image(UnsupportedTerm):
    """Isaac Lab's observation of camera images."""

    needs = _CAMERAS


class image_features(UnsupportedTerm):
    """Isaac Lab's observation of features of camera images."""

    needs = _CAMERAS


class height_scan(UnsupportedTerm):
    """Isaac Lab's observation of the ground's height around a sensor."""

    needs = _RAYS


class body_incoming_wrench(UnsupportedTerm):
    """Isaac Lab's observation of the wrench that a joint passes to its body."""

    needs = "joint reaction wrenches, which assets do not read"


class randomize_rigid_body_scale(UnsupportedTerm):
    """Isaac Lab's event that scales objects before the simulation starts."""

    needs = _ONE_MODEL


class randomize_fixed_tendon_parameters(UnsupportedTerm):
    """Isaac Lab's event that changes tendons."""

    needs = "articulations with tendons"


class randomize_visual_texture_material(UnsupportedTerm):
    """Isaac Lab's event that changes textures."""

    needs = _LOOKS


class randomize_visual_color(UnsupportedTerm):
    """Isaac Lab's event that changes colours."""

    needs = _LOOKS


class reset_root_state_from_terrain(UnsupportedTerm):
    """Isaac Lab's event that puts roots onto flat patches of the terrain."""

    needs = _TERRAIN
