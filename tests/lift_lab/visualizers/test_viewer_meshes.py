"""What the viewer draws of a compiled model."""

import mujoco
import numpy as np
import pytest

from lift_lab.visualizers.meshes import body_meshes, collision_meshes, planes

pytest.importorskip("trimesh")

XML = """
<mujoco>
  <asset>
    <material name="red" rgba="1 0 0 1"/>
    <mesh name="tetra" vertex="0 0 0  1 0 0  0 1 0  0 0 1"/>
  </asset>
  <worldbody>
    <geom name="floor" type="plane" size="5 5 .1" pos="0 0 -0.5" rgba="0.2 0.4 0.6 1"/>
    <geom name="block" type="box" size="0.1 0.2 0.3" pos="1 2 3"/>
    <body name="post" pos="4 0 0"><geom type="sphere" size="0.5" rgba="0 1 0 1"/></body>
    <body name="arm" pos="0 0 1">
      <joint type="hinge"/>
      <geom type="capsule" size="0.1 0.4" pos="0 0 0.2" euler="0 90 0" material="red"/>
      <geom type="cylinder" size="0.05 0.3" pos="0 2 0" rgba="0 0 1 1"/>
      <geom type="box" size="9 9 9" group="3"/>
      <geom type="box" size="9 9 9" rgba="1 1 1 0"/>
      <body name="tip"><joint type="hinge"/><geom type="mesh" mesh="tetra" pos="0 0 5"/></body>
      <body name="bare"/>
    </body>
  </worldbody>
</mujoco>
"""


@pytest.fixture(scope="module")
def meshes():
    return {body.name: body for body in body_meshes(mujoco.MjModel.from_xml_string(XML))}


def extent(points):
    return np.stack((points.min(axis=0), points.max(axis=0)))


def test_bodies_without_anything_to_see_are_left_out(meshes):
    assert set(meshes) == {"world", "post", "arm", "tip"}


def test_only_bodies_without_a_joint_are_static(meshes):
    assert {name for name, body in meshes.items() if body.is_static} == {"world", "post"}


def test_a_box_has_its_size_and_place(meshes):
    np.testing.assert_allclose(extent(meshes["world"].mesh.vertices), [[0.9, 1.8, 2.7], [1.1, 2.2, 3.3]], atol=1e-6)


def test_the_geoms_of_a_body_are_one_mesh_in_its_frame(meshes):
    mesh = meshes["arm"].mesh
    red = mesh.colours[:, 0] == 1.0
    # a capsule laid along x: half length 0.4 and a radius of 0.1 at each end
    np.testing.assert_allclose(extent(mesh.vertices[red]), [[-0.5, -0.1, 0.1], [0.5, 0.1, 0.3]], atol=1e-3)
    np.testing.assert_allclose(extent(mesh.vertices[~red])[:, 2], [-0.3, 0.3], atol=1e-6)
    np.testing.assert_allclose(mesh.colours[~red], np.tile([0, 0, 1, 1], (np.sum(~red), 1)))
    assert mesh.faces.max() == len(mesh.vertices) - 1


def test_colliders_and_transparent_geoms_are_not_drawn(meshes):
    assert np.abs(meshes["arm"].mesh.vertices).max() < 3.0


def test_a_mesh_stands_where_its_file_put_it(meshes):
    # MuJoCo moves a mesh's vertices to its centre of mass and its geom the other way
    corners = {tuple(np.round(v, 4)) for v in meshes["tip"].mesh.vertices}
    assert corners == {(0.0, 0.0, 5.0), (1.0, 0.0, 5.0), (0.0, 1.0, 5.0), (0.0, 0.0, 6.0)}


def test_a_plane_of_the_world_is_found_with_its_colour():
    (plane,) = planes(mujoco.MjModel.from_xml_string(XML))
    np.testing.assert_allclose(plane.position, [0, 0, -0.5])
    np.testing.assert_allclose(plane.rgb, [0.2, 0.4, 0.6], atol=1e-6)


def test_colours_are_linear_for_the_browser(meshes):
    rgba = meshes["arm"].mesh.to_trimesh().visual.vertex_colors
    assert {tuple(row) for row in rgba} == {(255, 0, 0, 255), (0, 0, 255, 255)}
    half = meshes["world"].mesh.to_trimesh().visual.vertex_colors[0]
    assert half[0] == round(255 * ((0.5 + 0.055) / 1.055) ** 2.4)


COLLIDERS = """
<mujoco>
  <asset><mesh name="tooth" vertex="0 0 0  1 0 0  0 1 0  0 0 1  0.1 0.1 0.1"/></asset>
  <worldbody>
    <geom type="plane" size="5 5 .1"/>
    <body name="seen"><geom type="sphere" size="0.5" contype="0" conaffinity="0" group="2"/></body>
    <body name="felt" pos="0 0 1">
      <joint type="slide"/>
      <geom type="box" size="0.1 0.2 0.3" pos="0 0 1" group="3" rgba="0 0 0 0"/>
      <geom type="box" size="9 9 9" contype="0" conaffinity="0" mass="0"/>
    </body>
    <body name="tooth" pos="3 0 0"><freejoint/><geom type="mesh" mesh="tooth"/></body>
    <body name="paired" pos="5 0 0"><geom name="p" type="sphere" size="0.1" contype="0" conaffinity="0"/></body>
    <body name="partner" pos="6 0 0">
      <joint type="slide"/><geom name="q" type="sphere" size="0.2" contype="0" conaffinity="0"/>
    </body>
  </worldbody>
  <contact><pair geom1="p" geom2="q"/></contact>
</mujoco>
"""


def test_colliders_are_the_geoms_that_can_touch_and_the_hulls_of_meshes():
    model = mujoco.MjModel.from_xml_string(COLLIDERS)
    meshes = {body.name: body for body in collision_meshes(model)}
    assert set(meshes) == {"felt", "tooth", "paired", "partner"}
    np.testing.assert_allclose(extent(meshes["felt"].mesh.vertices), [[-0.1, -0.2, 0.7], [0.1, 0.2, 1.3]], atol=1e-6)
    assert not meshes["felt"].is_static
    assert meshes["paired"].is_static
    hull = meshes["tooth"].mesh
    assert (len(hull.vertices), len(hull.faces)) == (4, 4)  # the point inside is no corner of the hull
    corners = hull.vertices[hull.faces].astype(float)
    assert abs(np.einsum("fk,fk->f", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])).sum()) / 6 == (
        pytest.approx(1 / 6, rel=1e-5)
    )
