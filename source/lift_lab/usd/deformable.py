"""Soft bodies: PhysX's deformable bodies as MuJoCo flexes.

A soft body is simulated as one cell of eight nodes that spans the box around its points. Positions inside are
interpolated trilinearly. Contacts are found on a grid of :data:`GRID` points along each edge.

The importer only describes soft bodies, in :attr:`ImportReport.soft_bodies`. A flex of this kind is lost when one
MjSpec is attached to another, so :func:`add_flex` makes it in the spec that is compiled.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import mujoco
import numpy as np
from pxr import Usd, UsdGeom, UsdPhysics, UsdShade

from lift_lab.usd import dialects
from lift_lab.usd.materials import Appearance
from lift_lab.usd.parse import ParsedStage, has_schema, value_of
from lift_lab.usd.units import polar

BODY_SCHEMA = "PhysxDeformableBodyAPI"
MATERIAL_SCHEMA = "PhysxDeformableBodyMaterialAPI"

GRID = 3
"""Points along each edge at which contacts are found."""

_WATER = 1000.0
"""Density in kg/m^3 of a body that has neither mass nor density, UsdPhysics's default."""

_INSET = 0.025
"""Radius of a flex's points over the body's shortest edge; the points lie that far inside the surface."""


@dataclass
class SoftBody:
    """A soft body in SI units, Z-up. Defaults are those of PhysX's schemas."""

    prim_path: str
    size: tuple[float, float, float]
    """Edges of its box in m."""
    position: np.ndarray
    """Centre of the box in the stage's world, in m."""
    quat: np.ndarray
    """Orientation of the box (w, x, y, z)."""
    mass: float
    """Mass in kg."""
    youngs_modulus: float = 5e7
    """Young's modulus in Pa."""
    poissons_ratio: float = 0.45
    elasticity_damping: float = 0.005
    """Damping over stiffness in s (Rayleigh's coefficient)."""
    friction: tuple[float, float, float] = (0.25, 0.005, 0.0001)
    """Sliding, torsional (m) and rolling (m) friction."""
    condim: int = 3
    """Dimension of its contacts' friction, MuJoCo's."""
    solref: tuple[float, ...] | None = None
    """Contact's time constant (s) and damping ratio; None for MuJoCo's default."""
    solimp: tuple[float, ...] | None = None
    """Contact's impedance; None for MuJoCo's default."""
    rgba: tuple[float, float, float, float] = (0.5, 0.5, 0.5, 1.0)


def is_soft(prim: Usd.Prim) -> bool:
    """Whether the prim is a deformable body."""
    return has_schema(prim, BODY_SCHEMA)


def read_soft_bodies(parsed: ParsedStage, appearance: Appearance) -> list[SoftBody]:
    """Describe every deformable body of a stage.

    Args:
        parsed: the stage; what is carried over inexactly goes to its report.
        appearance: where colours come from.

    Raises:
        UsdImportError: a deformable prim has no volume, or a material value is out of bounds.
    """
    return [_read(parsed, appearance, prim) for prim in parsed.prims if is_soft(prim)]


def _read(parsed: ParsedStage, appearance: Appearance, prim: Usd.Prim) -> SoftBody:
    points = _points(prim)
    linear, origin = parsed.affine(prim)
    rotation = polar(linear)[0]
    if not len(points):
        raise parsed.fail(prim, "points", f"a deformable {prim.GetTypeName() or 'prim'} has no points; give it a mesh")
    local = points @ (rotation.T @ linear).T * parsed.units.length
    low, high = local.min(axis=0), local.max(axis=0)
    size = high - low
    if not size.min() > 0:
        raise parsed.fail(prim, "points", "a deformable body has no volume")
    corners = np.array([[x, y, z] for x in (low[0], high[0]) for y in (low[1], high[1]) for z in (low[2], high[2])])
    if not (np.abs(corners[:, None] - local).max(axis=2).min(axis=1) < 1e-3 * size.min()).all():
        parsed.report.approximate(prim.GetPath(), "points", "a soft body is simulated as the box around its points")
    frame = parsed.pose(prim)
    paint = mujoco.MjSpec().worldbody.add_geom()
    appearance.apply(prim, paint)
    red, green, blue, alpha = (float(v) for v in paint.rgba)
    body = SoftBody(
        prim_path=str(prim.GetPath()),
        size=(float(size[0]), float(size[1]), float(size[2])),
        position=origin + rotation @ (0.5 * (low + high)),
        quat=np.asarray(frame.quat, dtype=float),
        mass=0.0,
        rgba=(red, green, blue, alpha),
    )
    _read_contact(parsed, prim, body)
    density = _read_material(parsed, prim, body)
    mass = value_of(prim, "physics:mass")
    body.mass = float(mass) * parsed.units.mass if mass else density * float(np.prod(size))
    if not 0 < body.mass < math.inf:
        raise parsed.fail(prim, "physics:mass", f"must be positive and finite, is {body.mass:g} kg")
    return body


