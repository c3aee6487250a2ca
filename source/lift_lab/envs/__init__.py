"""Environments: a scene, its managers, and the step that ties them together."""

from typing import TYPE_CHECKING

from lift_lab.isaac.finder import attributes_of

from . import mdp
from .common import *
from .manager_based_env import *
from .manager_based_env_cfg import *
from .manager_based_rl_env import *
from .manager_based_rl_env_cfg import *
from .vector_env import *

if TYPE_CHECKING:
    from ..isaac.envs import *
else:
    __getattr__, __dir__, __all__ = attributes_of(__name__)
    __all__ += ["mdp"]
