#!/usr/bin/env bash
# mujoco 4.0.0: when the range of the fog of a rendered picture is decided.
#
# Guess before the run: MjrContext has fogStart and fogEnd, as it has shadowClip and other settings, and they can be
# assigned. So a new value holds from the next mjr_render on; or else one in model.vis.map.fogstart and fogend does, as
# one in model.vis.map.zfar and model.vis.headlight does.
# Seen: neither changes a pixel. The new values can be read back, and the picture stays. A new context, of the model with
# the new values, draws the plane without fog.
# Why it matters: fog is given as multiples of the model's extent, 10 m or 10 cm. A viewer that fits the fog to what the
# camera shows has to make a new context, which uploads every mesh and texture again.
#
# Needs EGL (Debian: libegl1 libgl1-mesa-dri libopengl0). Prints what is seen and fails if it changes.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/venv"
"$work/venv/bin/python" -m pip install --quiet --no-compile mujoco==4.0.0 numpy==2.4.6
cat > "$work/fog.py" <<'PY'
import mujoco
import numpy as np

XML = """
<mujoco>
  <visual><map fogstart="1" fogend="2"/><rgba fog="1 0 0 1"/></visual>
  <worldbody>
    <light pos="0 0 5"/>
    <geom type="plane" size="40 40 1" rgba="0 0.5 0 1"/>
  </worldbody>
</mujoco>"""

model = mujoco.MjModel.from_xml_string(XML)
data = mujoco.MjData(model)
mujoco.mj_forward(model, data)
camera = mujoco.MjvCamera()
camera.distance, camera.elevation = 5.0, -30.0
option = mujoco.MjvOption()


def picture(context, scene):
    mujoco.mjv_updateScene(model, data, option, None, camera, mujoco.mjtCatBit.mjCAT_ALL, scene)
    scene.flags[mujoco.mjtRndFlag.mjRND_FOG] = 1
    image = np.empty((120, 160, 3), np.uint8)
    view = mujoco.MjrRect(0, 0, 160, 120)
    mujoco.mjr_render(view, scene, context)
    mujoco.mjr_readPixels(image, None, view, context)
    return image.astype(int)


def new_context():
    context = mujoco.MjrContext(model, mujoco.mjtFontScale.mjFONTSCALE_100.value)
    mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN.value, context)
    return context


gl = mujoco.GLContext(160, 120)
gl.make_current()
scene = mujoco.MjvScene(model, 100)
context = new_context()
first = picture(context, scene)
extent = model.stat.extent
assert (context.fogStart, context.fogEnd) == (extent, 2 * extent)


def changed(with_context):
    return int(np.abs(picture(with_context, scene) - first).max())


context.fogStart, context.fogEnd = 100 * extent, 200 * extent
in_context, read_back = changed(context), context.fogStart / extent
model.vis.map.fogstart, model.vis.map.fogend = 100.0, 200.0
in_model = changed(context)
anew = changed(new_context())
model.vis.headlight.ambient[:] = 1.0
headlight = changed(context)
print("largest change of a pixel, of 255")
print(f"context.fogStart and fogEnd times 100 (reads back as {read_back:.0f} extents): {in_context}")
print(f"model.vis.map.fogstart and fogend times 100: {in_model}")
print(f"the same with a new context: {anew}")
print(f"for comparison, model.vis.headlight.ambient = 1 with the old context: {headlight}")
assert (in_context, in_model, read_back) == (0, 0, 100.0)
assert anew > 200
assert headlight > 0
PY
MUJOCO_GL=egl "$work/venv/bin/python" "$work/fog.py"
