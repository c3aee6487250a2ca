"""The whole way from a parsed stage to a MuJoCo spec, step by step."""

from __future__ import annotations

import mujoco
import numpy as np
from pxr import Usd, UsdGeom

from lift_lab.usd import dialects, mjc
from lift_lab.usd.audit import audit_support
from lift_lab.usd.deformable import read_soft_bodies
from lift_lab.usd.drives import add_drives, read_start, scale_acceleration_drives
from lift_lab.usd.filters import add_filters
from lift_lab.usd.geoms import Collider, Home, add_colliders
from lift_lab.usd.joints import BuiltDof, add_joints
from lift_lab.usd.loops import add_loops, add_mimics
from lift_lab.usd.mass import set_inertials
from lift_lab.usd.materials import Appearance, ContactMaterials
from lift_lab.usd.meshes import MeshStore
from lift_lab.usd.names import Names
from lift_lab.usd.newton import add_newton_actuators
from lift_lab.usd.options import set_scene_options
from lift_lab.usd.order import fill_orders
from lift_lab.usd.parse import ParsedStage
from lift_lab.usd.report import OptionSource
from lift_lab.usd.tree import Forest, Link, build_forest, without_collider
from lift_lab.usd.units import Pose
from lift_lab.usd.visuals import add_visuals

_EARTH = 9.81


