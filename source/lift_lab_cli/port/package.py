"""Port a folder of Isaac Lab files: read all of it, rename, find what is not supported, and write the result."""

from __future__ import annotations

import contextlib
import dataclasses
import os
import shutil
import tempfile
from pathlib import Path, PurePosixPath

from lift_lab.utils.errors import ConfigError, FileError

from .rename import PACKAGES, Source, port
from .support import is_module, names_in, problem, reason_of

_PYTHON = (".py", ".pyi")
_TEXT = (".toml", ".yaml", ".yml", ".cfg", ".json", ".md", ".rst", ".txt")
_LEFT_OUT = ("__pycache__", ".git", ".hg", ".svn")

_ONLY_IN_3 = (
    *("isaaclab_newton", "isaaclab_physx", "isaaclab_ov", "isaaclab_ppisp", "isaaclab_teleop", "isaaclab_visualizers"),
    *("isaaclab_experimental", "lift_lab.physics", "lift_lab.cloner", "lift_lab.utils.module"),
    *("lift_lab_tasks.core", "lift_lab_tasks.contrib"),
)
"""Modules, after the renaming, that only Isaac Lab 3.0 has."""


@dataclasses.dataclass(frozen=True)
class Remark:
    """Remark on a line of a file."""

    file: PurePosixPath
    line: int
    text: str


