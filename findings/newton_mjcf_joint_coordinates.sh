#!/usr/bin/env bash
# newton 1.8.0 beside MuJoCo 3.17.0: poses of one MJCF at the same joint positions.
#
# Guess before the run: a joint position means the same in both, so a keyframe or a recorded trajectory of MuJoCo gives
# the same poses by newton.eval_fk, and the same numbers serve as limits and targets.
# Seen: two deviations without a warning. Newton puts all hinges of one body at the anchor of the first, so that with
# anchors 4 cm apart the body is 3 cm off at 0.5 and 0.7 rad. A joint with ref is counted from the pose in the file:
# Newton's position is MuJoCo's minus ref, and its limits are moved with it.
# Why it matters: robots with two hinges in a body (an ankle of which one axis lies lower) have another geometry, and
# positions, targets and keyframes of a robot with ref are off by ref in every joint that has one.
#
# Prints what is seen and fails if it changes.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/venv"
"$work/venv/bin/python" -m pip install --quiet --no-compile newton==1.8.0 mujoco==3.17.0 warp-lang==1.19.0
cat > "$work/poses.py" <<'PY'
import warnings

import mujoco
import numpy as np
import warp as wp

wp.config.log_level = wp.LOG_ERROR
wp.config.optimization_level = 0  # compiles faster
import newton  # noqa: E402


def robot(joints):
    """One link with these joints."""
    return f"""<mujoco><compiler angle="radian"/><worldbody><body name="foot">{joints}
    <geom type="capsule" fromto="0 0 0 .3 0 0" size=".03"/></body></worldbody></mujoco>"""


def by_mujoco(text, positions):
    """Position and quaternion (wxyz) of the link."""
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    data.qpos[:] = positions
    mujoco.mj_kinematics(model, data)
    return data.xpos[1].copy(), data.xquat[1].copy(), model.jnt_range.copy()


def by_newton(text, positions):
    """The same of Newton; its quaternions are xyzw."""
    builder = newton.ModelBuilder()
    builder.add_mjcf(text)
    model = builder.finalize(device="cpu")
    state = model.state()
    state.joint_q.assign(np.array(positions, np.float32))
    newton.eval_fk(model, state.joint_q, state.joint_qd, state)
    pose = state.body_q.numpy()[0]
    limits = np.stack([model.joint_limit_lower.numpy(), model.joint_limit_upper.numpy()], axis=1)
    return pose[:3], np.roll(pose[3:], 1), limits


def apart(text, positions, theirs=None):
    """Distance in metres, angle in radians and limits of both."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        p, q, limits = by_mujoco(text, positions)
        r, s, others = by_newton(text, positions if theirs is None else theirs)
    lines = [str(w.message) for w in caught if issubclass(w.category, UserWarning) and "ewton" in str(w.category)]
    assert not lines, lines
    return round(float(np.linalg.norm(p - r)), 4), round(2 * float(np.arccos(min(1, abs(q @ s)))), 3), limits, others


print("newton", newton.__version__, "mujoco", mujoco.__version__)
hinges = '<joint axis="0 1 0" pos="0 0 .08"/><joint axis="1 0 0" pos="0 0 {}"/>'
for height, wanted in ((0.08, 0.0), (0.04, 0.0273)):
    distance, angle, *_ = apart(robot(hinges.format(height)), [0.5, 0.7])
    print(f"hinges at z = 0.08 and {height}: positions of the body {distance} m apart, turned by {angle}")
    assert abs(distance - wanted) < 1e-3 and angle < 2e-3
text = robot('<joint axis="0 1 0" ref="0.3" range="-1 1.5"/>')
_, angle, limits, others = apart(text, [0.5])
print(f"ref 0.3, both at position 0.5: turned by {angle}; limits {limits[0]} and {np.round(others[0], 3)}")
assert angle == 0.3 and np.allclose(limits - 0.3, others, atol=1e-5)
_, angle, *_ = apart(text, [0.5], [0.2])
print(f"ref 0.3, MuJoCo at 0.5 and Newton at 0.2: turned by {angle}")
assert angle < 2e-3
PY
WARP_CACHE_PATH="$work/cache" "$work/venv/bin/python" "$work/poses.py" 2>/dev/null
