#!/usr/bin/env bash
# MuJoCo 4.0.0: what MjSpec.attach does when parent and child set an option differently.
#
# Guess before the run: compiler.conflict = mjCONFLICT_ERROR raises at attach or at compile; the policy 'warning' names
# every option of the child that is lost, disable flags included.
# Seen: 'error' raises nothing. It prints the lines of 'warning' and keeps the parent's value. 'warning' and 'error'
# drop a disable flag of the child without any line, while 'merge' adopts it and says so.
# Why it matters: a scene that is put together from files cannot rely on 'error' to find an asset that was tuned with
# another integrator, and an asset with gravity switched off falls without a word.
#
# Prints what is seen and fails if it changes.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/venv"
"$work/venv/bin/python" -m pip install --quiet mujoco==4.0.0
cat > "$work/attach.py" <<'PY'
import warnings

import mujoco


def attach(policy, option, value):
    """Option of the compiled scene, and the lines that MuJoCo wrote about it."""
    parent, child = mujoco.MjSpec(), mujoco.MjSpec()
    ball = child.worldbody.add_body(name="ball")
    ball.add_geom(type=mujoco.mjtGeom.mjGEOM_SPHERE, size=(0.1, 0, 0))
    parent.compiler.conflict = child.compiler.conflict = policy
    setattr(child.option, option, value)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        parent.attach(child, prefix="a/", frame=parent.worldbody.add_frame())
        model = parent.compile()
    return getattr(model.opt, option), sum(len(str(w.message).strip().splitlines()) - 1 for w in caught)


implicitfast = int(mujoco.mjtIntegrator.mjINT_IMPLICITFAST)
no_gravity = int(mujoco.mjtDisableBit.mjDSBL_GRAVITY)
print("mujoco", mujoco.__version__)
expected = {
    "mjCONFLICT_WARNING": [(0, 1), (0, 0)],
    "mjCONFLICT_MERGE": [(implicitfast, 1), (no_gravity, 1)],
    "mjCONFLICT_ERROR": [(0, 1), (0, 0)],
}
for name, wanted in expected.items():
    policy = getattr(mujoco.mjtConflict, name)
    seen = [attach(policy, "integrator", implicitfast), attach(policy, "disableflags", no_gravity)]
    for option, (value, lines) in zip(("integrator", "disableflags"), seen):
        print(f"{name:19s} child's {option:13s} value in the scene {value:4d}, lines about it {lines}, nothing raised")
    assert seen == wanted, (name, seen, wanted)
PY
"$work/venv/bin/python" "$work/attach.py" 2>/dev/null
