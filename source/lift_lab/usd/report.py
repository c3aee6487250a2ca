"""Results of an import for the reader: the error that stops it and the report that it returns."""

from __future__ import annotations

import re
from collections import Counter
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from rich.table import Table

from lift_lab.utils.errors import LiftLabError

if TYPE_CHECKING:
    from lift_lab.usd.deformable import SoftBody


_NUMBERS = re.compile(r"-?\d[\d.e+-]*|<[^>]*>")
"""Numbers and prims in a reason: notes that differ in them alone are of one kind."""
_AXIS = re.compile(r":((rot|trans)?[XYZ]|angular|linear)\b")
_MOST_NAMED = 8
"""Most bodies that one line names."""


class UsdImportError(LiftLabError, ValueError):
    """A USD stage that cannot become a model. The message names the file, the prim and the attribute."""

    def __init__(self, source: str, prim_path: str = "", attribute: str = "", reason: str = "") -> None:
        self.source, self.prim_path, self.attribute, self.reason = source, prim_path, attribute, reason
        where = f"{source}: <{prim_path}>" if prim_path else source
        where = f"{where}.{attribute}" if attribute else where
        super().__init__(f"{where}: {reason}")


@dataclass(frozen=True)
class Note:
    """One remark about the stage: something that is ignored or approximated."""

    prim_path: str
    """Prim that the remark is about."""
    attribute: str
    """Attribute or API schema, empty for the prim as a whole."""
    reason: str
    """Reason in one line."""
    tuning: bool = False
    """True for settings of another engine's solver, and for pictures: they change no physical quantity, and `strict`
    passes them."""


@dataclass(frozen=True)
class OptionSource:
    """A simulation option that a stage sets, as its gravity or its time step."""

    prim_path: str
    """Prim of the physics scene."""
    attribute: str
    """Attribute that sets it."""
    field: str
    """Field of the spec's `option`."""
    bit: int = 0
    """The flag, where the field holds several."""


