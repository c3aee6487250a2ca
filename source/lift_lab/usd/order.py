"""Orders of bodies and joints other than the model's: PhysX's, which is breadth first, and that of the stage."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from lift_lab.usd.joints import BuiltDof
from lift_lab.usd.parse import ParsedStage
from lift_lab.usd.report import ImportReport
from lift_lab.usd.tree import Forest, Link

_AXES = ("rotX", "rotY", "rotZ", "transX", "transY", "transZ")
"""PhysX's order of the axes of one joint (``PxArticulationAxis``)."""


def fill_orders(
    report: ImportReport, parsed: ParsedStage, forest: Forest, dofs: Sequence[BuiltDof], body_names: Mapping[str, str]
) -> None:
    """Fill the report's lists of bodies and joints in PhysX's order, and of bodies in the stage's.

    PhysX creates the links of an articulation joint by joint, in the order of the joint prims on the stage. Then it
    numbers them breadth first (``createLinkHierarchy`` of omni.physx, ``NpScene::addArticulationInternal``). So the
    children of a link follow the order of their joints. The side from which a joint was authored has no effect. Every
    tree keeps its root first. What is in the model alone (carriers of loop joints, static geometry) comes last.

    Args:
        report: with its lists in model order; changed in place.
        parsed: the stage.
        forest: the bodies' trees.
        dofs: all scalar joints.
        body_names: body name by prim path.
    """
    place = {path: i for i, path in enumerate(parsed.joints)}
    of_edge: dict[int, list[BuiltDof]] = {}
    for dof in dofs:
        of_edge.setdefault(id(dof.edge), []).append(dof)

    def first_joint(link: Link) -> int:
        return min(place[edge.joint.path] for edge in link.edges)

    bodies: list[str] = []
    joints: list[str] = []
    for root in forest.roots:
        level = [root]
        while level:
            for link in level:
                bodies.append(body_names[link.path])
                found = [dof for edge in link.edges for dof in of_edge.get(id(edge), [])]
                found.sort(key=lambda dof: (place[dof.joint.path], _axis(dof)))
                joints += [dof.name for dof in found]
            level = [child for link in level for child in sorted(link.children, key=first_joint)]
    report.bodies_breadth_first = _completed(bodies, report.bodies)
    report.joints_breadth_first = _completed(joints, report.joints)
    on_stage = sorted(body_names, key=lambda path: parsed.order[path])
    report.bodies_on_stage = _completed([body_names[path] for path in on_stage], report.bodies)


def _axis(dof: BuiltDof) -> int:
    return next((_AXES.index(token) for token in dof.dof.tokens if token in _AXES), len(_AXES))


def _completed(names: list[str], model_order: list[str]) -> list[str]:
    """``names``, and after them what else there is, in model order."""
    there = set(names)
    return names + [name for name in model_order if name not in there]
