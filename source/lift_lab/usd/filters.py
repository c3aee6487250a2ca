"""Contact filters: collision groups, filtered pairs, joints and articulations.

Rules between whole bodies become excludes. Rules between colliders (groups, pairs of single colliders) become bits of
contype and conaffinity. Each class of colliders with the same rules has one bit, and bit 0 is for colliders without
rules.
"""

from __future__ import annotations

from itertools import combinations

import mujoco
from pxr import Sdf, Usd, UsdPhysics

from lift_lab.usd import dialects
from lift_lab.usd.geoms import Collider
from lift_lab.usd.parse import Joint, ParsedStage
from lift_lab.usd.tree import Forest, Link
from lift_lab.utils.errors import ConfigError

SELF_COLLISION = "self_collision:"
"""Start of the names of the excludes that an articulation's self-collision switch makes."""
BITS = 30
"""Classes that fit beside bit 0 and the sign (contype is a signed 32-bit integer)."""
ALL_BITS = (1 << (BITS + 1)) - 1


def add_filters(
    parsed: ParsedStage,
    spec: mujoco.MjSpec,
    forest: Forest,
    colliders: list[Collider],
    body_names: dict[str, str],
) -> None:
    """Write every contact rule of the stage; `body_names` gives the MuJoCo body of a rigid body's path."""
    rules = _Rules(parsed, forest, colliders, body_names)
    rules.joints()
    rules.articulations()
    rules.filtered_pairs()
    rules.groups()
    rules.write(spec)


