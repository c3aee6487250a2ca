"""What all retargeters share: configs hold data, making a retargeter raises."""

from __future__ import annotations

from lift_lab.utils import configclass
from lift_lab.utils.errors import ConfigError


class RetargeterBase:
    """A type for configs and annotations; making one raises."""

    def __init__(self, cfg: RetargeterCfg):
        """Refuse.

        Raises:
            ConfigError: always.
        """
        raise ConfigError(f"{type(self).__name__}: retargeting of teleoperation devices is not supported")


@configclass
class RetargeterCfg:
    """Base of retargeter configs."""

    retargeter_type: type[RetargeterBase] | None = None
    """The retargeter."""
    sim_device: str = "cpu"
    """Torch device of the commands."""
