"""What a film shows is in its video, at the right place, size and colour."""

import subprocess
import sys

import mujoco
import numpy as np
import pytest

import lift_lab.sim as sim_utils
from lift_lab.drawing import film, shapes
from lift_lab.drawing.film import Film
from lift_lab.drawing.scene import Picture, View
from lift_lab.drawing.shapes import Placed
from lift_lab.markers import config
from lift_lab.markers.drawn import primitives

av = pytest.importorskip("av")

SIZE = 160
MODEL = """
<mujoco>
  <visual><map znear="0.01"/><headlight ambient="1 1 1" diffuse="0 0 0" specular="0 0 0"/></visual>
  <worldbody>
    <camera name="arm/above" pos="0 0 3" fovy="45"/>
    <body name="slider"><joint type="slide" axis="1 0 0"/><geom type="box" size=".1 .1 .1" rgba="1 0 1 1"/></body>
  </worldbody>
</mujoco>
"""
DISTANCE = 1.0 / np.tan(np.radians(22.5))
"""Of the camera in m: at the origin, a frame is 2 m high."""
AWAY = 50.0
"""Where the model's own body is not seen."""


def material(red, green, blue):
    return sim_utils.PreviewSurfaceCfg(diffuse_color=(red, green, blue))


RED = material(1.0, 0.0, 0.0)
SHAPES = {
    "sphere": sim_utils.SphereCfg(radius=0.2, visual_material=RED),
    "cuboid": sim_utils.CuboidCfg(size=(0.8, 0.2, 0.4), visual_material=RED),
    "cylinder": sim_utils.CylinderCfg(radius=0.1, height=0.8, axis="X", visual_material=RED),
    "capsule": sim_utils.CapsuleCfg(radius=0.1, height=0.6, visual_material=RED),
    "cone": sim_utils.ConeCfg(radius=0.3, height=0.8, visual_material=RED),
    "frame": config.FRAME_MARKER_CFG.markers["frame"],
    "arrow": config.RED_ARROW_X_MARKER_CFG.markers["arrow"],
    "hidden": sim_utils.SphereCfg(radius=0.2, visual_material=RED, visible=False),
}
TWICE = np.full((1, 3), 2.0)
ONCE = np.ones((1, 3))
TURNED = np.array([[np.sqrt(0.5), 0.0, -np.sqrt(0.5), 0.0]])
"""Brings x up."""


def picture(placed=(), slide=AWAY, n=1, lines=()):
    # looks along y, x to the right and z up
    view = View(lookat=(0.0, 0.0, 0.0), distance=DISTANCE, azimuth_deg=90.0, elevation_deg=0.0)
    empty = np.zeros((n, 0, 3)), np.zeros((n, 0, 4))
    return Picture(np.full((n, 1), slide), *empty, view, list(placed), list(lines))


def place(shape, scales=ONCE, quats=None, positions=None):
    quats = np.array([[1.0, 0.0, 0.0, 0.0]]) if quats is None else quats
    return [Placed(shape, np.zeros((1, 3)) if positions is None else positions, quats, scales)]


def draw(folder, pictures, origins=((0.0, 0.0, 0.0),), camera=None):
    model = mujoco.MjModel.from_xml_string(MODEL)
    source, video = folder / "a.film", folder / "a.mp4"
    data = film.model_bytes(model)
    Film(data, SIZE, SIZE, 25.0, np.array(origins), camera, False, pictures).save(source)
    process = film.start(source, video, background=False)
    _, errors = process.communicate(timeout=300)
    if (process.returncode == 3 and b"OpenGL" in errors) or b"cannot draw" in errors:
        pytest.skip(errors.decode())
    assert process.returncode == 0, errors.decode()
    assert not source.exists()
    with av.open(str(video)) as container:
        return [frame.to_ndarray(format="rgb24").astype(int) for frame in container.decode(video=0)]


