"""Isaac Lab's names that lift_lab does not have, and what to do instead.

The answers come from the table in :mod:`lift_lab.isaac.table` and from the modules of lift_lab themselves. A user's
files are not imported.
"""

from __future__ import annotations

import importlib
import re
from functools import cache
from types import ModuleType

from lift_lab.isaac.finder import names_of
from lift_lab.isaac.table import TABLE
from lift_lab.utils.errors import suggest

from .rename import PACKAGES

OTHER_ROOTS = {
    "carb": "Omniverse is not supported",
    "isaacsim": "Isaac Sim is not supported",
    "omni": "Omniverse is not supported",
    "isaaclab_contrib": "this package is not supported",
    "isaaclab_mimic": "this package is not supported",
}
"""Packages that Isaac Lab's files import and that do not exist here."""

_WORDS = {
    "kind": "URDF and MJCF",
    "cfg.asset_path": "them",
    "objects": "its objects",
    "instead": "use one asset",
}
"""Texts in place of names in the reasons of the table that are known only when an environment is made."""


def problem(module: str, name: str) -> str | None:
    """Return the reason why a name does not work in lift_lab; None if it does, or if it is none of Isaac Lab's.

    Args:
        module: module after the renaming.
        name: name in it, possibly with further ones behind dots; ``*`` for all, empty for the module itself.
    """
    root = module.partition(".")[0]
    if root in OTHER_ROOTS:
        return OTHER_ROOTS[root]
    if root not in PACKAGES:
        return None
    found = _load(module)
    if found is None:
        return None if _is_class_of(module) else _no_module(module)
    for part in name.split(".") if name not in ("", "*") else ():
        if (reason := reason_of(module, part)) is not None:
            return reason
        below = _load(f"{module}.{part}")
        if below is not None:
            module, found = f"{module}.{part}", below
        elif hasattr(found, part):  # what is behind it is an attribute of an object
            value = getattr(found, part)  # a package may pass on a name of the table
            return reason_of(getattr(value, "__module__", None) or "", part)
        elif getattr(found, "__missing__", None):
            return None
        else:
            return f"{module} has no such name; {suggest(part, _public(found))}"
    return None


def reason_of(module: str, name: str) -> str | None:
    """Return the text of the table of unsupported names for a name; None if it is not in the table."""
    row = module.removeprefix("lift_lab.")
    for entry in TABLE:
        if row in entry.modules and name in names_of(entry, row):
            text = re.sub(r"^'?\{[\w.]*prim_path\}'?: ", "", entry.reason)
            return re.sub(r"'?\{([\w.]+)\}'?", lambda match: {"name": name, **_WORDS}[match[1]], text)
    return None


def is_module(name: str) -> bool:
    """Whether lift_lab has a module of that name."""
    return name.partition(".")[0] in PACKAGES and _load(name) is not None


def names_in(module: str) -> set[str]:
    """Names that ``from module import *`` gives; empty if there is no such module."""
    found = _load(module)
    return set() if found is None else set(_public(found))


@cache
def _load(module: str) -> ModuleType | None:
    """A module of lift_lab; None if there is none of that name."""
    if not all(part.isidentifier() for part in module.split(".")):
        return None
    try:
        return importlib.import_module(module)
    except ModuleNotFoundError as error:
        if error.name is not None and error.name.partition(".")[0] not in PACKAGES:
            return _Unknown(module)  # it needs an optional package
        return None


class _Unknown(ModuleType):
    """Stands for a module that cannot be imported here."""

    __missing__ = True


def _is_class_of(module: str) -> bool:
    """Whether the last part is a name in a module, not a module."""
    parent, _, name = module.rpartition(".")
    found = _load(parent) if parent else None
    return found is not None and (hasattr(found, name) or reason_of(parent, name) is not None)


def _no_module(module: str) -> str:
    parts = module.split(".")
    while len(parts) > 1 and _load(".".join(parts[:-1])) is None:
        parts.pop()
    return f"there is no module {'.'.join(parts)}"


def _public(module: ModuleType) -> list[str]:
    return [name for name in getattr(module, "__all__", dir(module)) if not name.startswith("_")]
