"""Settings that only one of the engines has, or that one of them cannot honour."""

from __future__ import annotations

from lift_lab.utils.errors import ConfigError

from .ignored import note_ignored
from .simulation_cfg import SimulationCfg

WARP_LEAST_TOLERANCE = 1e-6
"""mujoco_warp 4.0 raises a smaller solver tolerance to this: it computes in float32."""

_WARP_SOLVERS = ("CG", "Newton")


def check_engine_settings(cfg: SimulationCfg, device: str) -> None:
    """Refuse what the chosen engine would change, and note what it does not use.

    Args:
        cfg: the simulation's settings.
        device: the resolved torch device; it chooses the engine where ``cfg.physics`` is None.

    Raises:
        ConfigError: a solver tolerance or a solver that the warp engine does not have.
    """
    mj = cfg.mujoco
    kind = cfg.physics or ("native" if device == "cpu" else "warp")
    if kind == "native":
        for name in ("nconmax", "njmax"):
            if getattr(mj, name) is not None:
                note_ignored(f"sim.mujoco.{name}", "the native engine makes room for contacts as they come")
        return
    if kind != "warp":  # named by the engine's own error
        return
    if mj.tolerance is not None and mj.tolerance < WARP_LEAST_TOLERANCE:
        raise ConfigError(
            f"sim.mujoco.tolerance: the warp engine computes in float32 and would raise {mj.tolerance:g} to"
            f" {WARP_LEAST_TOLERANCE:g}; set {WARP_LEAST_TOLERANCE:g} or more, None, or sim.physics 'native'"
        )
    if mj.solver not in _WARP_SOLVERS:
        raise ConfigError(
            f"sim.mujoco.solver: the warp engine has no '{mj.solver}'; choose one of"
            f" {', '.join(_WARP_SOLVERS)}, or sim.physics 'native'"
        )
    if cfg.num_threads is not None:
        note_ignored("sim.num_threads", "the warp engine has no threads")
