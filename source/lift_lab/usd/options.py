"""Solver options that a stage does not set: those that scenes set, so that a file behaves alike in both."""

from __future__ import annotations

import mujoco

from lift_lab.usd.report import ImportReport

SCENE_OPTIONS: dict[str, int | mujoco.mjtIntegrator] = {
    "integrator": mujoco.mjtIntegrator.mjINT_IMPLICITFAST,
    "iterations": 10,
    "ls_iterations": 20,
}
"""Options in which the defaults of :class:`lift_lab.sim.MujocoCfg` differ from MuJoCo's."""


def set_scene_options(spec: mujoco.MjSpec, report: ImportReport) -> None:
    """Give a spec the solver options of scenes where its stage has none, and say so in the report.

    MuJoCo's own default, the Euler integrator, takes the damping of drives explicitly and becomes unstable with gains
    that are usual for PhysX.
    """
    authored = {source.field for source in report.options}
    for name, value in SCENE_OPTIONS.items():
        if name not in authored:
            setattr(spec.option, name, value)
            text = mujoco.mjtIntegrator(value).name.removeprefix("mjINT_").lower() if name == "integrator" else value
            report.assumed_options[name] = str(text)