@pytest.fixture(scope="module")
def seen(tmp_path_factory):
    """Frames by name: each shape once, some twice as large or turned."""
    kinds = {name: primitives(cfg) for name, cfg in SHAPES.items()}
    pictures = {name: picture(place(shape)) for name, shape in kinds.items()}
    pictures["frame"] = picture(place(kinds["frame"], TWICE))
    pictures["large sphere"] = picture(place(kinds["sphere"], TWICE))
    pictures["wide cone"] = picture(place(kinds["cone"], np.array([[2.0, 2.0, 1.0]])))
    pictures["upright arrow"] = picture(place(kinds["arrow"], quats=TURNED))
    pictures["moved sphere"] = picture(place(kinds["sphere"], positions=np.array([[0.5, 0.0, 0.25]])))
    pictures["text"] = picture(lines=[("reward", "1.50")])
    pictures["body"] = picture(slide=0.5)
    frames = draw(tmp_path_factory.mktemp("film"), list(pictures.values()))
    return dict(zip(pictures, frames, strict=True))


def extent(frame, channel=0):
    """(left, right, bottom, top) of what is drawn in a colour, in m."""
    others = [c for c in range(3) if c != channel]
    drawn = (frame[..., channel] > 110) & (frame[..., others].max(axis=2) < 90)
    if not drawn.any():
        return None
    rows, columns = np.nonzero(drawn)
    half = SIZE / 2
    left, right = columns.min() - half, columns.max() + 1 - half
    return left / half, right / half, (half - rows.max() - 1) / half, (half - rows.min()) / half


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("sphere", (-0.2, 0.2, -0.2, 0.2)),
        ("large sphere", (-0.4, 0.4, -0.4, 0.4)),
        ("moved sphere", (0.3, 0.7, 0.05, 0.45)),
        ("cuboid", (-0.4, 0.4, -0.2, 0.2)),
        ("cylinder", (-0.4, 0.4, -0.1, 0.1)),
        ("capsule", (-0.1, 0.1, -0.4, 0.4)),
        # what is nearer looks larger: here the edge of the foot
        ("cone", (-0.3, 0.3, -0.4 * DISTANCE / (DISTANCE - 0.3), 0.4)),
        ("wide cone", (-0.6, 0.6, -0.4 * DISTANCE / (DISTANCE - 0.6), 0.4)),
        ("arrow", (0.0, 1.0, -0.05, 0.05)),
        ("upright arrow", (-0.05, 0.05, 0.0, 1.0)),
    ],
)
def test_a_shape_is_drawn_at_its_place_and_size(seen, name, expected):
    assert extent(seen[name]) == pytest.approx(expected, abs=0.06)


def test_a_cone_has_its_tip_up(seen):
    red = (seen["cone"][..., 0] > 110) & (seen["cone"][..., 1] < 90)
    assert red[int(0.35 * SIZE)].sum() < red[int(0.65 * SIZE)].sum()


def test_a_frame_has_x_in_red_to_the_right_and_z_in_blue_up(seen):
    left, right, _, _ = extent(seen["frame"], channel=0)
    assert (left, right) == pytest.approx((0.0, 1.0), abs=0.1)
    _, _, bottom, top = extent(seen["frame"], channel=2)
    assert (bottom, top) == pytest.approx((0.0, 1.0), abs=0.1)


def test_a_shape_that_is_not_visible_has_nothing_to_draw(seen):
    assert primitives(SHAPES["hidden"]) == []
    assert extent(seen["hidden"]) is None


def test_the_bodies_stand_where_the_state_says(seen):
    body = (seen["body"][..., 0] > 150) & (seen["body"][..., 2] > 150) & (seen["body"][..., 1] < 90)
    rows, columns = np.nonzero(body)
    assert (columns.mean() + 0.5) / (SIZE / 2) - 1 == pytest.approx(0.5, abs=0.06)
    assert 1 - (rows.mean() + 0.5) / (SIZE / 2) == pytest.approx(0.0, abs=0.06)


