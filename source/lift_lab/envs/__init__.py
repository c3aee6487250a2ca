"""Environments: a scene, its managers, and the step that ties them together."""

from typing import TYPE_CHECKING

from lift_lab.isaac.finder import attributes_of

from . import mdp
from .common import VecEnvObs, VecEnvStepReturn, ViewerCfg
from .manager_based_env import ManagerBasedEnv
from .manager_based_env_cfg import ManagerBasedEnvCfg
from .manager_based_rl_env import ManagerBasedRLEnv
from .manager_based_rl_env_cfg import ManagerBasedRLEnvCfg
from .vector_env import ManagerBasedRLVectorEnv

if TYPE_CHECKING:
    from ..isaac.envs import *
else:
    __getattr__, __dir__, __all__ = attributes_of(__name__)
    __all__ += ["mdp"]
