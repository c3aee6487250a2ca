"""Mass, centre of mass and inertia of bodies, by the precedence rules of UsdPhysics.MassAPI.

Explicit values on the body win over those on its colliders, and these win over densities. The order of densities is
collider, body, physics material, 1000 kg/m^3. Volumes, centres and inertias of shapes come from MuJoCo's own compiler.
Only enabled colliders count. Values that equal the schema's fallbacks (mass 0, inertia 0, centre -inf, axes 0) are
unset even where they are authored.
"""

from __future__ import annotations

import re
from dataclasses import dataclass

import mujoco
import numpy as np
from pxr import Usd, UsdPhysics

from lift_lab.usd import dialects
from lift_lab.usd.dialects import INERTIA_6
from lift_lab.usd.geoms import Collider, place
from lift_lab.usd.meshes import MeshStore
from lift_lab.usd.names import Names
from lift_lab.usd.parse import ParsedStage, value_of
from lift_lab.usd.report import UsdImportError
from lift_lab.usd.shapes import GEOM, local_affine
from lift_lab.usd.units import Pose, polar, quat_to_mat

WATER = 1000.0
"""Density in kg/m^3 of a collider that nothing else gives one."""
_BALL_RADIUS = 0.1
"""Radius in m of the ball whose inertia usd-core gives a body that has a mass and no collider."""
_SMALLEST = 1e-15
"""MuJoCo's smallest mass and moment of a body that moves (mjMINVAL)."""
_ROUNDING = 1e-4
"""Relative violation of the triangle inequality that is taken for float32 rounding."""


@dataclass
class Explicit:
    """Values of a MassAPI, in SI units and in the requested frame; None where it is unset."""

    mass: float | None = None
    density: float | None = None
    com: np.ndarray | None = None
    diagonal: np.ndarray | None = None
    axes: np.ndarray | None = None
    full: np.ndarray | None = None

    @property
    def tensor(self) -> np.ndarray | None:
        """Inertia tensor about the centre of mass."""
        if self.full is not None:
            return self.full
        if self.diagonal is None or self.axes is None:
            return None
        return self.axes @ np.diag(self.diagonal) @ self.axes.T


@dataclass
class Inertial:
    """Mass, centre and inertia tensor about the centre, in the body frame."""

    mass: float
    com: np.ndarray
    tensor: np.ndarray


def read_explicit(parsed: ParsedStage, prim: Usd.Prim, frame: Pose) -> Explicit:
    """MassAPI and newton:inertia of a body or a collider, expressed in `frame`.

    Raises:
        UsdImportError: A value is negative or not a number.
    """
    found = Explicit()
    if not prim.HasAPI(UsdPhysics.MassAPI):
        return found
    units = parsed.units
    for name in ("mass", "density"):
        value = value_of(prim, f"physics:{name}")
        if value is None or value == 0:
            continue
        if not (np.isfinite(value) and value > 0):
            raise parsed.fail(prim, f"physics:{name}", f"must be a positive number (0 means unset), is {value:g}")
        setattr(found, name, float(value) * units.factor(name))
    linear, origin = local_affine(parsed, prim, frame)
    rotation = polar(linear)[0]
    com = value_of(prim, "physics:centerOfMass")
    if com is not None and np.isfinite(com).all():
        found.com = linear @ np.array(com, dtype=float) * units.length + origin
    elif com is not None and np.isnan(com).any():
        raise parsed.fail(prim, "physics:centerOfMass", "not a number")
    diagonal = value_of(prim, "physics:diagonalInertia")
    if diagonal is not None and any(diagonal):
        values = np.array(diagonal, dtype=float)
        if not (np.isfinite(values).all() and (values >= 0).all()):
            raise parsed.fail(prim, "physics:diagonalInertia", f"must not be negative, is ({_listed(values)})")
        axes = value_of(prim, "physics:principalAxes")
        found.diagonal = values * units.factor("inertia_tensor")
        found.axes = rotation @ (quat_to_mat(axes) if axes is not None else np.eye(3))
    six = value_of(prim, INERTIA_6)
    if six is not None and len(six):
        if len(six) != 6 or not np.isfinite(six).all():
            raise parsed.fail(prim, INERTIA_6, "must be six finite numbers")
        xx, yy, zz, xy, xz, yz = np.array(six, dtype=float) * units.factor("inertia_tensor")
        found.full = rotation @ np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]) @ rotation.T
        parsed.report.took("inertia", "newton")
    return found


