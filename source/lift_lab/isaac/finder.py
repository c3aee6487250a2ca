"""The import hook that makes the modules of the table, and the attributes that real modules take from it.

A module that has a file is never changed, and nothing is loaded before a name is used.
"""

from __future__ import annotations

import importlib
import os
import sys
import types
from collections.abc import Callable, Iterable, Sequence
from importlib.machinery import ModuleSpec, PathFinder
from typing import TYPE_CHECKING, Any

from .table import TABLE, Unsupported

if TYPE_CHECKING:
    from importlib.abc import Loader
else:
    Loader = object  # importing it costs more than all of this module


def names_of(entry: Unsupported, module: str) -> set[str]:
    """Names of one row of the table, with ``*`` written out."""
    if entry.modules[module] != "*":
        return {*entry.modules[module].split()}
    return {name for row in entry.modules if row.startswith(f"{module}.") for name in names_of(entry, row)}


_FOLDER = os.path.dirname(__file__)

MODULES: dict[str, dict[str, str]] = {}
"""Module -> its names, each with the file of this package that defines it."""
for _entry in TABLE:
    for _row in _entry.modules:
        MODULES.setdefault(f"lift_lab.{_row}", {}).update(dict.fromkeys(sorted(names_of(_entry, _row)), _entry.file))


class TableFinder:
    """Finds modules that only the table has. Every one is a package, so that a wrong name in it comes here, too."""

    @classmethod
    def find_spec(cls, fullname: str, path: Sequence[str] | None = None, target: Any = None) -> ModuleSpec | None:
        """The module's spec; None for one that has a file, or that is not in the table.

        Raises:
            ModuleNotFoundError: a module of the table has nothing of this name.
        """
        parent, _, name = fullname.rpartition(".")
        known = fullname in MODULES
        if not known and not isinstance(getattr(sys.modules.get(parent), "__loader__", None), TableLoader):
            return None
        real = PathFinder.find_spec(fullname, path)
        if real is not None and real.origin is not None:  # not an empty folder that an older version left
            return None
        if not known:
            raise _wrong_name(ModuleNotFoundError, parent, name, MODULES[parent])
        file = next(iter(MODULES[fullname].values()), "table")
        spec = ModuleSpec(fullname, TableLoader(), origin=os.path.join(_FOLDER, f"{file}.py"), is_package=True)
        spec.submodule_search_locations = [os.path.join(folder, name) for folder in path or ()]
        return spec


class TableLoader(Loader):
    """Makes a module whose attributes come from the table."""

    def create_module(self, spec: ModuleSpec) -> None:
        """Leave it to Python."""

    def exec_module(self, module: types.ModuleType) -> None:
        """Give the module its attributes."""
        module.__doc__ = "Names of Isaac Lab that are not supported: see lift_lab.isaac."
        module.__file__ = module.__spec__.origin if module.__spec__ else None
        vars(module).update(zip(("__getattr__", "__dir__", "__all__"), attributes_of(module.__name__), strict=True))


def install() -> None:
    """Put the finder before Python's own, which would take an empty folder for a package."""
    sys.meta_path.insert(0, TableFinder)


def attributes_of(module: str) -> tuple[Callable[[str], Any], Callable[[], list[str]], list[str]]:
    """``__getattr__``, ``__dir__`` and ``__all__`` of a module with names of the table.

    A real module calls it last, so its own names are found before those of the table.

    Args:
        module: full name of the module, which is being imported.
    """
    namespace = vars(sys.modules[module])
    hidden = ("TYPE_CHECKING", "annotations", "attributes_of")
    own = [
        name
        for name, value in namespace.items()
        if not (name.startswith("_") or name in hidden or isinstance(value, types.ModuleType))
    ]
    names = list(dict.fromkeys([*namespace.get("__all__", own), *MODULES[module]]))

    def __getattr__(name: str) -> Any:
        if name in MODULES[module]:
            value = getattr(importlib.import_module(f"{__package__}.{MODULES[module][name]}"), name)
        elif f"{module}.{name}" in MODULES:
            value = importlib.import_module(f"{module}.{name}")
        else:
            raise _wrong_name(AttributeError, module, name, names)
        namespace[name] = value
        return value

    def __dir__() -> list[str]:
        return sorted({*namespace, *names})

    return __getattr__, __dir__, names


def _wrong_name(kind: type[Exception], module: str, name: str, names: Iterable[str]) -> Exception:
    if name.startswith("_"):  # Python looks for many of these
        return kind(f"module '{module}' has no '{name}'")
    from lift_lab.utils.errors import suggest

    below = [row.rpartition(".")[2] for row in MODULES if row.rpartition(".")[0] == module]
    return kind(f"module '{module}' has no '{name}'; {suggest(name, [*names, *below])}")


def place(file: str) -> None:
    """Give what a file of this package defines the module path of Isaac Lab, which pickles and written configs name.

    Args:
        file: full name of the file's module. Of several modules that have a name, the deepest counts.
    """
    short = file.rpartition(".")[2]
    for module in sorted(MODULES, key=lambda module: module.count(".")):
        for name, definitions in MODULES[module].items():
            value = getattr(sys.modules[file], name) if definitions == short else None
            if getattr(value, "__name__", None) == name:  # not a second name of something
                _move(value, module)


def _move(value: Any, module: str) -> None:
    if isinstance(value, (type, types.FunctionType)):
        value.__module__ = module
        for inner in vars(value).values():
            if getattr(inner, "__qualname__", "").startswith(f"{value.__qualname__}."):
                _move(inner, module)
