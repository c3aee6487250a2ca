"""Mass properties follow UsdPhysics' precedence; usd-core's own ComputeMassProperties is the oracle."""

from __future__ import annotations

import itertools
import math

import mujoco
import numpy as np
import pytest
from pxr import Gf, UsdGeom, UsdPhysics
from scipy.spatial.transform import Rotation

from lift_lab.usd import UsdImportError


def _tensor(model, name):
    """Inertia tensor of a body about its centre of mass, in the body frame."""
    body = model.body(name)
    axes = Rotation.from_quat(np.roll(body.iquat, -1)).as_matrix()
    return axes @ np.diag(body.inertia) @ axes.T


def _two_boxes(author, metres=1.0, kilograms=None):
    """A body with a unit box beside a box of side 2 (stage units)."""
    a = author("Z", metres, kilograms)
    a.body("/Robot/b", mass=None)
    a.gprim("/Robot/b/small", "Cube", pos=(1.5, 0.25, 0), size=1.0)
    a.gprim("/Robot/b/large", "Cube", size=2.0)
    return a


def _oracle(a, path="/Robot/b"):
    """Mass, centre and tensor by usd-core, its callback fed with closed forms for boxes; stage units."""

    def box(prim):
        info = UsdPhysics.RigidBodyAPI.MassInformation()
        side = UsdGeom.Cube(prim).GetSizeAttr().Get()
        info.volume = side**3
        info.inertia = Gf.Matrix3f(*(np.eye(3) * side**5 / 6).ravel().tolist())
        info.centerOfMass = Gf.Vec3f(0)
        info.localPos = Gf.Vec3f(UsdGeom.Xformable(prim).GetLocalTransformation().ExtractTranslation())
        info.localRot = Gf.Quatf(1)
        return info

    api = UsdPhysics.RigidBodyAPI(a.stage.GetPrimAtPath(path))
    mass, diagonal, com, axes = api.ComputeMassProperties(box)
    rot = Rotation.from_quat([*axes.GetImaginary(), axes.GetReal()]).as_matrix()
    return mass, np.array(com), rot @ np.diag(np.array(diagonal)) @ rot.T


BODY = {
    "nothing": {},
    "mass": {"mass": 3.0},
    "density": {"density": 10.0},
    "mass and centre": {"mass": 3.0, "centerOfMass": Gf.Vec3f(0.1, 0.2, 0.3)},
    "density and centre": {"density": 7.0, "centerOfMass": Gf.Vec3f(0.1, 0.2, 0.3)},
    "inertia": {"diagonalInertia": Gf.Vec3f(2, 3, 4)},
    "mass and inertia": {"mass": 3.0, "diagonalInertia": Gf.Vec3f(2, 3, 4)},
}
COLLIDER = {
    "nothing": {},
    "mass": {"mass": 2.0},
    "density": {"density": 5.0},
    "mass and centre": {"mass": 2.0, "centerOfMass": Gf.Vec3f(0, 0.1, 0)},
    "mass and inertia": {"mass": 2.0, "diagonalInertia": Gf.Vec3f(0.5, 0.6, 0.7)},
    "mass 0, which is unset": {"mass": 0.0, "diagonalInertia": Gf.Vec3f(0, 0, 0)},
}


@pytest.mark.parametrize(("body", "collider"), list(itertools.product(BODY, COLLIDER)))
def test_every_combination_of_levels_agrees_with_usd_core(author, body, collider):
    a = _two_boxes(author)
    if BODY[body]:
        a.mass("/Robot/b", **BODY[body])
    if COLLIDER[collider]:
        a.mass("/Robot/b/small", **COLLIDER[collider])
    mass, com, tensor = _oracle(a)
    model, _ = a.load()
    assert model.body("b").mass[0] == pytest.approx(mass, rel=1e-5)
    np.testing.assert_allclose(model.body("b").ipos, com, atol=1e-5)
    if "inertia" in body:
        tensor = np.diag([2, 3, 4])  # about the body's own axes; usd-core would take the colliders' axes
    np.testing.assert_allclose(_tensor(model, "b"), tensor, rtol=1e-4, atol=1e-4 * np.abs(tensor).max())


@pytest.mark.parametrize(("body_density", "collider_density", "expected"), [(0, 0, 7), (10, 0, 10), (10, 5, 5)])
def test_density_of_the_collider_beats_the_bodys_beats_the_materials(author, body_density, collider_density, expected):
    a = author()
    a.body("/Robot/b", mass=None)
    box = a.gprim("/Robot/b/c", "Cube", size=1.0)
    a.bind(box, a.material("/Robot/m", density=7.0))
    if body_density:
        a.mass("/Robot/b", density=float(body_density))
    if collider_density:
        a.mass(box, density=float(collider_density))
    assert a.load()[0].body("b").mass[0] == pytest.approx(expected)