def set_inertials(
    parsed: ParsedStage, bodies: dict[str, tuple[mujoco.MjsBody, Pose, bool]], colliders: list[Collider]
) -> None:
    """Give every rigid body an explicit inertial.

    A body without a degree of freedom may have no mass or inertia. MuJoCo needs them only on a body that moves, or on
    one that is welded to it.

    Args:
        bodies: MuJoCo body, world frame and whether it has a degree of freedom of its own, by prim path.
        colliders: All enabled colliders.

    Raises:
        UsdImportError: A body that moves has too little mass or inertia, or a value is no inertia at all.
    """
    explicit = {path: read_explicit(parsed, parsed.prim(path), frame) for path, (_, frame, _) in bodies.items()}
    incomplete = {p for p, e in explicit.items() if e.mass is None or e.com is None or e.tensor is None}
    parts: dict[str, list[Inertial]] = {path: [] for path in bodies}
    groups: dict[str, tuple[str, Explicit, list[Inertial]]] = {}
    for collider, unit in _shape_inertials(parsed, [c for c in colliders if c.home.path in incomplete]):
        path = str(collider.home.path)
        owner = _massive_owner(parsed, collider)
        if owner is None:
            parts[path].append(_part(parsed, collider, unit, explicit[path]))
            continue
        of_owner = read_explicit(parsed, parsed.prim(owner), collider.home.frame) if owner not in groups else None
        _, stated, members = groups.setdefault(owner, (path, of_owner or Explicit(), []))
        members.append(_part(parsed, collider, unit, explicit[path], stated.density))
    for owner, (path, stated, members) in groups.items():
        whole = _combine(parsed, owner, stated, members, moving=False)
        if whole is not None:
            tensor = stated.tensor if stated.tensor is not None else whole.tensor
            parts[path].append(Inertial(whole.mass, whole.com, tensor))
    _note_masses_above(parsed, colliders)
    for path, (body, _, moving) in bodies.items():
        inertial = _combine(parsed, path, explicit[path], parts[path], moving)
        if inertial is not None:
            _write(parsed, path, body, inertial, explicit[path])
    for path, (body, _, moving) in bodies.items():
        if moving and not _carries(body):
            raise _too_light(parsed, path, body, explicit[path])
    for path in list(parsed.scenes)[:1]:
        wanted = dialects.resolve(parsed, dialects.SCENE, "total mass", parsed.prim(path))
        total = sum(body.mass for body, _, _ in bodies.values())
        if wanted and total > 0:
            for body, _, _ in bodies.values():
                body.mass, body.inertia = body.mass * wanted / total, np.asarray(body.inertia) * wanted / total


def _shape_inertials(parsed: ParsedStage, colliders: list[Collider]) -> list[tuple[Collider, Inertial]]:
    """Volume, centre and inertia at density one of each collider, in the frame of its body."""
    if not colliders:
        return []
    spec = mujoco.MjSpec()
    store = MeshStore(spec, Names())
    for i, collider in enumerate(colliders):
        body = spec.worldbody.add_body(name=str(i))
        for shape in collider.shapes:
            if shape.type == GEOM.mjGEOM_PLANE:
                continue
            geom = body.add_geom(density=1.0)
            place(geom, shape, store.add(f"/{i}", shape.mesh, True, shell=collider.shell) if shape.mesh else "")
            if collider.shell and shape.mesh is None:
                geom.typeinertia = mujoco.mjtGeomInertia.mjINERTIA_SHELL
    try:
        model = spec.compile()
    except ValueError as error:  # MuJoCo names the element, which is the collider's index
        index = re.search(r"name '(\d+)'", str(error))
        path = colliders[int(index.group(1))].path if index else colliders[0].path
        raise parsed.fail(path, "points", " ".join(str(error).split())) from None
    found = []
    for i, collider in enumerate(colliders):
        axes = quat_to_mat(model.body_iquat[i + 1])
        tensor = axes @ np.diag(model.body_inertia[i + 1]) @ axes.T
        found.append((collider, Inertial(float(model.body_mass[i + 1]), model.body_ipos[i + 1].copy(), tensor)))
    return found


