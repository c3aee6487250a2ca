"""A scene entity with a selection of its joints and bodies, resolved from names to indices once."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple

from lift_lab.utils import MISSING, ConfigBase, configclass
from lift_lab.utils.errors import ConfigError, suggest
from lift_lab.utils.ranges import WHOLE, Ranges

if TYPE_CHECKING:
    from lift_lab.scene import InteractiveScene


class _Selector(NamedTuple):
    """How one kind of part is selected: fields of the config and the entity's matching attributes."""

    names_field: str
    ids_field: str
    find: str
    names: str


_SELECTORS = (
    _Selector("joint_names", "joint_ids", "find_joints", "joint_names"),
    _Selector("fixed_tendon_names", "fixed_tendon_ids", "find_fixed_tendons", "fixed_tendon_names"),
    _Selector("body_names", "body_ids", "find_bodies", "body_names"),
    _Selector("object_collection_names", "object_collection_ids", "find_objects", "object_names"),
)


@configclass
class SceneEntityCfg(ConfigBase):
    """A scene entity that a term reads, and which parts of it.

    Each part is selected by names (regular expressions that must match a name in full) or by ids, not both.
    Source: Isaac Lab's ``SceneEntityCfg``.
    """

    name: str = MISSING
    """Name of the entity in the scene."""

    joint_names: str | list[str] | None = None
    """Joints by name; None selects by ``joint_ids``."""

    joint_ids: list[int] | slice = slice(None)
    """Joints by index, filled from the names. A list, or ``slice(None)`` for all joints in the entity's
    order."""

    fixed_tendon_names: str | list[str] | None = None
    """Fixed tendons by name."""

    fixed_tendon_ids: list[int] | slice = slice(None)
    """Fixed tendons by index."""

    body_names: str | list[str] | None = None
    """Bodies by name."""

    body_ids: list[int] | slice = slice(None)
    """Bodies by index."""

    object_collection_names: str | list[str] | None = None
    """Objects of a collection by name."""

    object_collection_ids: list[int] | slice = slice(None)
    """Objects of a collection by index."""

    preserve_order: bool = False
    """Whether the ids follow the order of the names given, and not the entity's."""

    _ranges: ClassVar[Ranges] = {"joint_ids fixed_tendon_ids body_ids object_collection_ids": WHOLE}

    @property
    def selects_by_name(self) -> bool:
        """Whether any part is selected by name, so that :meth:`resolve` has something to look up."""
        return any(getattr(self, selector.names_field) is not None for selector in _SELECTORS)

    def resolve(self, scene: InteractiveScene) -> None:
        """Turn names into ids, or ids into names. A second call changes nothing.

        Raises:
            ConfigError: the scene has no such entity, the entity has no such parts, or an id is out of range. Also a
                pattern that matches nothing, two patterns that match one name, and names that disagree with ids.
        """
        entities = list(scene.keys())
        if self.name not in entities:
            raise ConfigError(f"the scene has no entity '{self.name}': {suggest(self.name, entities)}")
        for selector in _SELECTORS:
            names, ids = getattr(self, selector.names_field), getattr(self, selector.ids_field)
            if names is not None or not _selects_all(ids):
                self._resolve_part(scene[self.name], selector, names, ids)

    def _resolve_part(self, entity: Any, selector: _Selector, names: Any, ids: Any) -> None:
        if not hasattr(entity, selector.find):
            raise ConfigError(
                f"the entity '{self.name}' is a {type(entity).__name__}, which cannot be selected from by"
                f" {selector.names_field} or {selector.ids_field}"
            )
        available: Sequence[str] = getattr(entity, selector.names)
        ids = [ids] if isinstance(ids, int) else ids
        beyond = [] if isinstance(ids, slice) else [i for i in ids if not -len(available) <= i < len(available)]
        if beyond:
            raise ConfigError(
                f"the entity '{self.name}' has no {selector.ids_field} {beyond}: it has {len(available)}, "
                + ", ".join(f"{i} = '{name}'" for i, name in enumerate(available[:12]))
            )
        if names is None:
            setattr(self, selector.ids_field, ids)
            chosen = available[ids] if isinstance(ids, slice) else [available[i] for i in ids]
            setattr(self, selector.names_field, list(chosen))
            return
        names = [names] if isinstance(names, str) else list(names)
        setattr(self, selector.names_field, names)
        found = list(getattr(entity, selector.find)(names, preserve_order=self.preserve_order)[0])
        if _selects_all(ids):
            if found != list(range(len(available))):
                setattr(self, selector.ids_field, found)
            return
        setattr(self, selector.ids_field, ids)
        given = list(range(len(available)))[ids] if isinstance(ids, slice) else list(ids)
        if given != found and [available[i] for i in given] != names:  # an earlier call may have filled in names
            raise ConfigError(
                f"{selector.names_field}={names} of the entity '{self.name}' are ids {found}, but"
                f" {selector.ids_field} is {given}: give one of the two"
            )


def _selects_all(ids: Any) -> bool:
    return isinstance(ids, slice) and ids == slice(None)