class Builder:
    """Builds one spec; the order of the steps is the order of the methods."""

    def __init__(self, parsed: ParsedStage, restitution: bool = False) -> None:
        self.parsed = parsed
        self.spec = mujoco.MjSpec()
        self.spec.modelname = parsed.report.default_prim or "usd"
        self.spec.compiler.degree = False
        self.names = Names()
        self.store = MeshStore(self.spec, self.names)
        self.appearance = Appearance(parsed, self.spec, self.names)
        self.contacts = ContactMaterials(parsed, restitution)
        self.forest: Forest = build_forest(parsed)
        self.bodies: dict[str, tuple[mujoco.MjsBody, Pose, bool]] = {}
        """MuJoCo body, world frame and whether it moves, by prim path."""
        self.homes: dict[str, Home] = {}
        self.world = Home(self.spec.worldbody, Pose.identity(), None, moving=False)
        self.dofs: list[BuiltDof] = []

    def build(self) -> mujoco.MjSpec:
        """Run every step and fill the report's lists of names."""
        self.add_scene()
        self.add_bodies()
        self.add_geometry()
        self.add_constraints()
        self.add_actuation()
        audit_support(self.parsed)
        self.fill_report()
        return self.spec

    def add_scene(self) -> None:
        """Gravity, and the options of the first physics scene."""
        units = self.parsed.units
        gravity = np.array([0.0, 0.0, -_EARTH])
        for path in list(self.parsed.scenes)[1:]:
            reason = f"one physics scene per model: <{next(iter(self.parsed.scenes))}> holds"
            self.parsed.report.ignore(path, "", reason)
        for path, desc in list(self.parsed.scenes.items())[:1]:
            prim = self.parsed.prim(path)
            # Seven digits undo float32: 9.81 as authored, not 9.8100004.
            magnitude = float(f"{desc.gravityMagnitude * units.length:.7g}")
            magnitude = magnitude if magnitude >= 0 else _EARTH  # any negative value asks for earth's
            direction = np.array(desc.gravityDirection, dtype=float)
            if not (np.isfinite(magnitude) and np.isfinite(direction).all()):
                raise self.parsed.fail(prim, "physics:gravityMagnitude", "gravity is not finite")
            gravity = units.up @ direction * magnitude + 0.0
            switch = dialects.resolve(self.parsed, dialects.SCENE, "gravity switch", prim)
            if switch in (False, 0.0):
                gravity = np.zeros(3)
            rate = dialects.resolve(self.parsed, dialects.SCENE, "step rate", prim)
            options = self.parsed.report.options
            names = [f"physics:gravity{part}" for part in ("Magnitude", "Direction")]
            authored = [name for name in names if prim.GetAttribute(name).HasAuthoredValue()]
            authored += ["gravity switch"] if switch is not None else []
            options += [OptionSource(path, name, "gravity") for name in authored[:1]]
            if rate is not None and rate < 0:
                raise self.parsed.fail(prim, "timeStepsPerSecond", f"must not be negative, is {rate:g}")
            if rate:
                self.spec.option.timestep = 1.0 / rate
                options.append(OptionSource(path, "timeStepsPerSecond", "timestep"))
            mjc.read_options(self.parsed, prim, self.spec)
        set_scene_options(self.spec, self.parsed.report)
        self.spec.option.gravity = gravity

    def add_bodies(self) -> None:
        """Bodies with their joints, depth first, so that names and order follow the tree."""
        for root in self.forest.roots:
            self._add_link(root, self.spec.worldbody, Pose.identity(), fixed=True)
        roots = sorted(self.parsed.articulations, key=lambda path: self.parsed.order.get(path, 0))
        self.parsed.report.articulation_roots = roots

    def _add_link(self, root: Link, parent: mujoco.MjsBody, parent_frame: Pose, fixed: bool) -> None:
        stack = [(root, parent, parent_frame, fixed)]
        while stack:
            link, parent, parent_frame, fixed = stack.pop()
            parsed, prim = self.parsed, self.parsed.prim(link.path)
            authored = parsed.pose(prim)
            local = link.edges[0].offset if link.edges else authored
            frame = parent_frame @ local if link.edges else authored
            body = parent.add_body(name=self.names.of("body", link.path), pos=local.position, quat=local.quat)
            if link.free:
                body.add_freejoint(name=self.names.of("joint", f"/{body.name}"))
            body.mocap = link.mocap
            self.dofs += add_joints(parsed, self.names, link, body)
            gravcomp = dialects.resolve(parsed, dialects.BODY, "gravcomp", prim)
            if gravcomp is not None:
                body.gravcomp = float(gravcomp)
            self._check_world_pose(link, frame, authored)
            moving = bool(body.joints)
            # Geoms hang on the body in its own frame: the authored poses place them.
            self.bodies[link.path] = (body, authored, moving)
            self.parsed.report.prim_paths[body.name] = link.path
            fixed = fixed and not moving
            self.homes[link.path] = Home(body, authored, link.path, moving=not fixed)
            stack.extend((child, body, frame, fixed) for child in reversed(link.children))

    def _check_world_pose(self, link: Link, frame: Pose, authored: Pose) -> None:
        if link.parent is None and link.edges and link.edges[0].joint.kind == "fixed":
            gap = frame.inverse() @ authored
            if np.abs(gap.pos).max() > 1e-4 or np.abs(gap.rot - np.eye(3)).max() > 1e-3:
                reason = "placed by the frames of its fixed joint to the world, which the authored pose contradicts"
                self.parsed.report.approximate(link.path, "xformOpOrder", reason)

    def home_of(self, prim: Usd.Prim) -> Home:
        """Body that a prim belongs to; static geometry shares the default prim's, cameras and lights the world's."""
        path = self.parsed.body_of(prim)
        if path is not None:
            return self.homes[path]
        if not prim.IsA(UsdGeom.Gprim):
            return self.world
        owner = self._static_owner(prim)
        key = f"static:{owner.GetPath()}"
        if key not in self.homes:
            frame = self.parsed.pose(owner) if owner.IsA(UsdGeom.Xformable) else Pose.identity()
            name = self.names.of("body", str(owner.GetPath()))
            body = self.spec.worldbody.add_body(name=name, pos=frame.position, quat=frame.quat)
            self.homes[key] = Home(body, frame, None, moving=False)
            self.parsed.report.prim_paths[name] = str(owner.GetPath())
        return self.homes[key]

    def _static_owner(self, prim: Usd.Prim) -> Usd.Prim:
        default = self.parsed.stage.GetDefaultPrim()
        if default and prim.GetPath().HasPrefix(default.GetPath()):
            return default
        while prim.GetParent() and not prim.GetParent().IsPseudoRoot():
            prim = prim.GetParent()
        return prim

    def add_geometry(self) -> None:
        """Colliders, then what is only seen, then mass."""
        self.colliders: list[Collider] = add_colliders(
            self.parsed, self.names, self.store, self.contacts, self.appearance, self.home_of
        )
        self.parsed.report.soft_bodies = read_soft_bodies(self.parsed, self.appearance)
        drawn = {collider.path for collider in self.colliders if collider.shows_itself}
        drawn |= {body.prim_path for body in self.parsed.report.soft_bodies}
        add_visuals(self.parsed, self.names, self.store, self.appearance, self.home_of, drawn)
        set_inertials(self.parsed, self.bodies, self.colliders)

    def add_constraints(self) -> None:
        """Loop closures, mimics and contact filters."""
        body_names = {path: body.name for path, (body, _, _) in self.bodies.items()}
        self.dofs += add_loops(self.parsed, self.spec, self.names, self.forest.loops, body_names)
        add_mimics(self.parsed, self.spec, self.names, self.dofs)
        add_filters(self.parsed, self.spec, self.forest, self.colliders, body_names)

    def add_actuation(self) -> None:
        """Drives, MjcPhysics elements and the initial state."""
        acceleration = add_drives(self.parsed, self.spec, self.names, self.dofs)
        mjc.add_elements(self.parsed, self.spec, self.names)
        add_newton_actuators(self.parsed, self.spec, self.names, self.dofs)
        scale_acceleration_drives(self.parsed, self.spec, acceleration)
        read_start(self.parsed, self.forest, self.dofs)
        mjc.add_keyframes(self.parsed, self.spec, self.names)

    def fill_report(self) -> None:
        """Names in model order, then in the others."""
        report = self.parsed.report
        stack = list(reversed(self.spec.worldbody.bodies))
        report.without_collider = [self.bodies[path][0].name for path in without_collider(self.parsed, self.forest)]
        report.root_bodies = [body.name for body in self.spec.worldbody.bodies]
        while stack:
            body = stack.pop()
            report.bodies.append(body.name)
            report.joints += [joint.name for joint in body.joints]
            stack.extend(reversed(body.bodies))
        report.actuators = [actuator.name for actuator in self.spec.actuators]
        body_names = {path: body.name for path, (body, _, _) in self.bodies.items()}
        fill_orders(report, self.parsed, self.forest, self.dofs, body_names)