def _massive_owner(parsed: ParsedStage, collider: Collider) -> str | None:
    """The prim whose CollisionAPI a shape inherits, if its MassAPI is that of all its shapes together."""
    inherited = parsed.inherited.get(collider.path)
    if inherited is None or inherited.owner in parsed.bodies:
        return None
    owner = parsed.prim(inherited.owner)
    return inherited.owner if owner.HasAPI(UsdPhysics.MassAPI) and parsed.body_of(owner) == collider.home.path else None


def _note_masses_above(parsed: ParsedStage, colliders: list[Collider]) -> None:
    """Note a MassAPI whose prim gives CollisionAPI to shapes of bodies below it: there is no one body to weigh."""
    for collider in colliders:
        inherited = parsed.inherited.get(collider.path)
        if inherited is None or inherited.owner in parsed.bodies or collider.home.path is None:
            continue
        owner = parsed.prim(inherited.owner)
        if owner.HasAPI(UsdPhysics.MassAPI) and parsed.body_of(owner) != collider.home.path:
            parsed.report.ignore(owner.GetPath(), "PhysicsMassAPI", "its colliders belong to bodies below it")


def _part(
    parsed: ParsedStage, collider: Collider, unit: Inertial, body: Explicit, above: float | None = None
) -> Inertial:
    """Inertial of one collider; `above` is the density that the prim states whose CollisionAPI it inherits."""
    own = read_explicit(parsed, collider.prim, collider.home.frame)
    thickness = value_of(collider.prim, "newton:shellThickness")
    if collider.shell and thickness is not None and np.isfinite(thickness):
        wall = float(thickness) * parsed.units.length
        unit = Inertial(unit.mass * wall, unit.com, unit.tensor * wall)
    density = own.density or above or body.density or collider.contact.density or WATER
    mass = own.mass if own.mass is not None else density * unit.mass
    com = own.com if own.com is not None else unit.com
    tensor = own.tensor
    if tensor is None:
        tensor = unit.tensor * (mass / unit.mass if unit.mass > 0 else 0.0) + mass * _parallel(com - unit.com)
    return Inertial(mass, com, tensor)


def _combine(
    parsed: ParsedStage, path: str, explicit: Explicit, parts: list[Inertial], moving: bool
) -> Inertial | None:
    total = sum(part.mass for part in parts)
    mass = explicit.mass if explicit.mass is not None else total
    com, tensor = np.zeros(3), np.zeros((3, 3))
    if total > 0:
        com = np.sum([part.mass * part.com for part in parts], axis=0) / total
        centre = explicit.com if explicit.com is not None else com
        tensor = np.sum([part.tensor + part.mass * _parallel(part.com - com) for part in parts], axis=0)
        tensor = tensor * (mass / total) + mass * _parallel(centre - com)
    com = explicit.com if explicit.com is not None else com
    if mass <= 0:
        if not moving:
            return None
        if explicit.tensor is None:
            mass, tensor = 1.0, 0.4 * _BALL_RADIUS**2 * np.eye(3)
            reason = "no mass, density or collider: a ball of 1 kg and 0.1 m, as PhysX assumes"
            parsed.report.approximate(path, "physics:mass", reason)
    elif total <= 0 and explicit.tensor is None:
        tensor = 0.4 * mass * _BALL_RADIUS**2 * np.eye(3)
        reason = "a mass without inertia or collider: the inertia of a ball of 0.1 m, as usd-core assumes"
        parsed.report.approximate(path, "physics:diagonalInertia", reason)
    return Inertial(mass, com, tensor)


