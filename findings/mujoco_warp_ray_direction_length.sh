#!/usr/bin/env bash
# mujoco_warp 4.0.0 and MuJoCo 4.0.0: rays whose direction is not a unit vector.
#
# Guess before the run: mujoco_warp.rays takes directions of any length, as mj_ray does, and returns x with hit =
# point + x * direction; both agree for every kind of geom.
# Seen: they agree for primitives at any length, and for meshes and height fields at length 1. At other lengths some
# rays of mujoco_warp miss a mesh or hit one beside them, and those against a height field return a wrong distance.
# Nothing is raised.
# Why it matters: sensors that pass "end - start" or pinhole directions (x, y, 1) work on boxes and planes and are
# wrong on terrain and robots. Directions have to be normalised first, also where code was written for mj_ray.
#
# Prints what is seen and fails if it changes.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/venv"
"$work/venv/bin/python" -m pip install --quiet mujoco==4.0.0 mujoco-warp==4.0.0 warp-lang==1.19.0
cat > "$work/rays.py" <<'PY'
from importlib.metadata import version

import mujoco
import numpy as np
import warp as wp

wp.config.log_level = wp.LOG_ERROR
import mujoco_warp as mjw  # noqa: E402
from mujoco_warp._src.types import vec6f  # noqa: E402

COUNT = 300
ELEVATION = " ".join(str((i % 4) / 3) for i in range(45))
GEOMS = {
    "box": '<geom type="box" size=".5 .4 .3"/>',
    "capsule": '<geom type="capsule" size=".3 .3"/>',
    "mesh": '<geom type="mesh" mesh="tetrahedron"/>',
    "height field": '<geom type="hfield" hfield="ground"/>',
}
ASSET = f"""<asset>
<mesh name="tetrahedron" vertex="0 0 0 1 0 0 0 1 0 0 0 1"/>
<hfield name="ground" nrow="5" ncol="9" size="2 1 1 .5" elevation="{ELEVATION}"/>
</asset>"""


def by_mujoco(model, data, points, directions):
    """Distances of mj_ray."""
    return np.array(
        [mujoco.mj_ray(model, data, p, v, None, True, -1, None) for p, v in zip(points, directions, strict=True)]
    )


def by_warp(model, data, points, directions):
    """Distances of mujoco_warp.rays."""
    n = len(points)
    distances = wp.zeros((1, n), dtype=float)
    mjw.rays(
        mjw.put_model(model),
        mjw.put_data(model, data),
        wp.array(points[None].astype(np.float32), dtype=wp.vec3),
        wp.array(directions[None].astype(np.float32), dtype=wp.vec3),
        vec6f(*[-1.0] * 6),
        True,
        wp.array(np.full(n, -1), dtype=int),
        distances,
        wp.zeros((1, n), dtype=int),
        wp.zeros((1, n), dtype=wp.vec3),
    )
    return distances.numpy()[0]


print("mujoco", mujoco.__version__, "mujoco_warp", version("mujoco-warp"), "warp", version("warp-lang"))
rng = np.random.default_rng(0)
targets = rng.uniform(-0.5, 0.5, (COUNT, 3))
points = targets + 3 * rng.normal(size=(COUNT, 3))
unit = (targets - points) / np.linalg.norm(targets - points, axis=1, keepdims=True)
for name, geom in GEOMS.items():
    model = mujoco.MjModel.from_xml_string(f"<mujoco>{ASSET}<worldbody>{geom}</worldbody></mujoco>")
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    reference = by_mujoco(model, data, points, unit)
    for length in (1.0, 0.5, 3.0):
        # in metres, so that all lengths ought to give the same numbers
        mine = by_mujoco(model, data, points, length * unit)
        theirs = by_warp(model, data, points, length * unit)
        mine, theirs = (np.where(x < 0, x, x * length) for x in (mine, theirs))
        wrong = int((np.abs(theirs - reference) > 1e-3).sum())
        print(f"{name:12s} length {length}: of {COUNT} rays wrong by mujoco_warp {wrong}, by MuJoCo", end=" ")
        print(int((np.abs(mine - reference) > 1e-3).sum()))
        assert np.allclose(mine, reference, atol=1e-9), name
        if length == 1.0 or name in ("box", "capsule"):
            assert wrong == 0, (name, length, wrong)
        else:
            assert wrong > 5, (name, length, wrong)
PY
WARP_CACHE_PATH="$work/cache" "$work/venv/bin/python" "$work/rays.py" 2>/dev/null
