"""Isaac Lab's configs of distillation (data only): a task's agent file that names them imports; training does not."""

from __future__ import annotations

from typing import ClassVar, Literal

from lift_lab.utils import MISSING, ConfigBase, configclass
from lift_lab.utils.ranges import COUNT, POSITIVE, POSITIVE_OR_INF, SIZES, Ranges

from .rl_cfg import RslRlBaseRunnerCfg


@configclass
class RslRlDistillationStudentTeacherCfg(ConfigBase):
    """Networks of student and teacher."""

    class_name: str = "StudentTeacher"
    init_noise_std: float = MISSING
    noise_std_type: Literal["scalar", "log"] = "scalar"
    student_obs_normalization: bool = MISSING
    teacher_obs_normalization: bool = MISSING
    student_hidden_dims: list[int] = MISSING
    teacher_hidden_dims: list[int] = MISSING
    activation: str = MISSING

    _ranges: ClassVar[Ranges] = {"init_noise_std": POSITIVE, "student_hidden_dims teacher_hidden_dims": SIZES}


@configclass
class RslRlDistillationStudentTeacherRecurrentCfg(RslRlDistillationStudentTeacherCfg):
    """Recurrent networks of student and teacher."""

    class_name: str = "StudentTeacherRecurrent"
    rnn_type: str = MISSING
    rnn_hidden_dim: int = MISSING
    rnn_num_layers: int = MISSING
    teacher_recurrent: bool = MISSING

    _ranges: ClassVar[Ranges] = {"rnn_hidden_dim rnn_num_layers": COUNT}


@configclass
class RslRlDistillationAlgorithmCfg(ConfigBase):
    """The student learns to act as the teacher."""

    class_name: str = "Distillation"
    num_learning_epochs: int = MISSING
    learning_rate: float = MISSING
    gradient_length: int = MISSING
    max_grad_norm: float | None = None
    optimizer: Literal["adam", "adamw", "sgd", "rmsprop"] = "adam"
    loss_type: Literal["mse", "huber"] = "mse"

    _ranges: ClassVar[Ranges] = {
        "num_learning_epochs gradient_length": COUNT,
        "learning_rate": POSITIVE,
        "max_grad_norm": POSITIVE_OR_INF,
    }


@configclass
class RslRlDistillationRunnerCfg(RslRlBaseRunnerCfg):
    """Distillation: training with one raises, as only the on-policy runner exists here."""

    class_name: str = "DistillationRunner"
    policy: RslRlDistillationStudentTeacherCfg = MISSING
    algorithm: RslRlDistillationAlgorithmCfg = MISSING