def _parallel(offset: np.ndarray) -> np.ndarray:
    """Inertia of a unit point mass at `offset`."""
    return offset @ offset * np.eye(3) - np.outer(offset, offset)


def _write(parsed: ParsedStage, path: str, body: mujoco.MjsBody, inertial: Inertial, explicit: Explicit) -> None:
    body.mass, body.ipos = inertial.mass, inertial.com
    body.explicitinertial = True
    if explicit.full is None and explicit.diagonal is not None and explicit.axes is not None:
        moments, axes = explicit.diagonal, explicit.axes
    else:
        tensor = explicit.full if explicit.full is not None else inertial.tensor
        if not np.isfinite(tensor).all():
            raise parsed.fail(path, _inertia_attribute(explicit), "mass or inertia is not finite")
        moments, axes = np.linalg.eigh(tensor)
        axes = axes * np.sign(np.linalg.det(axes))
    if not (np.isfinite(moments).all() and np.isfinite(inertial.mass)):
        raise parsed.fail(path, _inertia_attribute(explicit), "mass or inertia is not finite")
    if moments.min() < -1e-6 * np.abs(moments).max():
        reason = f"no inertia: a principal moment is negative, {_listed(moments)} kg m^2"
        raise parsed.fail(path, _inertia_attribute(explicit), reason)
    moments = np.maximum(moments, 0.0)
    largest, (least, middle, _) = int(np.argmax(moments)), np.sort(moments)
    others = float(least + middle)
    if moments[largest] > others:
        excess = float(moments[largest] / others - 1) if others > 0 else np.inf
        cause = "float32 rounding" if excess < _ROUNDING else f"no rigid body has it, by {100 * excess:.2g} %"
        if excess > 1e-9:
            reason = f"largest moment lowered to the sum of the others ({cause})"
            parsed.report.approximate(path, _inertia_attribute(explicit), reason)
        moments = moments.copy()
        moments[largest] = max(others * (1 - 1e-12), middle)
    body.inertia, body.iquat = moments, Pose(np.zeros(3), axes).quat


def _inertia_attribute(explicit: Explicit) -> str:
    """The attribute that the inertia of a body comes from."""
    if explicit.full is not None:
        return INERTIA_6
    return "physics:diagonalInertia" if explicit.diagonal is not None else "physics:mass"


def _carries(body: mujoco.MjsBody) -> bool:
    """Whether a body, or one that is welded to it, has the mass and inertia that MuJoCo needs of one that moves."""
    stack = [body]
    while stack:
        body = stack.pop()
        if body.mass >= _SMALLEST and np.min(body.inertia) >= _SMALLEST:
            return True
        stack += [child for child in body.bodies if not child.joints]
    return False


def _too_light(parsed: ParsedStage, path: str, body: mujoco.MjsBody, explicit: Explicit) -> UsdImportError:
    """The error for a body that moves: it names the attribute that is too small, or where both would come from."""
    needs = f"a body that moves, or one welded to it, needs a mass of {_SMALLEST:g} kg and moments of {_SMALLEST:g}"
    if body.mass < _SMALLEST:
        source = "" if explicit.mass is not None else ": give it a mass, or a collider with volume"
        return parsed.fail(path, "physics:mass", f"{needs} kg m^2 at least; the mass is {body.mass:g} kg{source}")
    reason = f"{needs} kg m^2 at least; the moments are {_listed(body.inertia)}"
    return parsed.fail(path, _inertia_attribute(explicit), reason)


def _listed(numbers: np.ndarray) -> str:
    return ", ".join(f"{number:g}" for number in numbers)
