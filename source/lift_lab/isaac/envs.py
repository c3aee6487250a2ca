"""The direct workflow."""

from typing import Any, ClassVar, NoReturn

import gymnasium as gym

from lift_lab.utils import configclass

from .finder import place
from .refused import Refused
from .table import DIRECT, Unsupported


@configclass
class DirectRLEnvCfg(Refused):
    """Config of an environment of the direct workflow."""

    missing: ClassVar[Unsupported] = DIRECT


@configclass
class DirectMARLEnvCfg(Refused):
    """Config of a multi-agent environment."""

    missing: ClassVar[Unsupported] = DIRECT


class DirectRLEnv(Refused, gym.Env):
    """An environment of the direct workflow."""

    missing = DIRECT


class DirectMARLEnv(Refused, gym.Env):
    """A multi-agent environment."""

    missing = DIRECT


def multi_agent_to_single_agent(env: Any, state_as_observation: bool = False) -> NoReturn:
    """Refuse to convert a multi-agent environment.

    Raises:
        ConfigError: always.
    """
    raise DIRECT.error(name=type(env).__name__)


def multi_agent_with_one_agent(env: Any, state_as_observation: bool = False) -> NoReturn:
    """Refuse to convert a multi-agent environment.

    Raises:
        ConfigError: always.
    """
    raise DIRECT.error(name=type(env).__name__)


place(__name__)
