"""rsl_rl: configuration in Isaac Lab's names, environment wrapper, runner and export."""

from .cfg_conversion import to_rsl_rl
from .distillation_cfg import (
    RslRlDistillationAlgorithmCfg,
    RslRlDistillationRunnerCfg,
    RslRlDistillationStudentTeacherCfg,
    RslRlDistillationStudentTeacherRecurrentCfg,
)
from .evaluation_cfg import RslRlEvaluationCfg
from .export_metadata import policy_metadata
from .exporter import export_policy_as_jit, export_policy_as_onnx
from .ppo import LiftLabPPO
from .rl_cfg import (
    RslRlBaseRunnerCfg,
    RslRlOnPolicyRunnerCfg,
    RslRlPpoActorCriticCfg,
    RslRlPpoActorCriticRecurrentCfg,
    RslRlPpoAlgorithmCfg,
)
from .rnd_cfg import RslRlRndCfg
from .runner import LiftLabRunner
from .symmetry_cfg import RslRlSymmetryCfg
from .vecenv_wrapper import RslRlVecEnvWrapper

__all__ = [
    "LiftLabPPO",
    "LiftLabRunner",
    "RslRlBaseRunnerCfg",
    "RslRlDistillationAlgorithmCfg",
    "RslRlDistillationRunnerCfg",
    "RslRlDistillationStudentTeacherCfg",
    "RslRlDistillationStudentTeacherRecurrentCfg",
    "RslRlEvaluationCfg",
    "RslRlOnPolicyRunnerCfg",
    "RslRlPpoActorCriticCfg",
    "RslRlPpoActorCriticRecurrentCfg",
    "RslRlPpoAlgorithmCfg",
    "RslRlRndCfg",
    "RslRlSymmetryCfg",
    "RslRlVecEnvWrapper",
    "export_policy_as_jit",
    "export_policy_as_onnx",
    "policy_metadata",
    "to_rsl_rl",
]
