"""Isaac Lab's names of the direct workflow: types for imports, annotations and ``isinstance``.

Scripts of Isaac Lab ask ``isinstance(env_cfg, DirectRLEnvCfg)``; no task here is one. Making one raises.
"""

from __future__ import annotations

from typing import Any, NoReturn

import gymnasium as gym

from lift_lab.utils import configclass
from lift_lab.utils.errors import ConfigError


@configclass
class DirectRLEnvCfg:
    """Config of an environment of the direct workflow: making one raises."""

    def __post_init__(self) -> None:
        """Refuse.

        Raises:
            ConfigError: always.
        """
        _refuse(type(self))


@configclass
class DirectMARLEnvCfg:
    """Config of a multi-agent environment: making one raises."""

    def __post_init__(self) -> None:
        """Refuse.

        Raises:
            ConfigError: always.
        """
        _refuse(type(self))


class DirectRLEnv(gym.Env):
    """An environment of the direct workflow: making one raises."""

    def __init__(self, cfg: Any, *args: Any, **kwargs: Any):
        """Refuse.

        Raises:
            ConfigError: always.
        """
        _refuse(type(self))


class DirectMARLEnv(gym.Env):
    """A multi-agent environment: making one raises."""

    def __init__(self, cfg: Any, *args: Any, **kwargs: Any):
        """Refuse.

        Raises:
            ConfigError: always.
        """
        _refuse(type(self))


def multi_agent_to_single_agent(env: Any, state_as_observation: bool = False) -> NoReturn:
    """Isaac Lab's conversion of a multi-agent environment.

    Raises:
        ConfigError: always.
    """
    _refuse(type(env))


def multi_agent_with_one_agent(env: Any, state_as_observation: bool = False) -> NoReturn:
    """Isaac Lab's conversion of a multi-agent environment.

    Raises:
        ConfigError: always.
    """
    _refuse(type(env))


def _refuse(kind: type) -> NoReturn:
    raise ConfigError(f"{kind.__name__}: only the manager-based workflow exists here; see ManagerBasedRLEnv")
