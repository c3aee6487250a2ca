"""Materials: contact parameters from physics materials, colour and texture from shading networks."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np
from pxr import Usd, UsdGeom, UsdPhysics, UsdShade

from lift_lab.usd import dialects
from lift_lab.usd.meshes import texcoord_primvar
from lift_lab.usd.names import Names
from lift_lab.usd.parse import ParsedStage, has_schema, value_of
from lift_lab.usd.shading import Look, look_of, read_png

_REF_TIME = 0.02
"""Time constant in s of the contact that an opted-in restitution is given (MuJoCo's default)."""


@dataclass
class Contact:
    """Contact parameters of one physics material; None leaves MuJoCo's default."""

    friction: float | None = None
    torsional: float | None = None
    rolling: float | None = None
    density: float | None = None
    restitution: float = 0.0


class ContactMaterials:
    """Physics materials by prim path, read once each."""

    def __init__(self, parsed: ParsedStage, restitution: bool) -> None:
        self._parsed = parsed
        self._restitution = restitution
        self._known: dict[str, Contact] = {}

    def of_shape(self, prim: Usd.Prim, desc: Any) -> Contact:
        """Contact parameters bound to a collider: the parser's resolved material, physics purpose first."""
        for path in desc.materials:
            if path:
                return self._read(str(path))
        material, _ = UsdShade.MaterialBindingAPI(prim).ComputeBoundMaterial("physics")
        if material and has_schema(material.GetPrim(), "PhysicsMaterialAPI"):
            return self._read(str(material.GetPath()))
        return Contact()

    def _read(self, path: str) -> Contact:
        if path not in self._known:
            self._known[path] = self._load(path)
        return self._known[path]

    def _load(self, path: str) -> Contact:
        parsed, prim = self._parsed, self._parsed.prim(path)
        api = UsdPhysics.MaterialAPI(prim)
        values = {
            "dynamicFriction": api.GetDynamicFrictionAttr().Get(),
            "staticFriction": api.GetStaticFrictionAttr().Get(),
            "restitution": api.GetRestitutionAttr().Get(),
            "density": api.GetDensityAttr().Get(),
        }
        for name, value in values.items():
            if value is None or not math.isfinite(value) or value < 0:
                raise parsed.fail(prim, f"physics:{name}", f"must be a number of at least zero, is {value}")
        dynamic, static = values["dynamicFriction"], values["staticFriction"]
        if api.GetStaticFrictionAttr().HasAuthoredValue() and abs(static - dynamic) > 1e-6:
            reason = f"one coefficient for both: dynamic friction {dynamic:g} is used, not {static:g}"
            parsed.report.approximate(path, "physics:staticFriction", reason)
        if values["restitution"] > 0 and not self._restitution:
            parsed.report.ignore(path, "physics:restitution", "contacts do not bounce unless restitution=True")
        return Contact(
            friction=float(dynamic),
            torsional=dialects.resolve(parsed, dialects.MATERIAL, "torsional friction", prim),
            rolling=dialects.resolve(parsed, dialects.MATERIAL, "rolling friction", prim),
            density=float(values["density"]) * parsed.units.factor("density") or None,
            restitution=float(values["restitution"]),
        )

    def apply(self, contact: Contact, geom: mujoco.MjsGeom) -> None:
        """Write friction, and restitution if it was opted in, to a geom."""
        friction = [float(v) for v in geom.friction]
        for i, value in enumerate((contact.friction, contact.torsional, contact.rolling)):
            if value is not None:
                friction[i] = value
        geom.friction = friction
        if self._restitution and contact.restitution > 0:
            geom.solref = restitution_solref(contact.restitution)


def restitution_solref(restitution: float) -> tuple[float, float]:
    """Direct solref (-stiffness, -damping) of a contact whose rebound speed is `restitution` of the approach speed.

    A spring and damper that only push, of damping ratio z, release where their force reaches zero. They return exp(-2 z
    acos(z) / sqrt(1 - z^2)) of the speed (Schwager and Poeschel, 2007). The stiffness is that of a natural frequency of
    1 / 0.02 s.
    """
    low, high = 1e-6, 10.0
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if _rebound(middle) > restitution else (low, middle)
    return -1.0 / _REF_TIME**2, -2.0 * low / _REF_TIME


def _rebound(ratio: float) -> float:
    """Coefficient of restitution of a one-sided spring and damper with the given damping ratio."""
    if abs(ratio - 1.0) < 1e-9:
        return math.exp(-2.0)
    if ratio < 1.0:
        return math.exp(-2.0 * ratio * math.acos(ratio) / math.sqrt(1.0 - ratio**2))
    return math.exp(-2.0 * ratio * math.acosh(ratio) / math.sqrt(ratio**2 - 1.0))


def srgb(linear: Any) -> tuple[float, float, float]:
    """Linear colour, clipped to [0, 1], as sRGB (IEC 61966-2-1)."""
    c = np.clip(np.nan_to_num(np.asarray(linear, dtype=float)[:3]), 0.0, 1.0)
    r, g, b = np.where(c <= 0.0031308, 12.92 * c, 1.055 * c ** (1 / 2.4) - 0.055)
    return float(r), float(g), float(b)


class Appearance:
    """Colours and textures of visual geoms."""

    def __init__(self, parsed: ParsedStage, spec: mujoco.MjSpec, names: Names) -> None:
        self._parsed = parsed
        self._spec = spec
        self._names = names
        self._textures: dict[str, str | None] = {}

    def apply(self, prim: Usd.Prim, geom: mujoco.MjsGeom, subset: UsdGeom.Subset | None = None) -> None:
        """Give a geom the colour of its bound preview surface, else of its displayColor, else MuJoCo's grey."""
        owner = subset.GetPrim() if subset else prim
        material, _ = UsdShade.MaterialBindingAPI(owner).ComputeBoundMaterial()
        look = look_of(material) if material else None
        if look is not None:
            name = self._texture(look, prim, geom) if look.texture is not None else None
            if name:
                geom.material = name
                geom.rgba = (*(srgb(look.tint) if look.tint is not None else (1.0, 1.0, 1.0)), look.alpha)
                return
            if look.color is not None:
                geom.rgba = (*srgb(look.color), look.alpha)
                return
        elif material and str(material.GetPath()) not in self._textures:
            self._textures[str(material.GetPath())] = None
            if material.GetSurfaceOutputs():
                self._parsed.report.ignore(
                    material.GetPath(), "outputs:surface", "a shader that is not drawn", tuning=True
                )
        color = _display(prim, "displayColor")
        opacity = _display(prim, "displayOpacity")
        if color is not None or opacity is not None:
            rgb = srgb(color) if color is not None else (0.5, 0.5, 0.5)
            geom.rgba = (*rgb, float(np.clip(opacity, 0, 1)) if opacity is not None else 1.0)

    def _texture(self, look: Look, prim: Usd.Prim, geom: mujoco.MjsGeom) -> str | None:
        """Material name for a texture that can be shown on `geom`, None (with a note) for any other."""
        assert look.texture is not None
        where = look.where
        shown = geom.type == mujoco.mjtGeom.mjGEOM_MESH and texcoord_primvar(prim) is not None
        if look.texture.resolvedPath and not shown:
            reason = f"a {prim.GetTypeName()} without texture coordinates shows the colour alone"
            self._parsed.report.ignore(prim.GetPath(), look.attribute, reason, tuning=True)
            return None
        if where not in self._textures:
            self._textures[where] = self._add_texture(look)
        return self._textures[where]

    def _add_texture(self, look: Look) -> str | None:
        assert look.texture is not None
        path, where = look.texture.resolvedPath, look.where
        if not path:
            self._parsed.report.ignore(where, look.attribute, "the texture file does not resolve", tuning=True)
            return None
        try:
            content = read_png(path)
        except ValueError as error:
            self._parsed.report.ignore(where, look.attribute, str(error), tuning=True)
            return None
        name = self._names.of("texture", where)
        key = f"{name}.png"
        self._spec.assets[key] = content
        self._spec.add_texture(name=name, type=mujoco.mjtTexture.mjTEXTURE_2D, file=key)
        material = self._spec.add_material(name=name)
        material.textures[mujoco.mjtTextureRole.mjTEXROLE_RGB] = name
        return name


def _display(prim: Usd.Prim, name: str) -> Any:
    """First value of an inherited displayColor or displayOpacity primvar."""
    primvar = UsdGeom.PrimvarsAPI(prim).FindPrimvarWithInheritance(name)
    values = primvar.Get() if primvar and primvar.HasAuthoredValue() else None
    return values[0] if values is not None and len(values) else None


def display_group(prim: Usd.Prim, default: int) -> int:
    """MuJoCo group from `mjc:group`, else `default`."""
    group = value_of(prim, "mjc:group")
    return int(group) if group is not None else default
