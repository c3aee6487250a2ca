"""Make the type stubs in ``typings/`` from the installed mujoco and usd-core.

Both are compiled and ship no types. The published stub packages do not fit: types-usd is of USD 24.5 and takes no
schema class in ``prim.IsA``; mujoco-stubs is of MuJoCo 3 and takes no array where the bindings take a sequence.

Only the modules' names that ``source`` and ``scripts`` use are written, with every attribute of their classes, and
what those refer to. MuJoCo's types are those of its own signatures. USD has no signatures at run time: names are
read from it, results are those of the tables in ``stubs_of_usd.py``. Run it after an upgrade or with a new name::

    python scripts/maintainers/make_stubs.py

"""

from __future__ import annotations

import ast
import shutil
from collections.abc import Iterable
from pathlib import Path

import stubs_of_mujoco
import stubs_of_usd

ROOT = Path(__file__).resolve().parents[2]


def chains(folders: Iterable[Path], roots: set[str]) -> set[tuple[str, ...]]:
    """Dotted names below ``roots`` in the Python files of ``folders``, e.g. ``("Usd", "Prim")``."""
    found = set()
    for path in sorted(file for folder in folders for file in folder.rglob("*.py")):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            names: list[str] = []
            while isinstance(node, ast.Attribute):
                names.insert(0, node.attr)
                node = node.value
            if names and isinstance(node, ast.Name) and node.id in roots:
                found.add((node.id, *names))
    return found


def make(folder: Path) -> None:
    """Write the stubs of both libraries into ``folder``, in place of what is there."""
    if folder.exists():
        shutil.rmtree(folder)
    used = chains([ROOT / "source", ROOT / "scripts"], {"mujoco", *stubs_of_usd.MODULES})
    files = {
        **stubs_of_mujoco.stubs({chain[1] for chain in used if chain[0] == "mujoco"}),
        **stubs_of_usd.stubs({chain[:2] for chain in used if chain[0] != "mujoco"}),
    }
    for name, text in files.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    make(ROOT / "typings")
