#!/usr/bin/env bash
# MuJoCo 4.0.0, newton 1.8.0 and urdf-usd-converter 0.3.4: the limits of one URDF, read by three libraries.
#
# Guess before the run: all three follow URDF's rules: a bound that is not given is 0, a joint whose bounds coincide
# cannot move, and bounds of a continuous joint have no effect.
# Seen: only the converter does. MuJoCo's parser drops the limit of a joint if one bound is missing, without a line, or
# if both are equal, with a warning: joints that are locked in the file turn freely. Newton takes a missing bound as
# none, and limits continuous joints.
# Why it matters: a joint that the file locks (a finger, a torso that is not used) moves in one simulator and not in the
# other, and a limit such as upper="1.5" alone is lost in MuJoCo. A reader of URDF has to set limits itself.
#
# Prints what is seen and fails if it changes.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/venv"
"$work/venv/bin/python" -m pip install --quiet --no-compile \
    mujoco==4.0.0 newton==1.8.0 warp-lang==1.19.0 urdf-usd-converter==0.3.4
cat > "$work/limits.py" <<'PY'
import math
import sys
from importlib.metadata import version
from pathlib import Path

import mujoco
import warp as wp
from pxr import Usd, UsdPhysics
from urdf_usd_converter import Converter

wp.config.log_level = wp.LOG_ERROR
import newton  # noqa: E402

FREE, LOCKED = (-math.inf, math.inf), (0.0, 0.0)
# kind, attributes of <limit>, then the range by MuJoCo, by Newton and by the converter
CASES = {
    "both": ("revolute", 'lower="-1" upper="0.5"', (-1, 0.5), (-1, 0.5), (-1, 0.5)),
    "equal": ("revolute", 'lower="0" upper="0"', FREE, LOCKED, LOCKED),
    "neither": ("revolute", "", FREE, FREE, LOCKED),
    "upper_alone": ("revolute", 'upper="1.5"', FREE, (-math.inf, 1.5), (0, 1.5)),
    "continuous": ("continuous", 'lower="-1" upper="1"', FREE, (-1, 1), FREE),
}
INERTIA = '<inertia ixx=".01" iyy=".01" izz=".01" ixy="0" ixz="0" iyz="0"/>'


def link(name):
    """A link of 1 kg."""
    return f'<link name="{name}"><inertial><mass value="1"/>{INERTIA}</inertial></link>'


def robot():
    """The URDF: one joint a case, all on the same base."""
    text = link("base")
    for name, (kind, bounds, *_) in CASES.items():
        text += link(f"link_{name}") + f'<joint name="{name}" type="{kind}"><parent link="base"/>'
        text += f'<child link="link_{name}"/><axis xyz="0 0 1"/><limit {bounds} effort="5" velocity="2"/></joint>'
    return f'<robot name="robot">{text}</robot>'


def span(low, high):
    """A range, with any bound beyond 1e6 as infinite."""
    return round(float(low), 5) if low > -1e6 else -math.inf, round(float(high), 5) if high < 1e6 else math.inf


def by_mujoco(path):
    """Ranges of the compiled model."""
    model = mujoco.MjModel.from_xml_path(str(path))
    return {n: span(*model.joint(n).range) if model.joint(n).limited[0] else FREE for n in CASES}


def by_newton(path):
    """Ranges of the builder."""
    builder = newton.ModelBuilder()
    builder.add_urdf(str(path))
    found = {}
    for name in CASES:
        joint = next(i for i, label in enumerate(builder.joint_label) if label.split("/")[-1] == name)
        dof = builder.joint_qd_start[joint]
        found[name] = span(builder.joint_limit_lower[dof], builder.joint_limit_upper[dof])
    return found


def by_converter(path, folder):
    """Ranges on the stage, in radians."""
    stage = Usd.Stage.Open(Converter().convert(str(path), str(folder)).path)
    joints = {p.GetName(): UsdPhysics.RevoluteJoint(p) for p in stage.Traverse() if p.IsA(UsdPhysics.RevoluteJoint)}
    bounds = {n: (joints[n].GetLowerLimitAttr().Get(), joints[n].GetUpperLimitAttr().Get()) for n in CASES}
    return {n: span(math.radians(low), math.radians(high)) for n, (low, high) in bounds.items()}


print(*(f"{name} {version(name)}" for name in ("mujoco", "newton", "urdf-usd-converter")))
work = Path(sys.argv[1])
path = work / "robot.urdf"
path.write_text(robot())
seen = by_mujoco(path), by_newton(path), by_converter(path, work / "usd")
for name, (kind, bounds, *wanted) in CASES.items():
    ranges = [reader[name] for reader in seen]
    print(f"{kind:10s} <limit {bounds:22s}> MuJoCo {ranges[0]}, Newton {ranges[1]}, converter {ranges[2]}")
    assert ranges == wanted, (name, ranges, wanted)
PY
"$work/venv/bin/python" "$work/limits.py" "$work" 2>/dev/null