class Package:
    """The files of a folder, ported in memory."""

    def __init__(self, folder: Path):
        """Read and port a folder.

        Args:
            folder: the folder; nothing in it is run or changed.

        Raises:
            FileError: there is no such folder, or it holds no Python file.
            ConfigError: its files are written for Isaac Lab 3.0.
        """
        if not folder.is_dir():
            kind = "is a file: give its folder" if folder.exists() else "does not exist"
            raise FileError(f"the folder '{folder}' {kind}")
        self.folder, self._name = folder, folder.resolve().name
        self.sources: dict[PurePosixPath, Source] = {}
        """Python files by their path in the folder."""
        self.others: list[PurePosixPath] = []
        """All other files."""
        self.left_out: dict[PurePosixPath, str] = {}
        """What is not copied, and what it is: links to folders, links to nothing, pipes."""
        for place, folders, files in os.walk(folder):
            inside = Path(place).relative_to(folder)
            links = [name for name in folders if Path(place, name).is_symlink()]
            self.left_out |= {PurePosixPath(inside, name): "link to a folder" for name in links}
            folders[:] = sorted({*folders} - {*links, *_LEFT_OUT})
            for name in sorted(files):
                path = PurePosixPath(inside, name)
                if not (folder / path).is_file():
                    self.left_out[path] = "link to nothing" if (folder / path).is_symlink() else "not a regular file"
                elif name.endswith(_PYTHON):
                    self.sources[path] = port((folder / path).read_bytes())
                elif not name.endswith(".pyc"):
                    self.others.append(path)
        if not self.sources:
            raise FileError(f"the folder '{folder}' holds no Python file")
        self._refuse_3()

    def _refuse_3(self) -> None:
        for path, source in self.sources.items():
            for use in source.uses:
                found = [name for name in (use.module, f"{use.module}.{use.name}") if _is_in(name, _ONLY_IN_3)]
                if found:
                    place = f"{self.folder / path}:{use.line}"
                    old = found[0].replace("lift_lab", "isaaclab")
                    raise ConfigError(
                        f"{place} uses {old} of Isaac Lab 3.0, which is not supported yet: nothing written"
                    )

    def unsupported(self) -> list[Remark]:
        """Uses of names that lift_lab does not have, each with what to do instead."""
        found: dict[tuple[PurePosixPath, int, str], Remark] = {}
        for path, source in self.sources.items():
            for use in source.uses:
                module = self._local(path, use.module)
                if module is not None:
                    text = self._problem_of_local(module, use.name)
                else:  # what is taken from a module that is missing is said once, at its import
                    text = problem(use.module, use.name) if use.is_import or is_module(use.module) else None
                    own = self._find(use.module.split(".")) if text is not None else None
                    if own is not None and own != path:
                        text = f"{text}, but the folder has {own}: import it by the name of your own package"
                if text is not None:
                    name = ".".join(part for part in (use.module.lstrip("."), use.name) if part)
                    found.setdefault((path, use.line, name), Remark(path, use.line, f"{name}: {text}"))
        return sorted(found.values(), key=lambda remark: (remark.file, remark.line))

    def mentions(self) -> list[Remark]:
        """Lines of other text files that name Isaac Lab's packages."""
        found = []
        for path in self.others:
            if path.suffix in _TEXT:
                text = (self.folder / path).read_text(errors="replace")
                lines = [number for number, line in enumerate(text.splitlines(), 1) if "isaaclab" in line]
                found += [Remark(path, number, "names isaaclab") for number in lines[:1]]
        return found

    # -- names that a package of the folder passes on from Isaac Lab

    def _local(self, path: PurePosixPath, module: str) -> PurePosixPath | None:
        """The file of a module that is in the folder; None if it is not."""
        level = len(module) - len(module.lstrip("."))
        parts = [part for part in module.lstrip(".").split(".") if part]
        if level:
            base = path.parent
            for _ in range(level - 1):
                base = base.parent
            return next((file for file in _files(base.joinpath(*parts)) if file in self.sources), None)
        return None if parts[0] in PACKAGES else self._find(parts)

    def _find(self, parts: list[str]) -> PurePosixPath | None:
        """The file of a module with an absolute name: the folder may be any package of its path."""
        for count in range(len(parts)):
            for file in _files(PurePosixPath(*parts[count:])):
                inside = [file, file.relative_to(self._name)] if file.parts[0] == self._name else [file]
                if match := next((name for name in inside if name in self.sources and len(file.parts) > 1), None):
                    return match
        return None

    def _problem_of_local(self, path: PurePosixPath, name: str) -> str | None:
        """Why a name that a module of the folder passes on with ``import *`` does not work."""
        first = name.partition(".")[0]
        if first in ("", "*") or first in self.sources[path].definitions:
            return None
        reasons = (reason_of(module, first) for module in self._stars(path, set()))
        return next((reason for reason in reasons if reason is not None), None)

    def _stars(self, path: PurePosixPath, seen: set[PurePosixPath]) -> list[str]:
        """Modules of lift_lab that a module of the folder imports all names of, also by other modules of the folder."""
        found: list[str] = []
        if path in seen:
            return found
        seen.add(path)
        for use in self.sources[path].uses:
            if use.name == "*":
                local = self._local(path, use.module)
                found += self._stars(local, seen) if local else [use.module] if names_in(use.module) else []
        return found

    # -- writing

    def write(self, out: Path) -> None:
        """Write all files to a new folder, which appears when it is complete.

        Raises:
            FileError: the folder exists and is not empty, lies in the folder that is ported, or cannot be written.
        """
        check_out(self.folder, out)
        out.parent.mkdir(parents=True, exist_ok=True)
        partial = Path(tempfile.mkdtemp(prefix=f".{out.name}.", dir=out.parent))
        try:
            for path in [*self.sources, *self.others]:
                target = partial / path
                target.parent.mkdir(parents=True, exist_ok=True)
                shutil.copy2(self.folder / path, target)
                if path in self.sources and self.sources[path].renamed:
                    target.write_bytes(self.sources[path].data)
            with contextlib.suppress(FileNotFoundError):
                out.rmdir()
            partial.chmod(self.folder.stat().st_mode & 0o777)
            partial.rename(out)
        except BaseException:
            shutil.rmtree(partial, ignore_errors=True)
            raise

    def write_in_place(self) -> None:
        """Replace the files that change."""
        from lift_lab_rl.files import write_atomically

        for path, source in self.sources.items():
            if source.renamed:
                write_atomically(self.folder / path, source.data)


def check_out(folder: Path, out: Path) -> None:
    """Check that a ported folder can be written.

    Args:
        folder: what is ported.
        out: where to.

    Raises:
        FileError: it exists and is not empty, or it lies in the folder that is ported.
    """
    inner, outer = out.resolve(), folder.resolve()
    if inner == outer or outer in inner.parents:
        raise FileError(f"--out '{out}' lies in '{folder}': choose a folder outside, or --in_place")
    if out.exists() and (not out.is_dir() or any(out.iterdir())):
        raise FileError(f"--out '{out}' exists already: choose a new folder")


def _is_in(module: str, packages: tuple[str, ...]) -> bool:
    return any(module == package or module.startswith(f"{package}.") for package in packages)


def _files(module: PurePosixPath) -> list[PurePosixPath]:
    found = [module / "__init__.py"]
    return [*found, module.with_suffix(".py")] if module.name else found
