"""Environments: a scene, its managers, and the step that ties them together."""

from . import mdp
from .common import VecEnvObs, VecEnvStepReturn, ViewerCfg
from .manager_based_env import ManagerBasedEnv
from .manager_based_env_cfg import ManagerBasedEnvCfg
from .manager_based_rl_env import ManagerBasedRLEnv
from .manager_based_rl_env_cfg import ManagerBasedRLEnvCfg

__all__ = [
    "ManagerBasedEnv",
    "ManagerBasedEnvCfg",
    "ManagerBasedRLEnv",
    "ManagerBasedRLEnvCfg",
    "VecEnvObs",
    "VecEnvStepReturn",
    "ViewerCfg",
    "mdp",
]
