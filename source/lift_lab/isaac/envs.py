"""The direct workflow, and descriptions of observation terms."""

from collections.abc import Callable
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


def generic_io_descriptor(_func: Callable[..., Any] | None = None, **description: Any) -> Any:
    """Leave the decorated term as it is; used with or without arguments.

    Args:
        _func: the term, where the decorator is used without arguments.
        **description: Isaac Lab's ``on_inspect``, ``units`` and so on.
    """
    return _func if _func is not None else lambda function: function


def _record(*args: Any, **kwargs: Any) -> None:
    """An ``on_inspect`` hook of Isaac Lab's; never called."""


record_shape = record_dtype = record_joint_names = record_body_names = _record
record_joint_pos_offsets = record_joint_vel_offsets = _record

place(__name__)
