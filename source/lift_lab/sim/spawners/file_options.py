"""Simulation options that an asset's own file sets: in a scene those of ``SimulationCfg`` hold instead."""

from __future__ import annotations

import logging
from typing import Any

import mujoco
import numpy as np

from lift_lab.usd.report import OptionSource

from .spawner_cfg import Spawned

logger = logging.getLogger(__name__)

_SETTINGS = {"timestep": "sim.dt", "gravity": "sim.gravity"} | {
    name: f"sim.mujoco.{name}"
    for name in ("integrator", "cone", "solver", "impratio", "iterations", "ls_iterations", "tolerance")
}
_ENUMS = {"integrator": mujoco.mjtIntegrator, "cone": mujoco.mjtCone, "solver": mujoco.mjtSolver}
_VISUAL = ("global_", "headlight", "map", "quality", "rgba", "scale")
_logged: set[str] = set()
_SIZES = ("memory", "nconmax", "njmax", "nstack")


def adopt_scene_options(spawned: Spawned, scene: mujoco.MjSpec, path: str) -> None:
    """Give an asset's spec the options of the scene that it will join, and remove its keyframes.

    MuJoCo keeps the scene's options when a spec is attached, prints every difference, and warns of keyframes. This
    function notes differing options of the file in the import report instead, and logs them in one line once in a
    process. Keyframes are noted in the report: a scene starts from its assets' ``init_state``.

    Args:
        spawned: the asset; its spec and its report are changed.
        scene: the scene's spec, with the options of ``SimulationCfg``.
        path: where the asset is configured, for the log line.
    """
    asset = spawned.spec
    lost = _differences(spawned, scene)
    for option in _fields(scene.option):
        setattr(asset.option, option, getattr(scene.option, option))
    for group in _VISUAL:
        ours, theirs = getattr(asset.visual, group), getattr(scene.visual, group)
        for name in _fields(theirs):
            setattr(ours, name, getattr(theirs, name))
    for size in _SIZES:
        setattr(asset, size, getattr(scene, size))
    for key in list(asset.keys):
        if spawned.report is not None:
            prim_path = spawned.report.keyframes.get(key.name, "")
            spawned.report.ignore(prim_path, "MjcKeyframe", "in a scene init_state holds")
        asset.delete(key)
    if not lost:
        return
    if spawned.report is not None:
        for source, theirs, ours in lost:
            reason = f"{theirs} here; in a scene {_setting(source)} ({ours}) holds"
            spawned.report.ignore(source.prim_path, source.attribute, reason)
    listed = ", ".join(f"{source.attribute} {theirs} (here {ours})" for source, theirs, ours in lost)
    key = f"{path} {spawned.report.path if spawned.report is not None else ''}: {listed}"
    if key not in _logged:
        _logged.add(key)
        logger.warning("%s: options of its file do not hold in a scene, SimulationCfg's do: %s", path, listed)


def _differences(spawned: Spawned, scene: mujoco.MjSpec) -> list[tuple[OptionSource, str, str]]:
    """What the asset's file sets differently than the scene: where, its value, the scene's value."""
    asset, report = spawned.spec, spawned.report
    if report is not None:
        sources = report.options
    else:
        blank = mujoco.MjSpec().option
        changed = [f for f in _fields(blank) if not _same(getattr(asset.option, f), getattr(blank, f))]
        sources = [OptionSource("", name, name) for name in changed]
    lost = []
    for source in sources:
        theirs, ours = getattr(asset.option, source.field), getattr(scene.option, source.field)
        if source.bit:
            theirs, ours = (_switch(value, source) for value in (theirs, ours))
        if not _same(theirs, ours):
            lost.append((source, _text(source, theirs), _text(source, ours)))
    return lost


def _fields(element: Any) -> list[str]:
    return [name for name in dir(element) if not name.startswith("_") and not callable(getattr(element, name))]


def _same(a: Any, b: Any) -> bool:
    return bool(np.allclose(np.asarray(a, float), np.asarray(b, float), rtol=1e-6, atol=0.0))


def _switch(flags: int, source: OptionSource) -> bool:
    return bool(int(flags) & source.bit) == (source.field == "enableflags")


def _setting(source: OptionSource) -> str:
    return _SETTINGS.get(source.field, "MuJoCo's default")


def _text(source: OptionSource, value: Any) -> str:
    if source.bit:
        return "on" if value else "off"
    if source.field in _ENUMS:
        return _ENUMS[source.field](value).name.split("_", 1)[1].lower()
    return " ".join(f"{v:g}" for v in np.atleast_1d(np.asarray(value, float)))
