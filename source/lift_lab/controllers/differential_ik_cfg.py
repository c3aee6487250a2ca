"""Config of the differential inverse kinematics controller."""

from __future__ import annotations

from typing import ClassVar, Literal

from lift_lab.utils import MISSING, ConfigBase, configclass
from lift_lab.utils.errors import ConfigError, suggest
from lift_lab.utils.ranges import FINITE, Ranges

from .differential_ik import DifferentialIKController

DEFAULT_IK_PARAMS: dict[str, dict[str, float]] = {
    "pinv": {"k_val": 1.0},
    "svd": {"k_val": 1.0, "min_singular_value": 1e-5},
    "trans": {"k_val": 1.0},
    "dls": {"lambda_val": 0.01},
}
"""Parameters of each method, with their defaults."""


@configclass
class DifferentialIKControllerCfg(ConfigBase):
    """Config of :class:`DifferentialIKController`."""

    class_type: type = DifferentialIKController
    """The controller."""

    command_type: Literal["position", "pose"] = MISSING
    """Whether the position or the whole pose of the end effector is controlled."""

    use_relative_mode: bool = False
    """Whether commands are changes to the current pose, or poses."""

    ik_method: Literal["pinv", "svd", "trans", "dls"] = MISSING
    """Inverse of the Jacobian: pseudo-inverse, pseudo-inverse without small singular values, transpose, or damped least
    squares."""

    ik_params: dict[str, float] | None = None
    """Parameters of the method: ``k_val`` (gain; pinv, svd, trans), ``min_singular_value`` (svd), ``lambda_val``
    (damping; dls). Parameters that are missing have their defaults."""

    _ranges: ClassVar[Ranges] = {"ik_params": FINITE}

    def __post_init__(self):
        for field, value, choices in (
            ("command_type", self.command_type, ("position", "pose")),
            ("ik_method", self.ik_method, tuple(DEFAULT_IK_PARAMS)),
        ):
            if value is not MISSING and value not in choices:
                raise ConfigError(f"DifferentialIKControllerCfg.{field}: {suggest(str(value), choices)}")
        if self.ik_method is MISSING:
            return
        defaults = DEFAULT_IK_PARAMS[self.ik_method]
        given = self.ik_params or {}
        for name in given:
            if name not in defaults:
                raise ConfigError(
                    f"DifferentialIKControllerCfg.ik_params: '{self.ik_method}' has no '{name}': "
                    f"{suggest(name, defaults)}"
                )
        self.ik_params = {**defaults, **given}
