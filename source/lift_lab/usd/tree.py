"""The joint graph as a kinematic forest: parents, their joints, and the joints that are left over.

USD joints connect two bodies without saying which is the parent, may close loops, and may run against the tree.
MuJoCo needs a tree, so a joint is either an edge of it (possibly reversed) or becomes an equality constraint.
"""

from __future__ import annotations

import heapq
from dataclasses import dataclass, field

from pxr import Usd, UsdGeom

from lift_lab.usd.dialects import SITE_SCHEMAS
from lift_lab.usd.parse import Joint, ParsedStage, applied_schemas, has_schema, targets_of
from lift_lab.usd.units import Pose


@dataclass
class Edge:
    """A joint seen from its tree parent: frames in the parent and in the child, `reversed` if body1 is the parent."""

    joint: Joint
    parent_frame: Pose
    child_frame: Pose
    reversed: bool

    @property
    def offset(self) -> Pose:
        """Child body in the parent body at joint position zero."""
        return self.parent_frame @ self.child_frame.inverse()


@dataclass
class Link:
    """One rigid body in the forest."""

    path: str
    parent: str | None
    """Path of the parent body, None under the world."""
    edges: list[Edge] = field(default_factory=list)
    """Joints to the parent; empty for a body that floats freely, is kinematic or is disabled."""
    free: bool = False
    mocap: bool = False
    children: list[Link] = field(default_factory=list)


@dataclass
class Forest:
    """All links in depth-first order, and the joints that are not part of the tree."""

    roots: list[Link]
    links: dict[str, Link]
    loops: list[Joint]

    def component(self, path: str) -> list[str]:
        """Paths of all links of the tree that `path` belongs to."""
        link = self.links[path]
        while link.parent:
            link = self.links[link.parent]
        stack, found = [link], []
        while stack:
            link = stack.pop()
            found.append(link.path)
            stack.extend(reversed(link.children))
        return found


def build_forest(parsed: ParsedStage) -> Forest:
    """Choose roots and tree edges.

    A body with a joint to the world is a root. Any other connected group has a free joint. It is at the body with the
    articulation root, else at one that is no joint's body1, else at its first body.

    Where joints form a loop, those that are driven, followed or limited go into the tree first. An equality can replace
    a plain joint. Then the authored order decides, and a joint from parent to child comes before one that would have to
    be reversed.
    """
    incident: dict[str | None, list[tuple[int, Joint]]] = {path: [] for path in parsed.bodies}
    incident[None] = []
    for i, joint in enumerate(parsed.joints.values()):
        if not joint.excluded:
            incident[joint.body0].append((i, joint))
            incident[joint.body1].append((i, joint))
    state = _Growth(parsed, incident)
    for path, body in parsed.bodies.items():
        if not body.rigidBodyEnabled or body.kinematicBody:
            state.start(path, free=False, mocap=bool(body.rigidBodyEnabled))
    state.grow([None])
    while state.remaining:
        root = _floating_root(parsed, incident, next(iter(state.remaining)))
        state.start(root, free=True)
        state.grow([root])
    used = {edge.joint.path for link in state.links.values() for edge in link.edges}
    held = {link.path for link in state.roots if not link.free and not link.edges}
    loops = []
    for joint in parsed.joints.values():
        if joint.path in used:
            continue
        if all(body is None or body in held for body in (joint.body0, joint.body1)):
            parsed.report.ignore(joint.path, "", "both sides are held already: world, kinematic or disabled bodies")
        else:
            loops.append(joint)
    links = {path: link for root in state.roots for path, link in _preorder(root)}
    return Forest(state.roots, links, loops)


class _Growth:
    """Grows trees over the joint graph from given bodies."""

    def __init__(self, parsed: ParsedStage, incident: dict[str | None, list[tuple[int, Joint]]]) -> None:
        self.incident = incident
        self.links: dict[str, Link] = {}
        self.roots: list[Link] = []
        self.remaining = dict.fromkeys(parsed.bodies)
        self.kinematic: list[str] = []
        self.by_index = {i: joint for entries in incident.values() for i, joint in entries}
        wanted = _wanted(parsed)
        self.rank = {i: _rank(joint, wanted) for i, joint in self.by_index.items()}

    def start(self, path: str, free: bool, mocap: bool = False) -> None:
        link = Link(path, None, free=free, mocap=mocap)
        self.links[path] = link
        self.roots.append(link)
        self.remaining.pop(path)
        if not free:
            self.kinematic.append(path)

    def grow(self, sources: list[str | None]) -> None:
        """Attach everything that can be reached from `sources` (None is the world) and from kinematic bodies."""
        heap: list[tuple[int, bool, int, str | None]] = []
        grown: dict[str | None, list[tuple[bool, int, Link]]] = {}

        def push(path: str | None) -> None:
            for i, joint in self.incident[path]:
                heapq.heappush(heap, (self.rank[i], joint.body0 != path, i, path))

        for path in [*sources, *self.kinematic]:
            push(path)
        self.kinematic.clear()
        while heap:
            _, against, index, parent = heapq.heappop(heap)
            joint = self.by_index[index]
            child = joint.body0 if against else joint.body1
            if child not in self.remaining or child is None:
                continue
            link = Link(child, parent)
            self.links[child] = link
            self.remaining.pop(child)
            grown.setdefault(parent, []).append((against, index, link))
            # Several joints between the same two bodies are one compound joint (MJCF-derived stages).
            for _, other in self.incident[child]:
                if {other.body0, other.body1} == {parent, child} and _compound(joint, other):
                    link.edges.append(_edge(other, parent))
            push(child)
        for parent, found in grown.items():
            children = [link for _, _, link in sorted(found, key=lambda item: item[:2])]
            (self.links[parent].children if parent else self.roots).extend(children)


