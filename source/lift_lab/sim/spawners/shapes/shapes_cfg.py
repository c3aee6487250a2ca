"""Configs of primitive shapes (names of Isaac Lab's). Lengths in m.

A shape with ``rigid_props`` is a rigid body, one with ``collision_props`` collides; without both it is only drawn.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import ClassVar, Literal

from lift_lab.utils import MISSING, configclass
from lift_lab.utils.ranges import POSITIVE, Ranges

from .. import materials
from ..spawner_cfg import RigidObjectSpawnerCfg
from .shapes import spawn_capsule, spawn_cone, spawn_cuboid, spawn_cylinder, spawn_sphere


@configclass
class ShapeCfg(RigidObjectSpawnerCfg):
    """Base of primitive shapes."""

    visual_material_path: str = "material"
    """Isaac Lab's prim path of the visual material. A label here."""
    visual_material: materials.VisualMaterialCfg | None = None
    """Colour and opacity of a :class:`PreviewSurfaceCfg`; None keeps the default grey."""
    physics_material_path: str = "material"
    """Isaac Lab's prim path of the physics material. A label here."""
    physics_material: materials.PhysicsMaterialCfg | None = None
    """Friction of the shape; None is MuJoCo's default."""


@configclass
class SphereCfg(ShapeCfg):
    """A ball."""

    func: Callable = spawn_sphere
    radius: float = MISSING
    """Radius in m."""

    _ranges: ClassVar[Ranges] = {"radius": POSITIVE}


@configclass
class CuboidCfg(ShapeCfg):
    """A box of full lengths :attr:`size`."""

    func: Callable = spawn_cuboid
    size: tuple[float, float, float] = MISSING
    """Full lengths along x, y and z in m."""

    _ranges: ClassVar[Ranges] = {"size": POSITIVE}


@configclass
class CylinderCfg(ShapeCfg):
    """A cylinder along :attr:`axis`."""

    func: Callable = spawn_cylinder
    radius: float = MISSING
    """Radius in m."""
    height: float = MISSING
    """Height in m."""
    axis: Literal["X", "Y", "Z"] = "Z"
    """Axis of symmetry."""

    _ranges: ClassVar[Ranges] = {"radius height": POSITIVE}


@configclass
class CapsuleCfg(ShapeCfg):
    """A capsule along :attr:`axis`; its height is without the caps."""

    func: Callable = spawn_capsule
    radius: float = MISSING
    """Radius in m."""
    height: float = MISSING
    """Height without the caps in m."""
    axis: Literal["X", "Y", "Z"] = "Z"
    """Axis of symmetry."""

    _ranges: ClassVar[Ranges] = {"radius height": POSITIVE}


@configclass
class ConeCfg(ShapeCfg):
    """A cone along :attr:`axis`."""

    func: Callable = spawn_cone
    radius: float = MISSING
    """Radius in m."""
    height: float = MISSING
    """Height in m."""
    axis: Literal["X", "Y", "Z"] = "Z"
    """Axis of symmetry."""

    _ranges: ClassVar[Ranges] = {"radius height": POSITIVE}
