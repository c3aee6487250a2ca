"""Isaac Lab's action of a surface gripper: a type for configs."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NoReturn

from lift_lab.managers import ActionTerm
from lift_lab.utils.errors import ConfigError

if TYPE_CHECKING:
    from lift_lab.envs import ManagerBasedEnv


class SurfaceGripperBinaryAction(ActionTerm):
    """Opens and closes a surface gripper: making one raises."""

    def __init__(self, cfg: Any, env: ManagerBasedEnv):
        """Refuse.

        Raises:
            ConfigError: always.
        """
        self._refuse()

    def _refuse(self) -> NoReturn:
        raise ConfigError(f"mdp.{type(self).__name__}: surface grippers are not simulated; remove the action")

    @property
    def action_dim(self) -> int:
        """Never reached."""
        self._refuse()

    @property
    def raw_actions(self) -> NoReturn:
        """Never reached."""
        self._refuse()

    @property
    def processed_actions(self) -> NoReturn:
        """Never reached."""
        self._refuse()

    def process_actions(self, actions: Any) -> None:
        """Never reached."""
        self._refuse()

    def apply_actions(self) -> None:
        """Never reached."""
        self._refuse()