def test_density_units_follow_the_stages_metre_and_kilogram(author):
    """A 10 cm cube of 2 g/cm^3, authored in centimetres and grams, weighs 2 kg."""
    a = author("Z", 0.01, 0.001)
    a.body("/Robot/b", mass=None)
    a.gprim("/Robot/b/c", "Cube", size=10.0)
    a.mass("/Robot/b", density=2.0)
    model, _ = a.load()
    assert model.body("b").mass[0] == pytest.approx(2.0)
    np.testing.assert_allclose(model.body("b").inertia, 2.0 * 0.1**2 / 6, rtol=1e-6)


def test_without_any_density_a_collider_is_water(author):
    a = author("Z", 0.01)
    a.body("/Robot/b", mass=None)
    a.gprim("/Robot/b/c", "Sphere", radius=10.0)
    assert a.load()[0].body("b").mass[0] == pytest.approx(1000 * 4 / 3 * math.pi * 0.1**3, rel=1e-6)


@pytest.mark.parametrize(
    ("kind", "attrs", "volume"),
    [
        ("Capsule", {"radius": 0.1, "height": 0.5}, math.pi * 0.01 * 0.5 + 4 / 3 * math.pi * 0.001),
        ("Cylinder", {"radius": 0.1, "height": 0.5}, math.pi * 0.01 * 0.5),
        ("Sphere", {"radius": 0.2}, 4 / 3 * math.pi * 0.008),
    ],
)
def test_shapes_have_their_closed_form_volume(author, kind, attrs, volume):
    a = author()
    a.body("/Robot/b", mass=None)
    a.gprim("/Robot/b/c", kind, **attrs)
    assert a.load()[0].body("b").mass[0] == pytest.approx(1000 * volume, rel=1e-6)


def test_a_mesh_weighs_as_its_hull(author):
    """A tetrahedron of legs 0.6: volume 0.6^3 / 6, centre at a quarter."""
    a = author()
    a.body("/Robot/b", mass=None)
    points = [(0, 0, 0), (0.6, 0, 0), (0, 0.6, 0), (0, 0, 0.6)]
    a.mesh("/Robot/b/c", points, [(0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2)], approximation="convexHull")
    model, _ = a.load()
    assert model.body("b").mass[0] == pytest.approx(1000 * 0.6**3 / 6, rel=1e-6)
    np.testing.assert_allclose(model.body("b").ipos, (0.15, 0.15, 0.15), atol=1e-7)


def test_principal_axes_turn_the_inertia(author):
    a = author()
    a.body("/Robot/b", inertia=(1, 2, 3))
    rot = Rotation.from_euler("xyz", (30, 40, 50), degrees=True)
    a.mass("/Robot/b", principalAxes=Gf.Quatf(*map(float, np.roll(rot.as_quat(), 1))))
    model, _ = a.load()
    expected = rot.as_matrix() @ np.diag([1, 2, 3]) @ rot.as_matrix().T
    np.testing.assert_allclose(_tensor(model, "b"), expected, atol=1e-5)


def test_zero_principal_axes_are_unset(author):
    a = author()
    a.body("/Robot/b", inertia=(1, 2, 3))
    a.mass("/Robot/b", principalAxes=Gf.Quatf(0, 0, 0, 0))
    np.testing.assert_allclose(_tensor(a.load()[0], "b"), np.diag([1, 2, 3]), atol=1e-9)


def test_centre_of_mass_is_scaled_with_the_prim_and_inertia_is_not(author):
    a = author()
    a.body("/Robot/b", scale=(2, 3, 4), com=(0.1, 0.1, 0.1), inertia=(1, 2, 3))
    model, _ = a.load()
    np.testing.assert_allclose(model.body("b").ipos, (0.2, 0.3, 0.4), atol=1e-7)
    np.testing.assert_allclose(_tensor(model, "b"), np.diag([1, 2, 3]), atol=1e-9)


def test_the_full_tensor_of_newton_overrides_the_diagonal(author):
    a = author()
    a.body("/Robot/b", inertia=(9, 9, 9))
    a.attrs("/Robot/b", {"newton:inertia": [0.3, 0.4, 0.5, 0.01, -0.02, 0.03]}, "NewtonMassAPI")
    expected = np.array([[0.3, 0.01, -0.02], [0.01, 0.4, 0.03], [-0.02, 0.03, 0.5]])
    np.testing.assert_allclose(_tensor(a.load()[0], "b"), expected, atol=1e-9)


def test_disabled_colliders_have_no_mass_and_do_not_collide(author):
    a = author()
    a.body("/Robot/b", mass=None)
    a.gprim("/Robot/b/on", "Cube", size=1.0)
    off = a.gprim("/Robot/b/off", "Cube", pos=(0, 0, 5), size=1.0)
    a.attrs(off, {"physics:collisionEnabled": False})
    model, _ = a.load()
    assert model.body("b").mass[0] == pytest.approx(1000)
    geom = model.geom("off")
    assert (geom.contype[0], geom.conaffinity[0], geom.group[0]) == (0, 0, 2)