def test_text_is_written_in_the_upper_left_corner(seen):
    change = (seen["text"] - seen["hidden"]).sum(axis=2)
    rows, columns = np.nonzero(change < -150)  # its dark ground
    assert len(rows) > 500
    assert rows.max() < SIZE / 2
    assert columns.min() < 10
    written = seen["text"][: SIZE // 4, : SIZE // 2]
    assert (written.min(axis=2) > 150).any()


def test_many_environments_stand_side_by_side_and_a_camera_of_the_model_can_see_them(tmp_path):
    origins = ((0.0, 0.0, 0.0), (0.8, 0.0, 0.0), (0.0, 0.8, 0.0))
    (frame,) = draw(tmp_path, [picture(slide=-0.2, n=3)], origins, camera="above")
    body = (frame[..., 0] > 150) & (frame[..., 2] > 150) & (frame[..., 1] < 90)
    # seen from 3 m above the first: 2.9 m from the tops
    scale = SIZE / 2 / (2.9 * np.tan(np.radians(22.5)))
    for x, y, _ in origins:
        column, row = SIZE / 2 + scale * (x - 0.2), SIZE / 2 - scale * y
        assert body[int(row), int(column)], (x, y)
    assert not body[int(SIZE / 2 - scale * 0.4), int(SIZE / 2 + scale * 0.4)]


def test_a_camera_that_does_not_exist_is_said_in_one_line(tmp_path):
    model = mujoco.MjModel.from_xml_string(MODEL)
    source = tmp_path / "a.film"
    Film(film.model_bytes(model), 32, 32, 25.0, np.zeros((1, 3)), "below", False, [picture()]).save(source)
    process = film.start(source, tmp_path / "a.mp4", background=False)
    _, errors = process.communicate(timeout=300)
    assert process.returncode == 3
    assert errors.decode().strip().splitlines()[-1] == "the scene has no camera 'below'; its cameras: arm/above"
    assert list(tmp_path.iterdir()) == []


def test_without_an_opengl_library_one_line_says_what_to_install(tmp_path, monkeypatch):
    libraries = tmp_path / "libraries"
    libraries.mkdir()
    for name in ("libEGL.so", "libEGL.so.1"):  # found first, and no libraries
        (libraries / name).write_bytes(b"")
    monkeypatch.setenv("LD_LIBRARY_PATH", str(libraries))
    for name in ("MUJOCO_GL", "DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    model = mujoco.MjModel.from_xml_string(MODEL)
    source = tmp_path / "a.film"
    Film(film.model_bytes(model), 32, 32, 25.0, np.zeros((1, 3)), None, False, [picture()]).save(source)
    process = film.start(source, tmp_path / "a.mp4", background=False)
    _, errors = process.communicate(timeout=300)
    assert process.returncode == 3
    assert "libegl1 libgl1-mesa-dri libopengl0" in errors.decode().strip().splitlines()[-1]


def test_the_process_that_draws_loads_neither_torch_nor_gymnasium():
    code = (
        "import sys, lift_lab.drawing.film, lift_lab.drawing.scene, lift_lab.drawing.mp4;"
        "print([m for m in ('torch', 'gymnasium', 'pxr') if m in sys.modules])"
    )
    out = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert out.stdout.strip() == "[]"


def test_a_mesh_of_few_triangles_is_drawn_as_it_is_and_a_body_of_a_file_as_its_geoms():
    spec = mujoco.MjSpec()
    spec.add_mesh(name="wedge", uservert=[0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1])
    spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_MESH, meshname="wedge")
    spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_SPHERE, size=[0.3, 0, 0], pos=[0, 0, 1])
    spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_SPHERE, size=[0.3, 0, 0], group=3)
    cfg = sim_utils.UsdFileCfg(func=lambda path, cfg: sim_utils.Spawned(spec), usd_path="wedge.usda")
    drawn = primitives(cfg)
    assert [part.kind for part in drawn] == [shapes.TRIANGLE] * 4 + [shapes.ELLIPSOID]
    assert drawn[-1].position.tolist() == [0.0, 0.0, 1.0]
    # the corners of the triangles are those of the mesh
    corners = {tuple(np.round(part.position, 6)) for part in drawn[:4]}
    assert corners <= {(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)}
