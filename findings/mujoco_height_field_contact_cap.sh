#!/usr/bin/env bash
# MuJoCo 4.0.0: a wide body on a height field of fine cells.
#
# Guess before the run: a box that lies on a flat height field stays where it is, whatever the size of the cells. If
# there are more contacts than the engine keeps, it keeps some that spread over the face, and writes a warning.
# Seen: a pair of geoms keeps 50 contacts, those of the first rows. A box of 0.8 m lies still on cells of 0.2 m. On
# cells of 5 cm all 50 lie in a strip at one edge and the box is turned over; on cells of 2.5 cm it ends below the
# ground. The warnings of MjData stay at 0. The same box made of 16 boxes lies still.
# Why it matters: terrain generators use cells of 5 to 10 cm, and crates, hulls and trunks that fell over are wide
# enough. A finer terrain makes the physics worse without a word. Split wide colliders, or compare the contacts of a
# pair with 50.
#
# Prints what is seen and fails if it changes.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/venv"
"$work/venv/bin/python" -m pip install --quiet --no-compile mujoco==4.0.0
cat > "$work/cap.py" <<'PY'
import mujoco
import numpy as np

HALF = 0.4
HEIGHT = 0.1


def boxes(parts):
    """The box as parts by parts boxes."""
    half = HALF / parts
    at = [half * (2 * i + 1) - HALF for i in range(parts)]
    return "".join(f'<geom type="box" size="{half} {half} {HEIGHT}" pos="{x} {y} 0"/>' for x in at for y in at)


def run(cell, parts=1):
    """Contacts when the box lies down, how wide they spread in x and y, and tilt and height over two seconds."""
    n = round(4 / cell) + 1
    elevation = np.zeros((n, n))
    elevation[0, 0] = 1.0  # a corner, far from the box: MuJoCo scales elevations to 0..1
    model = mujoco.MjModel.from_xml_string(f"""<mujoco><asset>
    <hfield name="ground" nrow="{n}" ncol="{n}" size="2 2 .5 .5" elevation="{" ".join(map(str, elevation.ravel()))}"/>
    </asset><worldbody><geom type="hfield" hfield="ground"/>
    <body pos=".013 .017 {HEIGHT + 0.001}"><freejoint/>{boxes(parts)}</body></worldbody></mujoco>""")
    data = mujoco.MjData(model)
    first, tilt, lowest = None, 0.0, HEIGHT
    for _ in range(1000):
        mujoco.mj_step(model, data)
        if data.ncon and first is None:
            first = np.array([contact.pos for contact in data.contact[: data.ncon]])
        tilt = max(tilt, float(np.degrees(np.arccos(min(1.0, data.xmat[1, 8])))))
        lowest = min(lowest, float(data.qpos[2]))
    spread = np.round(first.max(axis=0) - first.min(axis=0), 2)[:2]
    return len(first), spread, tilt, lowest, sum(warning.number for warning in data.warning)


print("mujoco", mujoco.__version__, f"- a box of {2 * HALF} m on a flat height field, two seconds")
for cell, parts, still in ((0.2, 1, True), (0.05, 1, False), (0.025, 1, False), (0.05, 4, True)):
    contacts, spread, tilt, lowest, warnings = run(cell, parts)
    print(
        f"cells of {cell} m, {parts * parts:2d} box(es): {contacts} contacts over {spread[0]} x {spread[1]} m, "
        f"tilt up to {tilt:.1f} degrees, lowest height {lowest:.2f} m, warnings {warnings}"
    )
    assert warnings == 0
    if still:
        assert tilt < 1 and lowest > 0.09 and min(spread) > 0.7
    else:
        assert contacts == 50 and min(spread) < 0.1 and tilt > 30
        assert cell > 0.03 or lowest < -1
PY
"$work/venv/bin/python" "$work/cap.py"