def without_collider(parsed: ParsedStage, forest: Forest) -> list[str]:
    """Paths of the bodies that move and that nothing can touch (:attr:`ImportReport.without_collider`)."""
    held = {parsed.body_of(parsed.prim(path)) for path in parsed.shapes}
    candidates = [link for link in forest.links.values() if _moves(link) and not held & _rigid_group(link)]
    if not candidates:
        return []
    shown = {parsed.body_of(prim) for prim in parsed.prims if prim.IsA(UsdGeom.Gprim) and not _is_site(prim)}
    return [
        link.path for link in candidates if shown & _rigid_group(link) or not held & set(forest.component(link.path))
    ]


def _moves(link: Link) -> bool:
    return link.free or link.mocap or any(edge.joint.kind != "fixed" for edge in link.edges)


def _rigid_group(link: Link) -> set[str | None]:
    """A body and those that are welded to it, away from the root."""
    stack, found = [link], set()
    while stack:
        link = stack.pop()
        found.add(link.path)
        stack += [child for child in link.children if not _moves(child)]
    return found


def _is_site(prim: Usd.Prim) -> bool:
    return any(has_schema(prim, name) for name in SITE_SCHEMAS)


def _wanted(parsed: ParsedStage) -> set[str]:
    """Joints that an actuator drives, or that mimic another or are mimicked."""
    found: set[str] = set()
    for prim in parsed.prims:
        if str(prim.GetTypeName()) in ("MjcActuator", "NewtonActuator"):
            found.update(targets_of(prim, "mjc:target") + targets_of(prim, "newton:targets"))
    for path, joint in parsed.joints.items():
        schemas = [s for s in applied_schemas(joint.prim) if "Mimic" in s or s == "MjcEqualityJointAPI"]
        for schema in schemas:
            names = (f"physxMimicJoint:{schema.partition(':')[2]}:referenceJoint", "newton:mimicJoint", "mjc:target")
            found.update([path, *(target for name in names for target in targets_of(joint.prim, name))])
    return found


def _rank(joint: Joint, wanted: set[str]) -> int:
    """0 for a joint that belongs in the tree, 1 for one with limits, 2 for one that an equality replaces exactly."""
    desc = joint.desc
    drives = [desc.drive] if joint.kind in ("revolute", "prismatic") else []
    drives += [pair.second for pair in desc.jointDrives] if joint.kind == "d6" else []
    if joint.kind == "fixed" or joint.path in wanted or any(drive.enabled for drive in drives):
        return 0
    if joint.kind in ("prismatic", "d6"):
        return 1
    limit = getattr(desc, "limit", None)
    return 1 if limit is not None and limit.enabled else 2


def _compound(first: Joint, other: Joint) -> bool:
    return other is first or (first.kind in _MOVING and other.kind in _MOVING)


_MOVING = {"revolute", "prismatic", "spherical", "d6"}


def _edge(joint: Joint, parent: str | None) -> Edge:
    if joint.body0 == parent:
        return Edge(joint, joint.frame0, joint.frame1, reversed=False)
    return Edge(joint, joint.frame1, joint.frame0, reversed=True)


def _floating_root(parsed: ParsedStage, incident: dict[str | None, list[tuple[int, Joint]]], seed: str) -> str:
    group, stack = {seed: None}, [seed]
    while stack:
        for _, joint in incident[stack.pop()]:
            for path in (joint.body0, joint.body1):
                if path is not None and path not in group:
                    group[path] = None
                    stack.append(path)
    members = sorted(group, key=lambda path: parsed.order[path])
    for path in members:
        if has_schema(parsed.prim(path), "PhysicsArticulationRootAPI"):
            return path
    followers = {joint.body1 for path in members for _, joint in incident[path]}
    return next((path for path in members if path not in followers), members[0])


def _preorder(root: Link) -> list[tuple[str, Link]]:
    stack, found = [root], []
    while stack:
        link = stack.pop()
        found.append((link.path, link))
        stack.extend(reversed(link.children))
    return found