class _Rules:
    def __init__(
        self, parsed: ParsedStage, forest: Forest, colliders: list[Collider], body_names: dict[str, str]
    ) -> None:
        self.parsed, self.forest, self.colliders, self.body_names = parsed, forest, colliders, body_names
        self.index = {collider.path: i for i, collider in enumerate(colliders)}
        self.of_body: dict[str, list[int]] = {}
        for i, collider in enumerate(colliders):
            self.of_body.setdefault(collider.home.body.name, []).append(i)
        self.bodies: dict[tuple[str, str], bool] = {}
        """Whether nothing but a self-collision switch keeps two bodies apart, by their names."""
        self.pairs: set[tuple[int, int]] = set()

    def exclude(self, a: str, b: str, switch: bool = False) -> None:
        """Forbid contact between two MuJoCo bodies; `switch` tells a self-collision switch from other rules."""
        if a != b:
            key = (a, b) if a < b else (b, a)
            self.bodies[key] = switch and self.bodies.get(key, True)

    def joints(self) -> None:
        for joint in self.parsed.joints.values():
            if not joint.desc.collisionEnabled:
                self._part(joint)
            elif joint.body0 and joint.body1:
                reason = "MuJoCo never collides a body with its tree parent"
                self.parsed.report.approximate(joint.path, "physics:collisionEnabled", reason)

    def _part(self, joint: Joint) -> None:
        """Keep what a joint connects apart; on its world side the colliders at or below the prim that it names."""
        if joint.body0 and joint.body1:
            self.exclude(self.body_names[joint.body0], self.body_names[joint.body1])
            return
        body, rel = (joint.body0, joint.desc.rel1) if joint.body0 else (joint.body1, joint.desc.rel0)
        if not str(rel) or f"{body}/".startswith(f"{rel}/"):  # the world, or a prim that stands for it
            return
        for i, collider in enumerate(self.colliders):
            if collider.home.path is None and f"{collider.path}/".startswith(f"{rel}/"):
                for k in self.of_body.get(self.body_names[str(body)], ()):
                    self._forbid(i, k)

    def articulations(self) -> None:
        for path in self.parsed.articulations:
            prim = self.parsed.prim(path)
            enabled = dialects.resolve(self.parsed, dialects.ARTICULATION, "self-collision", prim)
            if enabled is not None and not enabled:
                for a, b in combinations(self._links(path), 2):
                    self.exclude(self.body_names[a], self.body_names[b], switch=True)

    def _links(self, root: str) -> list[str]:
        """Bodies of the articulation at prim `root`: those below it, with everything their joints reach."""
        desc = self.parsed.articulations[root]
        seeds = [str(p) for p in desc.articulatedBodies if str(p) in self.forest.links]
        seeds += [p for p in self.forest.links if p == root or p.startswith(f"{root}/")]
        found: dict[str, None] = {}
        for seed in seeds:
            if seed not in found:
                found.update(dict.fromkeys(self.forest.component(seed)))
        return list(found)

    def filtered_pairs(self) -> None:
        for prim in self.parsed.prims:
            if not prim.HasAPI(UsdPhysics.FilteredPairsAPI):
                continue
            for target in UsdPhysics.FilteredPairsAPI(prim).GetFilteredPairsRel().GetForwardedTargets():
                if not self.parsed.prim(target):
                    raise self.parsed.fail(prim, "physics:filteredPairs", f"no prim at <{target}>")
                self._filter(str(prim.GetPath()), str(target))

    def _members(self, path: str) -> tuple[list[str], list[int]]:
        """What a filter's end stands for: MuJoCo bodies, or single colliders."""
        if path in self.index:
            return [], [self.index[path]]
        if path in self.parsed.articulations and path not in self.body_names:
            return [self.body_names[p] for p in self._links(path)], []
        if path in self.body_names:
            return [self.body_names[path]], []
        return [], [i for p, i in self.index.items() if p.startswith(f"{path}/")]

    def _filter(self, a: str, b: str) -> None:
        (bodies_a, shapes_a), (bodies_b, shapes_b) = self._members(a), self._members(b)
        for x in bodies_a:
            for y in bodies_b:
                self.exclude(x, y)
        if not shapes_a and not shapes_b:
            return
        for x in shapes_a or [i for name in bodies_a for i in self.of_body.get(name, ())]:
            for y in shapes_b or [i for name in bodies_b for i in self.of_body.get(name, ())]:
                self._forbid(x, y)

    def _forbid(self, x: int, y: int) -> None:
        if x != y:
            self.pairs.add((min(x, y), max(x, y)))

    def groups(self) -> None:
        if not self.parsed.groups:
            return
        table = UsdPhysics.CollisionGroup.ComputeCollisionGroupTable(self.parsed.stage)
        memberships = self._memberships()
        grouped = [i for i, groups in enumerate(memberships) if groups]
        for x, y in combinations(grouped, 2):
            if not all(table.IsCollisionEnabled(g, h) for g in memberships[x] for h in memberships[y]):
                self._forbid(x, y)

    def _memberships(self) -> list[list[str]]:
        """Groups of each collider: those that its own path belongs to, and those that list the prim it inherits from.

        A collection that expands its prims has the shapes below as members anyway.
        """
        queries = {}
        for path in self.parsed.groups:
            collection = Usd.CollectionAPI(self.parsed.prim(path), "colliders")
            if collection.GetExpansionRuleAttr().Get() == Usd.Tokens.explicitOnly:
                queries[path] = collection.ComputeMembershipQuery()
        found = []
        for collider in self.colliders:
            groups = dict.fromkeys(str(group) for group in collider.desc.collisionGroups)
            inherited = self.parsed.inherited.get(collider.path)
            if inherited:
                owner = Sdf.Path(inherited.owner)
                groups.update(dict.fromkeys(path for path, query in queries.items() if query.IsPathIncluded(owner)))
            found.append(list(groups))
        return found

    def write(self, spec: mujoco.MjSpec) -> None:
        self._drop_covered()
        self._note_welds()
        self._write_bits()
        for (a, b), switch in self.bodies.items():
            exclude = spec.add_exclude(bodyname1=a, bodyname2=b)
            if switch:
                exclude.name = f"{SELF_COLLISION}{a}:{b}"

    def _note_welds(self) -> None:
        """Note the bodies that MuJoCo keeps apart by itself: those welded to the body that another is jointed to."""
        for path, link in self.forest.links.items():
            parent = link.parent
            if parent is None or _welded(link) or self.body_names[path] not in self.of_body:
                continue
            for other in self._welded_to(parent):
                a, b = sorted((self.body_names[path], self.body_names[other]))
                if self.body_names[other] in self.of_body and (a, b) not in self.bodies:
                    reason = f"MuJoCo never collides a body with one welded to its tree parent: <{other}>"
                    self.parsed.report.approximate(path, "physics:collisionEnabled", reason)

    def _welded_to(self, path: str) -> list[str]:
        """Other bodies that move as one with a body; none where they are welded to the world."""
        link = self.forest.links[path]
        while _welded(link) and link.parent:
            link = self.forest.links[link.parent]
        if _welded(link) or (not link.edges and not link.free):
            return []
        stack, found = [link], []
        while stack:
            link = stack.pop()
            found.append(link.path)
            stack.extend(child for child in link.children if _welded(child))
        return [other for other in found if other != path]

    def _drop_covered(self) -> None:
        """Turn rules that cover every pair of two bodies' colliders into one exclude."""
        count: dict[tuple[str, str], int] = {}
        owner = [c.home.body.name for c in self.colliders]
        for x, y in self.pairs:
            a, b = sorted((owner[x], owner[y]))
            count[a, b] = count.get((a, b), 0) + 1
        for (a, b), number in count.items():
            if a != b and number == len(self.of_body[a]) * len(self.of_body[b]):
                self.exclude(a, b)
        # A pair that only a switch covers stays: `enabled_self_collisions` may take the switch's exclude away.
        self.pairs = {
            (x, y)
            for x, y in self.pairs
            if owner[x] != owner[y] and self.bodies.get((min(owner[x], owner[y]), max(owner[x], owner[y])), True)
        }

    def _write_bits(self) -> None:
        if not self.pairs:
            return
        self._keep_authored_bits()
        rows: dict[int, set[int]] = {}
        for x, y in self.pairs:
            rows.setdefault(x, set()).add(y)
            rows.setdefault(y, set()).add(x)
        classes: dict[frozenset[int], list[int]] = {}
        for i in sorted(rows):
            classes.setdefault(frozenset(rows[i]), []).append(i)
        if len(classes) > BITS:
            for x, _ in sorted(self.pairs):
                reason = f"{len(classes)} classes of contact rules; MuJoCo has bits for {BITS}"
                self.parsed.report.ignore(self.colliders[x].path, "physics:filteredPairs", reason)
            return
        self.parsed.report.contact_classes = len(classes)
        members = list(classes.values())
        for i, collider in enumerate(self.colliders):
            if _never_touches(collider):
                continue
            own = next((bit for bit, group in enumerate(members, start=1) if i in group), 0)
            affinity = ALL_BITS
            if own:
                for bit, group in enumerate(members, start=1):
                    if rows[i] & set(group):
                        affinity &= ~(1 << bit)
            for geom in collider.geoms:
                geom.contype, geom.conaffinity = 1 << own, affinity

    def _keep_authored_bits(self) -> None:
        """Turn what `mjc:contype` and `mjc:conaffinity` forbid within the asset into rules like the others.

        A collider with both zero touches nothing and keeps them.
        """
        masks = [(c.geoms[0].contype, c.geoms[0].conaffinity) for c in self.colliders]
        authored = [i for i, c in enumerate(self.colliders) if masks[i] != (1, 1) and not _never_touches(c)]
        for x in authored:
            reason = "replaced by equivalent bits, together with the asset's other contact rules"
            self.parsed.report.approximate(self.colliders[x].path, "mjc:contype", reason)
            for y, (contype, conaffinity) in enumerate(masks):
                if not (masks[x][0] & conaffinity or contype & masks[x][1]) and not _never_touches(self.colliders[y]):
                    self._forbid(x, y)


