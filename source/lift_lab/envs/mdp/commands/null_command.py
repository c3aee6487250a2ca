"""A command term that commands nothing."""

from __future__ import annotations

from typing import TYPE_CHECKING

import torch

from lift_lab.managers import CommandTerm
from lift_lab.utils.indexing import EnvIds

if TYPE_CHECKING:
    from .commands_cfg import NullCommandCfg

__all__ = [
    "NullCommand",
]


class NullCommand(CommandTerm):
    """Stands where a command term is expected and there is none."""

    cfg: NullCommandCfg

    @property
    def command(self) -> torch.Tensor:
        """Nothing.

        Raises:
            RuntimeError: always.
        """
        raise RuntimeError("a NullCommand has no command to read")

    def reset(self, env_ids: EnvIds = None) -> dict[str, torch.Tensor]:
        """Do nothing."""
        return {}

    def compute(self, dt: float) -> None:
        """Do nothing."""

    def _resample_command(self, env_ids: torch.Tensor) -> None:
        pass

    def _update_command(self) -> None:
        pass
