#!/usr/bin/env bash
# newton 1.8.0 (with the MuJoCo 3.17.0 that it asks for): dynamics that its MJCF importer reads otherwise than MuJoCo.
#
# Guess before the run: a position actuator with kp 30 and gear 2 holds its joint with gear * gear * kp = 120 Nm/rad,
# and <option gravity> is the gravity of the model. What is not read is named in a warning.
# Seen: the gear of a position or velocity actuator is dropped: the stiffness at the joint is 30 and not 120. The vector
# of <option gravity> is ignored and the builder's 9.81 stays, although <flag gravity="disable"/> is followed. There is
# no warning.
# Why it matters: a geared servo is weaker by the square of its gear, and a scene with another or a tilted gravity runs
# with the Earth's. Gains and gravity must be compared after an import.
#
# Prints what is seen and fails if it changes.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/venv"
"$work/venv/bin/python" -m pip install --quiet --no-compile newton==1.8.0 mujoco==3.17.0 warp-lang==1.19.0
cat > "$work/dynamics.py" <<'PY'
import warnings

import mujoco
import warp as wp

wp.config.log_level = wp.LOG_ERROR
import newton  # noqa: E402
from newton.solvers import SolverMuJoCo  # noqa: E402


def robot(actuator, option=""):
    """One hinge with one actuator."""
    return f"""<mujoco>{option}<worldbody><body><joint name="j" axis="0 1 0"/><geom class="c" size=".1"/></body>
    </worldbody><default><default class="c"/></default><actuator>{actuator}</actuator></mujoco>"""


def imported(text):
    """Newton's builder, and its warnings of the import."""
    builder = newton.ModelBuilder()
    SolverMuJoCo.register_custom_attributes(builder)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        builder.add_mjcf(text)
    return builder, [str(w.message) for w in caught if "newton" in str(w.category).lower()]


def gains(model):
    """Stiffness and damping of the only actuator at its joint."""
    return tuple(abs(float(model.actuator_biasprm[0, i])) * float(model.actuator_gear[0, 0]) ** 2 for i in (1, 2))


print("newton", newton.__version__, "mujoco", mujoco.__version__)
for kind, wanted, seen in (
    ('position kp="30" kv="2" gear="1"', (30, 2), (30, 2)),
    ('position kp="30" kv="2" gear="2"', (120, 8), (30, 2)),
    ('velocity kv="3" gear="10"', (0, 300), (0, 3)),
):
    text = robot(f'<{kind} joint="j"/>')
    mine = gains(mujoco.MjModel.from_xml_string(text))
    builder, lines = imported(text)
    theirs = builder.joint_target_ke[-1], builder.joint_target_kd[-1]
    print(f"{kind}: stiffness and damping at the joint by MuJoCo {mine}, by Newton {theirs}, warnings {len(lines)}")
    assert (mine, theirs, lines) == (wanted, seen, []), lines
for option, wanted, seen in (
    ('<option gravity="0 0 -1.62"/>', (0, 0, -1.62), (0, 0, -9.81)),
    ('<option gravity="3 0 -9"/>', (3, 0, -9), (0, 0, -9.81)),
    ('<option><flag gravity="disable"/></option>', (0, 0, 0), (0, 0, 0)),
):
    text = robot('<motor joint="j"/>', option)
    model = mujoco.MjModel.from_xml_string(text)
    off = bool(model.opt.disableflags & mujoco.mjtDisableBit.mjDSBL_GRAVITY)
    mine = (0, 0, 0) if off else tuple(model.opt.gravity.tolist())
    builder, lines = imported(text)
    theirs = builder.gravity if hasattr(builder.gravity, "__len__") else (0, 0, builder.gravity)
    theirs = tuple(round(float(x), 4) + 0.0 for x in theirs)
    print(f"{option}: gravity by MuJoCo {mine}, by Newton {theirs}, warnings {len(lines)}")
    assert (mine, theirs, lines) == (wanted, seen, []), lines
PY
WARP_CACHE_PATH="$work/cache" "$work/venv/bin/python" "$work/dynamics.py" 2>/dev/null