def _points(prim: Usd.Prim) -> np.ndarray:
    """Points of a mesh, or the corners of a Cube, in the prim's own frame; shape (n, 3)."""
    if prim.IsA(UsdGeom.Cube):
        half = 0.5 * UsdGeom.Cube(prim).GetSizeAttr().Get()
        return half * np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=float)
    points = UsdGeom.PointBased(prim).GetPointsAttr().Get() if prim.IsA(UsdGeom.PointBased) else None
    return np.asarray(points, dtype=float).reshape(-1, 3) if points else np.empty((0, 3))


def _read_contact(parsed: ParsedStage, prim: Usd.Prim, body: SoftBody) -> None:
    condim = dialects.resolve(parsed, dialects.COLLIDER, "condim", prim)
    body.condim = body.condim if condim is None else int(condim)
    for name in ("solref", "solimp"):
        values = dialects.resolve(parsed, dialects.COLLIDER, name, prim)
        if values is not None:
            setattr(body, name, tuple(float(v) for v in np.atleast_1d(values)))


def _read_material(parsed: ParsedStage, prim: Usd.Prim, body: SoftBody) -> float:
    """Fill in what the bound material says; returns the density in kg/m^3."""
    bound, _ = UsdShade.MaterialBindingAPI(prim).ComputeBoundMaterial("physics")
    material = bound.GetPrim() if bound else None
    if material is None or not has_schema(material, MATERIAL_SCHEMA):
        return _WATER
    pressure = parsed.units.mass / parsed.units.length
    youngs = _number(parsed, material, "youngsModulus", body.youngs_modulus / pressure, 0.0, math.inf)
    body.youngs_modulus = youngs * pressure
    body.poissons_ratio = _number(parsed, material, "poissonsRatio", body.poissons_ratio, -1e-9, 0.5)
    body.elasticity_damping = _number(parsed, material, "elasticityDamping", body.elasticity_damping, -1e-9, math.inf)
    sliding = _number(parsed, material, "dynamicFriction", body.friction[0], -1e-9, math.inf)
    others = [
        dialects.resolve(parsed, dialects.MATERIAL, name, material)
        for name in ("torsional friction", "rolling friction")
    ]
    torsional, rolling = (
        default if value is None else float(value) for value, default in zip(others, body.friction[1:], strict=True)
    )
    body.friction = (sliding, torsional, rolling)
    density = _number(parsed, material, "density", 0.0, -1e-9, math.inf) * parsed.units.factor("density")
    if not density and material.HasAPI(UsdPhysics.MaterialAPI):
        density = float(value_of(material, "physics:density") or 0.0) * parsed.units.factor("density")
    return density or _WATER


def _number(parsed: ParsedStage, material: Usd.Prim, name: str, default: float, above: float, below: float) -> float:
    """An attribute of the deformable material, or `default`; must lie between the bounds."""
    attribute = f"physxDeformableBodyMaterial:{name}"
    value = value_of(material, attribute)
    if value is None:
        return default
    if not above < value < below:
        raise parsed.fail(material, attribute, f"{value:g} is not between {max(above, 0.0):g} and {below:g}")
    return float(value)


def add_flex(spec: mujoco.MjSpec, body: SoftBody, name: str, position: np.ndarray, quat: np.ndarray) -> mujoco.MjsFlex:
    """Make a soft body in the spec that will be compiled.

    Args:
        spec: the whole model. Its integrator must be MuJoCo's ``discrete``: no other is stable with soft bodies.
        body: the soft body.
        name: name of the flex; its nodes become bodies ``{name}_{i}_{j}_{k}``, children of the world.
        position: centre of the body in m.
        quat: orientation of the body (w, x, y, z).
    """
    radius = _INSET * min(body.size)
    flex = spec.worldbody.make_flex(
        name=name,
        type="grid",
        dof="trilinear",
        dim=3,
        count=[GRID] * 3,
        spacing=[(edge - 2 * radius) / (GRID - 1) for edge in body.size],
        radius=radius,
        mass=body.mass,
        pos=[float(v) for v in position],
        quat=[float(v) for v in quat],
    )
    flex.young = body.youngs_modulus
    flex.poisson = body.poissons_ratio
    flex.damping = body.elasticity_damping
    flex.friction = list(body.friction)
    flex.condim = body.condim
    flex.selfcollide = mujoco.mjtFlexSelf.mjFLEXSELF_NONE
    flex.rgba = list(body.rgba)
    for field, values in (("solref", body.solref), ("solimp", body.solimp)):
        if values is not None:
            current = [float(v) for v in getattr(flex, field)]
            setattr(flex, field, [*values, *current[len(values) :]])
    return flex
