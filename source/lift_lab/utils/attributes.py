"""Objects whose errors for a wrong attribute list the attributes that they have."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, ClassVar

from .errors import UnknownAttributeError, suggest
from .saved_state import Stateful


class SuggestsAttributes:
    """A wrong public attribute raises :class:`UnknownAttributeError`, one line with the nearest names.

    A config may give a term the wrong kind of asset. The error names the attribute and the asset.
    """

    def _described(self) -> str:
        """Start of the message, e.g. ``"'object' (RigidObject) has"``."""
        return f"{type(self).__name__} has"

    if not TYPE_CHECKING:  # a type checker would take every name for an attribute

        def __getattr__(self, name: str) -> Any:
            if name.startswith("_") or hasattr(type(self), name):  # in a property that fails, the error is its own
                return object.__getattribute__(self, name)
            names = [key for key in dir(self) if not key.startswith("_")]
            raise UnknownAttributeError(f"{self._described()} no '{name}'; {suggest(name, names)}")


class Entity(SuggestsAttributes, Stateful):
    """Something that a scene has by name: an asset or a sensor."""

    name: str = ""
    """The scene's name for it."""

    def _described(self) -> str:
        return f"'{self.name}' ({type(self).__name__}) has"


class EntityData(SuggestsAttributes, Stateful):
    """State of an asset, or readings of a sensor."""

    unsaved_attributes: ClassVar[frozenset[str]] = frozenset({"entity_name"})

    entity_name: str = ""
    """The scene's name for the asset or sensor."""

    def _described(self) -> str:
        return f"the data of '{self.entity_name}' ({type(self).__name__.removesuffix('Data')}) have"
