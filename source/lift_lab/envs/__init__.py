"""Environments: a scene, its managers, and the step that ties them together."""

from . import mdp
from .common import VecEnvObs, VecEnvStepReturn, ViewerCfg
from .direct import (
    DirectMARLEnv,
    DirectMARLEnvCfg,
    DirectRLEnv,
    DirectRLEnvCfg,
    multi_agent_to_single_agent,
    multi_agent_with_one_agent,
)
from .manager_based_env import ManagerBasedEnv
from .manager_based_env_cfg import ManagerBasedEnvCfg
from .manager_based_rl_env import ManagerBasedRLEnv
from .manager_based_rl_env_cfg import ManagerBasedRLEnvCfg
from .vector_env import ManagerBasedRLVectorEnv

__all__ = [
    "DirectMARLEnv",
    "DirectMARLEnvCfg",
    "DirectRLEnv",
    "DirectRLEnvCfg",
    "ManagerBasedEnv",
    "ManagerBasedEnvCfg",
    "ManagerBasedRLEnv",
    "ManagerBasedRLEnvCfg",
    "ManagerBasedRLVectorEnv",
    "VecEnvObs",
    "VecEnvStepReturn",
    "ViewerCfg",
    "mdp",
    "multi_agent_to_single_agent",
    "multi_agent_with_one_agent",
]
