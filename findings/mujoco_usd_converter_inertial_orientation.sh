#!/usr/bin/env bash
# mujoco-usd-converter 0.8.0 (with the MuJoCo 3.16.0 that it asks for): the orientation of <inertial>.
#
# Guess before the run: however <inertial> gives its orientation, the stage holds the inertia that MuJoCo compiles.
# Seen: quat and fullinertia arrive. The turn of euler, axisangle, zaxis and xyaxes is lost: physics:principalAxes is
# (1, 0, 0, 0), authored, and nothing is written about it. The same attributes arrive where they turn a body.
# Why it matters: the stage looks complete and every importer of it has a link with moments of inertia about wrong axes,
# for moments of 2, 3 and 4 up to a quarter of the greatest. Code that reads MjSpec itself meets the same: body.iquat
# holds quat alone, and the other forms stand in body.ialt until the spec is compiled.
#
# Prints what is seen and fails if it changes.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/venv"
"$work/venv/bin/python" -m pip install --quiet --no-compile mujoco-usd-converter==0.8.0 mujoco==3.16.0
cat > "$work/inertia.py" <<'PY'
import sys
from importlib.metadata import version
from pathlib import Path

import mujoco
import numpy as np
from mujoco_usd_converter import Converter
from pxr import Usd, UsdPhysics

TURNS = {
    "quat": 'quat=".9 .3 .2 .1"',
    "euler": 'euler="10 20 30"',
    "axisangle": 'axisangle="1 1 0 40"',
    "zaxis": 'zaxis="1 1 1"',
    "xyaxes": 'xyaxes="0 1 0 -1 0 .2"',
}


def link(name, turn):
    """A link turned by 20 degrees whose inertia is turned as well."""
    return f"""<body name="{name}" euler="0 0 20"><joint axis="0 1 0"/><geom size=".01"/>
    <inertial pos="0 0 0" mass=".3" diaginertia=".002 .003 .004" {turn}/></body>"""


def matrix(quaternion, moments=None):
    """The rotation, or the inertia turned by it."""
    turn = np.zeros(9)
    mujoco.mju_quat2Mat(turn, np.array(quaternion, float))
    turn = turn.reshape(3, 3)
    return turn if moments is None else turn @ np.diag(moments) @ turn.T


def wxyz(quaternion):
    """Four numbers of pxr's quaternion."""
    return [quaternion.GetReal(), *quaternion.GetImaginary()]


print("mujoco-usd-converter", version("mujoco-usd-converter"), "mujoco", mujoco.__version__)
work = Path(sys.argv[1])
path = work / "links.xml"
links = "".join(link(name, turn) for name, turn in TURNS.items())
path.write_text(f'<mujoco model="links"><worldbody>{links}</worldbody></mujoco>')
model = mujoco.MjModel.from_xml_path(str(path))
spec = mujoco.MjSpec.from_file(str(path))
stage = Usd.Stage.Open(Converter().convert(str(path), str(work / "usd")).path)
prims = {prim.GetName(): prim for prim in stage.Traverse()}
for name in TURNS:
    body, mass = model.body(name), UsdPhysics.MassAPI(prims[name])
    axes = wxyz(mass.GetPrincipalAxesAttr().Get())
    theirs = matrix(axes, mass.GetDiagonalInertiaAttr().Get())
    error = float(np.abs(theirs - matrix(body.iquat, body.inertia)).max())
    turn = matrix(wxyz(prims[name].GetAttribute("xformOp:orient").Get()))
    print(f"{name:9s} axes on the stage {np.round(axes, 3)}, error of the inertia {error:.1e} of 4.0e-03")
    assert np.allclose(turn, matrix(body.quat), atol=1e-6)
    assert mass.GetPrincipalAxesAttr().HasAuthoredValue()
    if name == "quat":
        assert error < 1e-8
    else:
        assert error > 4e-4 and axes == [1, 0, 0, 0]
        assert list(spec.body(name).iquat) == [1, 0, 0, 0]
PY
"$work/venv/bin/python" "$work/inertia.py" "$work" 2>/dev/null | grep -v "^Status"
