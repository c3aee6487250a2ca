"""Configuration of random network distillation, in Isaac Lab 2.3's names."""

from __future__ import annotations

from typing import ClassVar

from lift_lab.utils import MISSING, ConfigBase, configclass
from lift_lab.utils.ranges import COUNT, COUNT_OR_ZERO, NOT_NEGATIVE, POSITIVE, Range, Ranges


@configclass
class RslRlRndCfg(ConfigBase):
    """Intrinsic reward for states that a network predicts badly (Burda et al. 2018, arXiv:1810.12894)."""

    @configclass
    class WeightScheduleCfg:
        """Schedule of the weight."""

        mode: str = "constant"
        """Kind of schedule."""

    @configclass
    class LinearWeightScheduleCfg(WeightScheduleCfg):
        """Weight that goes linearly to ``final_value`` between two steps."""

        mode: str = "linear"
        final_value: float = MISSING
        """Weight at the end."""
        initial_step: int = MISSING
        """Step at which the change begins."""
        final_step: int = MISSING
        """Step at which it ends."""

        _ranges: ClassVar[Ranges] = {"final_value": NOT_NEGATIVE, "initial_step final_step": COUNT_OR_ZERO}

    @configclass
    class StepWeightScheduleCfg(WeightScheduleCfg):
        """Weight that jumps to ``final_value`` at a step."""

        mode: str = "step"
        final_step: int = MISSING
        """Step of the jump."""
        final_value: float = MISSING
        """Weight from then on."""

        _ranges: ClassVar[Ranges] = {"final_step": COUNT_OR_ZERO, "final_value": NOT_NEGATIVE}

    weight: float = 0.0
    """Weight of the intrinsic reward; scaled by the environment step like every reward."""

    weight_schedule: WeightScheduleCfg | None = None
    """Schedule of the weight; None keeps it constant."""

    reward_normalization: bool = False
    """Whether the intrinsic reward is normalised."""

    state_normalization: bool = False
    """Whether the state given to the networks is normalised."""

    learning_rate: float = 1e-3
    """Learning rate of the predictor."""

    num_outputs: int = 1
    """Outputs of both networks."""

    predictor_hidden_dims: list[int] = [-1]
    """Hidden widths of the predictor; -1 stands for the width of the state."""

    target_hidden_dims: list[int] = [-1]
    """Hidden widths of the target; -1 stands for the width of the state."""

    _ranges: ClassVar[Ranges] = {
        "weight": NOT_NEGATIVE,
        "learning_rate": POSITIVE,
        "num_outputs": COUNT,
        "predictor_hidden_dims target_hidden_dims": Range(1, whole=True, least_entries=1, also=(-1,)),
    }