def test_a_mass_without_inertia_or_collider_gets_a_small_ball(author, notes):
    a = author()
    a.body("/Robot/b", mass=None)
    a.mass("/Robot/b", mass=2.0)
    model, report = a.load()
    np.testing.assert_allclose(model.body("b").inertia, 0.4 * 2.0 * 0.01, rtol=1e-6)
    assert "ball of 0.1 m" in notes(report, "/Robot/b")[1][0]


def test_a_moving_body_without_anything_gets_physxs_default(author, notes):
    a = author()
    a.body("/Robot/b", mass=None)
    model, report = a.load()
    assert model.body("b").mass[0] == pytest.approx(1.0)
    assert "PhysX" in notes(report, "/Robot/b")[1][0]


def test_a_massless_frame_welded_to_a_link_stays_massless(author):
    a = author()
    a.body("/Robot/link")
    a.body("/Robot/tool", mass=None)
    a.joint("/Robot/w", "FixedJoint", "/Robot/link", "/Robot/tool", pos0=(0, 0, 0.1))
    model, _ = a.load()
    assert model.body("tool").mass[0] == 0
    assert model.body_parentid[model.body("tool").id] == model.body("link").id


ZERO, TINY = [0.0] * 6, [1e-20, 1e-20, 1e-20, 0.0, 0.0, 0.0]


@pytest.mark.parametrize("held_by", ["/Robot/link", None])
@pytest.mark.parametrize(
    ("mass", "newton", "diagonal", "moments"),
    [
        (1e-9, ZERO, (0, 0, 0), (0, 0, 0)),  # as URDF converters write a frame link
        (1e-9, None, (1e-20, 1e-20, 1e-20), (1e-20, 1e-20, 1e-20)),
        (1e-20, TINY, None, (1e-20, 1e-20, 1e-20)),
        (1.0, ZERO, None, (0, 0, 0)),
        (1.0, None, (0, 2e-5, 2e-5), (0, 2e-5, 2e-5)),
        (1.0, None, (2e-5, 0, 5), (2e-5, 0, 2e-5)),  # which no body has: lowered
    ],
)
def test_a_welded_link_may_have_no_mass_or_inertia_as_in_mujoco(author, held_by, mass, newton, diagonal, moments):
    a = author()
    a.body("/Robot/link")
    a.body("/Robot/frame", mass=None)
    a.mass("/Robot/frame", mass=mass)
    if diagonal:
        a.mass("/Robot/frame", diagonalInertia=Gf.Vec3f(*diagonal))
    if newton:
        a.attrs("/Robot/frame", {"newton:inertia": newton}, "NewtonMassAPI")
    a.joint("/Robot/weld", "FixedJoint", held_by, "/Robot/frame")
    inner = (
        f'<body name="frame"><inertial pos="0 0 0" mass="{mass}" diaginertia="{" ".join(map(str, moments))}"/></body>'
    )
    link = '<body name="link"><freejoint/><inertial pos="0 0 0" mass="1" diaginertia=".01 .01 .01"/>'
    tree = f"{link}{inner}</body>" if held_by else f"{link}</body>{inner}"
    expected = mujoco.MjModel.from_xml_string(f"<mujoco><worldbody>{tree}</worldbody></mujoco>")
    model, report = a.load()
    for name in ("link", "frame"):
        assert model.body(name).mass[0] == pytest.approx(expected.body(name).mass[0], rel=1e-6)
        np.testing.assert_allclose(sorted(model.body(name).inertia), sorted(expected.body(name).inertia), rtol=1e-6)
    assert len(report.approximated) == (diagonal == (2e-5, 0, 5))


def test_a_moving_link_without_mass_may_be_carried_by_one_welded_to_it(author):
    """MuJoCo asks for mass and inertia of a moving body or of one welded to it."""
    a = author()
    a.body("/Robot/base", mass=None)
    a.mass("/Robot/base", mass=1e-20)
    a.body("/Robot/plate", mass=None)
    a.mass("/Robot/plate", mass=1e-20)
    a.body("/Robot/trunk", mass=2.0)
    a.joint("/Robot/w", "FixedJoint", "/Robot/base", "/Robot/plate")
    a.joint("/Robot/v", "FixedJoint", "/Robot/plate", "/Robot/trunk")
    model, _ = a.load()
    assert model.nv == 6
    assert model.body_mass.tolist() == pytest.approx([0, 1e-20, 1e-20, 2.0], rel=1e-6)