def _welded(link: Link) -> bool:
    return bool(link.edges) and all(edge.joint.kind == "fixed" for edge in link.edges)


def _never_touches(collider: Collider) -> bool:
    return not (collider.geoms[0].contype or collider.geoms[0].conaffinity)


def separate_classes(spec: mujoco.MjSpec, classes: int, scene: mujoco.MjSpec) -> None:
    """Renumber an asset's classes of contact rules, so that those of the scene's other assets do not hold for it.

    Args:
        spec: the asset, changed in place.
        classes: how many it has (:attr:`ImportReport.contact_classes`).
        scene: what it will be attached to.

    Raises:
        ConfigError: there are not enough bits.
    """
    by = max((int(geom.contype).bit_length() - 1 for geom in scene.geoms), default=0)
    if not classes or by <= 0:
        return
    if classes + by > BITS:
        raise ConfigError(
            f"the assets of the scene have {classes + by} classes of contact rules (collision groups, filtered pairs); "
            f"MuJoCo has bits for {BITS}"
        )
    own = ((1 << classes) - 1) << 1
    for geom in spec.geoms:
        if geom.conaffinity & ~own & ALL_BITS != ALL_BITS & ~own:
            continue  # not of a rule: no such geom has bits of its own choice
        forbidden = own & ~geom.conaffinity
        geom.conaffinity = ALL_BITS & ~(forbidden << by)
        if geom.contype & own:
            geom.contype <<= by
