"""What a class says about its saved state.

A training saves the attributes of an environment's managers, terms, assets and sensors, so that it can be continued
exactly. A class has a say in that:

- ``unsaved_attributes: ClassVar[frozenset[str]]``: attributes that are no part of the state, because they can be
  computed again or belong to the process (an open file, a window).
- ``on_state_loaded(self) -> None``: called once the attributes have their saved values: forget what was computed from
  other ones.
- ``state_dict(self) -> dict`` and ``load_state_dict(self, state) -> None``, both or neither: the object saves itself,
  and its attributes are not looked at. The dictionary holds tensors, arrays, numbers, text and containers of these.
"""

from __future__ import annotations

from typing import Any


def unsaved_attributes(value: Any) -> frozenset[str]:
    """Names of the attributes of an object that its class and the classes above it leave out of its state."""
    names: set[str] = set()
    for cls in type(value).__mro__:
        names.update(vars(cls).get("unsaved_attributes", ()))
    return frozenset(names)