@dataclass
class ImportReport:
    """Report on an import: what was read from a stage, what was approximated and what was ignored."""

    path: str
    """File that was read, or the root layer's identifier."""
    default_prim: str = ""
    """Name of the stage's default prim, empty if it has none."""
    bodies: list[str] = field(default_factory=list)
    """Body names in model order, the world excluded."""
    joints: list[str] = field(default_factory=list)
    """Joint names in model order, free joints included."""
    actuators: list[str] = field(default_factory=list)
    """Actuator names in model order."""
    bodies_breadth_first: list[str] = field(default_factory=list)
    """Body names in PhysX's order: level by level, children in the order of their joints on the stage."""
    joints_breadth_first: list[str] = field(default_factory=list)
    """Joint names in PhysX's order: that of the bodies they move; free and ball joints last."""
    bodies_on_stage: list[str] = field(default_factory=list)
    """Body names in the order of their prims on the stage."""
    root_bodies: list[str] = field(default_factory=list)
    """Bodies that hang directly under the world."""
    articulation_roots: list[str] = field(default_factory=list)
    """Paths of the prims that carry PhysicsArticulationRootAPI."""
    soft_bodies: list[SoftBody] = field(default_factory=list)
    """Deformable bodies. They are not in the spec: see :mod:`lift_lab.usd.deformable`."""
    prim_paths: dict[str, str] = field(default_factory=dict)
    """Prim path of every body, by body name."""
    joint_velocity_limits: dict[str, float] = field(default_factory=dict)
    """Authored velocity limits in rad/s or m/s, by joint name."""
    initial_joint_pos: dict[str, float] = field(default_factory=dict)
    """Joint positions other than zero that the stage starts with, in rad or m, by joint name."""
    initial_ctrl: dict[str, float] = field(default_factory=dict)
    """Drive targets other than zero, in rad, m, rad/s or m/s, by actuator name."""
    keyframes: dict[str, str] = field(default_factory=dict)
    """Prim path of every keyframe, by name. A scene has none of them: its assets start from `init_state`."""
    loop_drives: dict[str, str] = field(default_factory=dict)
    """Joint by actuator name, of drives that act between the two bodies of a joint that closes a loop."""
    options: list[OptionSource] = field(default_factory=list)
    """Simulation options that the stage sets; a scene replaces them by those of `SimulationCfg`."""
    assumed_options: dict[str, str] = field(default_factory=dict)
    """Solver options that the stage does not set and that were set as scenes have them, with their values."""
    contact_classes: int = 0
    """Classes of colliders with contact rules of their own; each has a bit of contype, from bit 1 on."""
    without_collider: list[str] = field(default_factory=list)
    """Bodies that move and that nothing can touch. Neither they nor a body welded to them has a collider, not even one
    that is switched off. Frames without any shape in an articulation with colliders do not count."""
    ignored: list[Note] = field(default_factory=list)
    """Authored content that has no effect on the model."""
    approximated: list[Note] = field(default_factory=list)
    """Authored content that the model carries only inexactly."""
    dialects: dict[str, dict[str, int]] = field(default_factory=dict)
    """For each quantity read from a vendor schema: how many prims took it from which dialect."""

    def ignore(self, prim_path: object, attribute: str, reason: str, tuning: bool = False) -> None:
        """Record authored content that has no effect."""
        self.ignored.append(Note(str(prim_path), attribute, reason, tuning))

    def approximate(self, prim_path: object, attribute: str, reason: str, tuning: bool = False) -> None:
        """Record content that is carried over inexactly."""
        self.approximated.append(Note(str(prim_path), attribute, reason, tuning))

    def took(self, quantity: str, dialect: str) -> None:
        """Count one value of `quantity` read from `dialect`."""
        counts = self.dialects.setdefault(quantity, {})
        counts[dialect] = counts.get(dialect, 0) + 1

    def summary(self, ignored: bool = True) -> list[str]:
        """One line for each kind of physical loss, with how many prims it concerns and the first of them.

        Args:
            ignored: Whether authored content without effect counts too, or only what the model has inexactly.
        """
        lines = []
        for verb, notes in (("ignored", self.ignored if ignored else []), ("approximated", self.approximated)):
            kinds: dict[tuple[str, str], list[Note]] = {}
            for note in notes:
                if not note.tuning:
                    kind = (_AXIS.sub(":*", note.attribute), _NUMBERS.sub("", note.reason))
                    kinds.setdefault(kind, []).append(note)
            for (attribute, _), same in kinds.items():
                attribute = same[0].attribute if len({note.attribute for note in same}) == 1 else attribute
                paths = list(dict.fromkeys(note.prim_path for note in same))
                where = f"<{paths[0]}>" if len(paths) == 1 else f"{len(paths)} prims, the first <{paths[0]}>"
                lines.append(f"{verb} {attribute or 'prim'} on {where}: {same[0].reason}")
        if self.without_collider:
            number = len(self.without_collider)
            names = ", ".join(self.without_collider[:_MOST_NAMED])
            names += f" and {number - _MOST_NAMED} more" if number > _MOST_NAMED else ""
            bodies = "rigid body" if number == 1 else f"{number} rigid bodies"
            meant = "a collider that is switched off (collision_enabled=False) says that this is meant"
            lines.append(f"{bodies} without a collider, which nothing can touch: {names}; {meant}")
        return lines

    def table(self) -> Table:
        """Render the report; notes that differ only in their prim are folded into one row."""
        table = Table(title=f"USD import: {self.path}", show_lines=False)
        for column in ("", "what", "where", "detail"):
            table.add_column(column, overflow="fold")
        for kind, names in (("body", self.bodies), ("joint", self.joints), ("actuator", self.actuators)):
            table.add_row("read", f"{len(names)} {kind}", ", ".join(names[:4]), "..." if len(names) > 4 else "")
        table.add_row("read", "roots", ", ".join(self.root_bodies[:4]), ", ".join(self.articulation_roots[:4]))
        for quantity, counts in sorted(self.dialects.items()):
            table.add_row("read", quantity, "", ", ".join(f"{d} x{n}" for d, n in sorted(counts.items())))
        if self.assumed_options:
            values = ", ".join(f"{name} {value}" for name, value in self.assumed_options.items())
            table.add_row("set", "options", values, "as scenes set them; the stage does not")
        if self.without_collider:
            table.add_row("read", f"{len(self.without_collider)} without collider", ", ".join(self.without_collider))
        for kind, notes in (("approximated", self.approximated), ("ignored", self.ignored)):
            groups = Counter((note.attribute, note.reason) for note in notes)
            first = {(n.attribute, n.reason): n.prim_path for n in reversed(notes)}
            for (attribute, reason), count in groups.items():
                where = first[attribute, reason] + (f" and {count - 1} more" if count > 1 else "")
                table.add_row(kind, attribute, where, reason)
        return table
