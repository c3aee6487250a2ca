#!/usr/bin/env bash
# MuJoCo 4.0.0: what mj_ray passes by although contacts are made with it.
#
# Guess before the run: a ray hits whatever a falling ball lands on. The size of a plane and the alpha of a colour are
# for drawing alone.
# Seen: a plane of size "1 1 .1" carries a ball at x = 3, but a ray there returns -1; so does a ray from below the
# plane. With size "0 0 .1" the ray hits. A box of alpha 0 carries a ball, and a ray goes through it to the floor.
# Why it matters: a height scan near the edge of the drawn floor reports no ground where the robot stands, and terrain
# whose colliders are hidden by alpha 0 is not in the scan. Hiding by geom group 3 keeps it there.
#
# Prints what is seen and fails if it changes.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/venv"
"$work/venv/bin/python" -m pip install --quiet mujoco==4.0.0
cat > "$work/rays.py" <<'PY'
import mujoco
import numpy as np


def height_of_ball(geom, x):
    """Where a ball of radius 0.1 comes to rest that is dropped at (x, 0)."""
    model = mujoco.MjModel.from_xml_string(
        f'<mujoco><worldbody>{geom}<body pos="{x} 0 .8"><freejoint/><geom size=".1"/></body></worldbody></mujoco>'
    )
    data = mujoco.MjData(model)
    for _ in range(1500):
        mujoco.mj_step(model, data)
    return round(float(data.qpos[2]), 2)


def ray(geom, x, z=2.0, down=-1.0):
    """Distance along a vertical ray."""
    model = mujoco.MjModel.from_xml_string(f"<mujoco><worldbody>{geom}</worldbody></mujoco>")
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    return mujoco.mj_ray(model, data, np.array([x, 0.0, z]), np.array([0.0, 0.0, down]), None, True, -1, None)


print("mujoco", mujoco.__version__)
floor = '<geom type="plane" size="{0} {0} .1"/>'
box = floor.format(0) + '<geom type="box" size="1 1 .25" pos="0 0 .25" rgba="{0}" group="{1}"/>'
cases = [
    ("plane of size 1, x = 0", floor.format(1), 0.0, 0.1, 2.0),
    ("plane of size 1, x = 3", floor.format(1), 3.0, 0.1, -1.0),
    ("plane of size 0, x = 3", floor.format(0), 3.0, 0.1, 2.0),
    ("box, alpha 1, group 0", box.format("1 0 0 1", 0), 0.0, 0.6, 1.5),
    ("box, alpha 0, group 0", box.format("1 0 0 0", 0), 0.0, 0.6, 2.0),
    ("box, alpha 1, group 3", box.format("1 0 0 1", 3), 0.0, 0.6, 1.5),
]
for name, geom, x, wanted_height, wanted_ray in cases:
    height, distance = height_of_ball(geom, x), ray(geom, x)
    print(f"{name}: a ball rests at z = {height}, a ray from z = 2 downwards returns {distance}")
    assert (height, distance) == (wanted_height, wanted_ray), name
below = ray(floor.format(0), 0.0, -1.0, 1.0)
print(f"plane, ray from z = -1 upwards returns {below}")
assert below == -1.0
PY
"$work/venv/bin/python" "$work/rays.py"
