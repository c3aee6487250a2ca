"""Indices of joints and bodies in Isaac Lab's order and in the engine's."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field

import mujoco

from lift_lab.usd import ImportReport
from lift_lab.utils.errors import ConfigError, quote

INDEX_ORDERS = ("breadth_first", "engine")
"""Values of ``ArticulationCfg.index_order``."""


def check_index_order(kind: object, path: str) -> None:
    """Check a value of ``ArticulationCfg.index_order``.

    Args:
        kind: the value.
        path: where it is set, for the message.

    Raises:
        ConfigError: no such order.
    """
    if kind not in INDEX_ORDERS:
        raise ConfigError(f"{path}: there is no order '{kind}'; choose {quote(INDEX_ORDERS)}")


@dataclass(frozen=True)
class IndexOrder:
    """Places of an articulation's bodies and joints by name; names without a place keep their order, after the others.

    Without any place everything keeps the engine's order, which is depth first.
    """

    bodies: dict[str, int] = field(default_factory=dict)
    joints: dict[str, int] = field(default_factory=dict)
    stage_paths: dict[str, str] | None = None
    """Path of each body below the asset's prim, in the order of the stage; None for the engine's order."""

    def body(self, name: str) -> int:
        """Place of a body, to sort by."""
        return self.bodies.get(name, len(self.bodies))

    def joint(self, name: str) -> int:
        """Place of a joint, to sort by."""
        return self.joints.get(name, len(self.joints))


def breadth_first_order(spec: mujoco.MjSpec, report: ImportReport | None) -> IndexOrder:
    """PhysX's order, from the import report; where there is none, level by level in the spec's order of children.

    Args:
        spec: the articulation alone.
        report: of the USD import, None for an articulation of another source.
    """
    if report is not None:
        root = f"/{report.default_prim}"
        paths = {name: report.prim_paths.get(name, f"/{name}").removeprefix(root) for name in report.bodies_on_stage}
        return IndexOrder(_places(report.bodies_breadth_first), _places(report.joints_breadth_first), paths)
    bodies: list[mujoco.MjsBody] = []
    for root in spec.worldbody.bodies:
        level = [root]
        while level:
            bodies += level
            level = [child for body in level for child in body.bodies]
    joints = [joint.name for body in bodies for joint in body.joints]
    return IndexOrder(_places(body.name for body in bodies), _places(joints), {})


def _places(names: Iterable[str]) -> dict[str, int]:
    return {name: i for i, name in enumerate(names)}