@pytest.mark.parametrize(
    ("values", "newton", "attribute"),
    [
        ({"mass": 1.0}, ZERO, "newton:inertia"),
        ({"mass": 1.0}, TINY, "newton:inertia"),
        ({"mass": 1.0, "diagonalInertia": Gf.Vec3f(1, 1, 1)}, ZERO, "newton:inertia"),
        ({"mass": 1.0}, [1.0, 1.0, -1.0, 0.0, 0.0, 0.0], "newton:inertia"),
        ({"mass": 1.0, "diagonalInertia": Gf.Vec3f(1e-20, 1e-20, 1e-20)}, None, "physics:diagonalInertia"),
        ({"mass": 1e-20, "diagonalInertia": Gf.Vec3f(1, 1, 1)}, None, "physics:mass"),
        ({"mass": 1e-14}, None, "physics:mass"),  # the inertia follows from the mass
        ({"diagonalInertia": Gf.Vec3f(1, 1, 1)}, None, "physics:mass"),
        ({"density": 1e-20}, None, "physics:mass"),
    ],
)
def test_a_moving_link_that_is_too_light_names_what_is_too_small(author, values, newton, attribute):
    a = author()
    a.body("/Robot/link", mass=None)
    a.mass("/Robot/link", **values)
    if "density" in values:
        a.gprim("/Robot/link/box", "Cube", size=0.1)
    if newton:
        a.attrs("/Robot/link", {"newton:inertia": newton}, "NewtonMassAPI")
    with pytest.raises(UsdImportError, match=rf"</Robot/link>\.{attribute}: "):
        a.load()


def test_a_negative_moment_is_refused_of_a_welded_link_too(author):
    a = author()
    a.body("/Robot/link")
    a.body("/Robot/frame")
    a.attrs("/Robot/frame", {"newton:inertia": [1.0, 1.0, -1.0, 0.0, 0.0, 0.0]}, "NewtonMassAPI")
    a.joint("/Robot/weld", "FixedJoint", "/Robot/link", "/Robot/frame")
    with pytest.raises(UsdImportError, match=r"</Robot/frame>\.newton:inertia: .*negative"):
        a.load()


def test_inertia_that_violates_the_triangle_inequality_by_rounding_is_repaired(author, notes):
    a = author()
    a.body("/Robot/b", inertia=(1, 1, 2.00001))
    model, report = a.load()
    np.testing.assert_allclose(model.body("b").inertia, (1, 1, 2), atol=1e-5)
    assert "float32 rounding" in notes(report, "/Robot/b")[1][0]


def test_inertia_that_no_body_has_is_repaired_and_says_by_how_much(author, notes):
    a = author()
    a.body("/Robot/b", inertia=(1, 1, 2.5))
    model, report = a.load()
    np.testing.assert_allclose(model.body("b").inertia, (1, 1, 2), atol=1e-5)
    assert "25 %" in notes(report, "/Robot/b")[1][0]


@pytest.mark.parametrize(
    ("values", "attribute"),
    [
        ({"mass": -1.0}, "physics:mass"),
        ({"mass": math.inf}, "physics:mass"),
        ({"mass": math.nan}, "physics:mass"),
        ({"density": -5.0}, "physics:density"),
        ({"diagonalInertia": Gf.Vec3f(1, -1, 1)}, "physics:diagonalInertia"),
        ({"diagonalInertia": Gf.Vec3f(1, 0, 1)}, "physics:diagonalInertia"),
        ({"centerOfMass": Gf.Vec3f(0, math.nan, 0)}, "physics:centerOfMass"),
        ({"principalAxes": Gf.Quatf(math.nan, 0, 0, 0)}, "physics:principalAxes"),
    ],
)
def test_impossible_mass_properties_are_errors_that_name_prim_and_attribute(author, values, attribute):
    a = author()
    a.body("/Robot/b")
    a.mass("/Robot/b", **values)
    with pytest.raises(UsdImportError, match=rf"</Robot/b>\.{attribute}"):
        a.load()


def test_shell_inertia_puts_the_mass_on_the_surface(author):
    """A thin sphere of 1 kg: 2/3 m r^2."""
    a = author()
    a.body("/Robot/b", mass=None)
    a.mass("/Robot/b", mass=1.0)
    ball = a.gprim("/Robot/b/c", "Sphere", radius=0.5)
    a.attrs(ball, {"mjc:shellinertia": True}, "MjcCollisionAPI")
    np.testing.assert_allclose(a.load()[0].body("b").inertia, 2 / 3 * 0.25, rtol=1e-6)


def test_gravity_can_be_switched_off_for_a_body(author):
    a = author()
    a.attrs(a.body("/Robot/b"), {"physxRigidBody:disableGravity": True}, "PhysxRigidBodyAPI")
    assert a.load()[0].body_gravcomp.tolist() == [0.0, 1.0]
