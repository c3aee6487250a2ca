"""Which pairs may touch: collision groups, filtered pairs, joints and articulations.

Rules between whole bodies become excludes. Rules between colliders (groups, pairs of single colliders) become bits of
contype and conaffinity: one bit per class of colliders with the same rules, bit 0 for those without any.
"""

from __future__ import annotations

from itertools import combinations

import mujoco
from pxr import UsdPhysics

from lift_lab.usd import dialects
from lift_lab.usd.geoms import Collider
from lift_lab.usd.parse import ParsedStage
from lift_lab.usd.tree import Forest

SELF_COLLISION = "self_collision:"
"""Start of the names of the excludes that an articulation's self-collision switch makes."""
_BITS = 31
"""Classes that fit beside bit 0 (contype is a signed 32-bit integer)."""


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
            sides = ((joint.body0, joint.desc.rel0), (joint.body1, joint.desc.rel1))
            first, second = (self.body_names[body] if body else self._static(str(rel)) for body, rel in sides)
            if not joint.desc.collisionEnabled:
                if first and second:
                    self.exclude(first, second)
            elif joint.body0 and joint.body1:
                reason = "MuJoCo never collides a body with its tree parent"
                self.parsed.report.approximate(joint.path, "physics:collisionEnabled", reason)

    def _static(self, path: str) -> str | None:
        """Static body of the colliders at or below the prim that a joint names on its world side."""
        below = (c for c in self.colliders if c.home.path is None and f"{c.path}/".startswith(f"{path}/"))
        return next((c.home.body.name for c in below), None) if path else None

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
        memberships = [[str(g) for g in c.desc.collisionGroups] for c in self.colliders]
        grouped = [i for i, groups in enumerate(memberships) if groups]
        for x, y in combinations(grouped, 2):
            if not all(table.IsCollisionEnabled(g, h) for g in memberships[x] for h in memberships[y]):
                self._forbid(x, y)

    def write(self, spec: mujoco.MjSpec) -> None:
        self._drop_covered()
        self._write_bits()
        for (a, b), switch in self.bodies.items():
            exclude = spec.add_exclude(bodyname1=a, bodyname2=b)
            if switch:
                exclude.name = f"{SELF_COLLISION}{a}:{b}"

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
        self.pairs = {
            (x, y)
            for x, y in self.pairs
            if owner[x] != owner[y] and tuple(sorted((owner[x], owner[y]))) not in self.bodies
        }

    def _write_bits(self) -> None:
        rows: dict[int, set[int]] = {}
        for x, y in self.pairs:
            rows.setdefault(x, set()).add(y)
            rows.setdefault(y, set()).add(x)
        classes: dict[frozenset[int], list[int]] = {}
        for i in sorted(rows):
            classes.setdefault(frozenset(rows[i]), []).append(i)
        if len(classes) > _BITS:
            for x, _ in sorted(self.pairs):
                reason = f"{len(classes)} classes of contact rules; MuJoCo has bits for {_BITS}"
                self.parsed.report.ignore(self.colliders[x].path, "physics:filteredPairs", reason)
            return
        members = list(classes.values())
        everyone = 1
        for bit in range(1, len(members) + 1):
            everyone |= 1 << bit
        for i, collider in enumerate(self.colliders):
            own = next((bit for bit, group in enumerate(members, start=1) if i in group), 0)
            affinity = everyone
            if own:
                for bit, group in enumerate(members, start=1):
                    if rows[i] & set(group):
                        affinity &= ~(1 << bit)
            if not members:
                return
            for geom in collider.geoms:
                geom.contype, geom.conaffinity = 1 << own, affinity
