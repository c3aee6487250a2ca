#!/usr/bin/env bash
# MuJoCo 4.0.0: what the cutoff of mj_multiRay bounds.
#
# Guess before the run: a hit that is farther than the cutoff is returned as -1, so that no returned distance is
# greater than the cutoff. What is hit does not depend on how a wall is divided into geoms.
# Seen: the cutoff leaves out geoms whose bounding sphere is out of reach, and no plane. A long wall or a height field
# whose sphere is within reach, and every plane, return hits at any distance: 8 with a cutoff of 3. The same wall made
# of short boxes returns -1.
# Why it matters: a ray sensor that gives its maximum distance as the cutoff returns readings beyond it, and they
# depend on how the scene was modelled. Distances must be compared with the maximum once more.
#
# Prints what is seen and fails if it changes.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/venv"
"$work/venv/bin/python" -m pip install --quiet mujoco==4.0.0
cat > "$work/cutoff.py" <<'PY'
import mujoco
import numpy as np

CUTOFF = 3.0
WALLS = {
    "one box of 20 m": '<geom type="box" pos="0 2 0" size="10 .1 1"/>',
    "100 boxes of 0.2 m": "".join(
        f'<geom type="box" pos="{-9.9 + 0.2 * i:.1f} 2 0" size=".1 .1 1"/>' for i in range(100)
    ),
    "plane": '<geom type="plane" pos="0 1.9 0" size="0 0 .1" zaxis="0 -1 0"/>',
    "height field": '<geom type="hfield" hfield="wall" pos="0 1.95 0" zaxis="0 -1 0"/>',
}
ASSET = '<asset><hfield name="wall" nrow="2" ncol="2" size="10 10 .1 .1" elevation="1 0 0 1"/></asset>'


def scan(wall, directions):
    """Distances of the rays from the origin."""
    model = mujoco.MjModel.from_xml_string(f"<mujoco>{ASSET}<worldbody>{wall}</worldbody></mujoco>")
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    n = len(directions)
    geoms, distances = np.zeros(n, np.int32), np.zeros(n)
    mujoco.mj_multiRay(
        model, data, np.zeros(3), directions.ravel(), None, True, -1, geoms, distances, None, n, CUTOFF
    )
    return distances


print("mujoco", mujoco.__version__, "- cutoff", CUTOFF)
across = np.array([1.95, 2.5, 4.0, 8.0])  # how far each ray runs until y = 1.9
directions = np.stack([np.sqrt(1 - (1.9 / across) ** 2), 1.9 / across, np.zeros(4)], axis=1)
for name, wall in WALLS.items():
    seen = scan(wall, directions)
    print(f"{name:19s} distances {np.round(seen, 2)}")
    if name == "100 boxes of 0.2 m":
        assert (seen[:2] > 0).all() and seen[3] == -1, seen
    else:
        assert (np.abs(seen - across) < 0.5).all() and seen.max() > CUTOFF + 4, seen
PY
"$work/venv/bin/python" "$work/cutoff.py"
