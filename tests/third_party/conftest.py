"""Other projects' packages, in virtual environments of these tests' own.

A test module lists what it needs in ``ENVIRONMENTS`` (name -> requirements) and ``WHEELS`` (requirements of which only
the files are read). All that the collected modules list is fetched at once, each package into a folder of its own and
without its dependencies: large ones that this project has too (numpy, warp, usd-core) are linked from its environment.
A module whose packages cannot be had is skipped with pip's last line as the reason.

The environment variable ``LIFT_LAB_THIRD_PARTY`` names a folder to keep them in; without it they live for the session.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import sysconfig
import venv
import zipfile
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path
from typing import Any

import pytest

PIP_LIMIT_S = 300
SCRIPT_LIMIT_S = 900
PARALLEL_DOWNLOADS = 8


class Unavailable(Exception):
    """A package that cannot be had here."""


def _pip(*arguments: str) -> None:
    command = [sys.executable, "-m", "pip", *arguments, "--quiet", "--no-input", "--disable-pip-version-check"]
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=PIP_LIMIT_S, check=False)
    except subprocess.TimeoutExpired:
        raise Unavailable(f"pip {arguments[0]} took more than {PIP_LIMIT_S} s for {arguments[-1]}") from None
    if done.returncode:
        lines = done.stderr.strip().splitlines() or [f"pip exited with {done.returncode}"]
        raise Unavailable(f"pip {arguments[0]} {arguments[-1]}: {lines[-1]}")


class ThirdParty:
    """Fetches packages in the background and hands out interpreters that see them."""

    def __init__(self, root: Path) -> None:
        self.root = root
        self.pool = ThreadPoolExecutor(PARALLEL_DOWNLOADS)
        self.pending: dict[tuple[str, str], Future[Path]] = {}

    def start(self, kind: str, requirement: str) -> Future[Path]:
        """Begin to fetch a package: `kind` is ``install`` or ``download``."""
        key = (kind, requirement)
        if key not in self.pending:
            self.pending[key] = self.pool.submit(self._fetch, kind, requirement)
        return self.pending[key]

    def _fetch(self, kind: str, requirement: str) -> Path:
        folder = self.root / kind / requirement
        complete = folder / ".complete"
        if not complete.exists():
            place = "--target" if kind == "install" else "--dest"
            compile_not = ["--no-compile"] if kind == "install" else []
            _pip(kind, "--no-deps", "--only-binary=:all:", *compile_not, place, str(folder), requirement)
            complete.touch()
        return folder

    def _wait(self, kind: str, requirement: str) -> Path:
        try:
            return self.start(kind, requirement).result()
        except Unavailable as error:
            pytest.skip(str(error))

    def wheel(self, requirement: str, under: str) -> Path:
        """Folder with the files of a wheel whose path contains `under`."""
        folder = self._wait("download", requirement)
        target = folder / "files" / under.strip("/").replace("/", "-")
        if not target.exists():
            (wheel,) = folder.glob("*.whl")
            with zipfile.ZipFile(wheel) as archive:
                archive.extractall(target, [name for name in archive.namelist() if under in name])
        return target

    def environment(self, name: str, requirements: list[str], shared: tuple[str, ...]) -> Environment:
        """A virtual environment with `requirements` and with the folders `shared` of this project's environment."""
        folders = [self._wait("install", requirement) for requirement in requirements]
        return Environment(self.root / "environments" / name, folders, shared)


class Environment:
    """A virtual environment that takes its packages from given folders."""

    def __init__(self, root: Path, folders: list[Path], shared: tuple[str, ...]) -> None:
        venv.create(root, with_pip=False, symlinks=os.name != "nt", clear=True)
        self.python = root / ("Scripts/python.exe" if os.name == "nt" else "bin/python")
        packages = Path(sysconfig.get_path("purelib", "venv", {"base": str(root), "platbase": str(root)}))
        (packages / "third_party.pth").write_text("".join(f"{folder}\n" for folder in folders))
        for ours in {Path(sysconfig.get_path(kind)) for kind in ("purelib", "platlib")}:
            for name in shared:
                if (ours / name).exists():
                    (packages / name).symlink_to(ours / name, target_is_directory=True)

    def run(self, script: Path, task: Any, folder: Path) -> Any:
        """What `script` wrote as JSON for `task`: it is called with the paths of both files."""
        folder.mkdir(parents=True, exist_ok=True)
        asked, answered = folder / "task.json", folder / "answer.json"
        asked.write_text(json.dumps(task))
        variables = {key: value for key, value in os.environ.items() if not key.startswith(("PYTHON", "PXR_"))}
        done = subprocess.run(
            [str(self.python), str(script), str(asked), str(answered)],
            capture_output=True, text=True, timeout=SCRIPT_LIMIT_S, check=False, env=variables,
        )  # fmt: skip
        assert done.returncode == 0, f"{script.name}: {done.stderr[-3000:]}"
        return json.loads(answered.read_text())


@pytest.fixture(scope="session")
def third_party(request, tmp_path_factory):
    """Packages of other projects; those of all collected modules begin to arrive at the first use."""
    kept = os.environ.get("LIFT_LAB_THIRD_PARTY")
    packages = ThirdParty(Path(kept).resolve() if kept else tmp_path_factory.mktemp("third_party"))
    for module in {item.module for item in request.session.items if getattr(item, "module", None)}:
        for requirements in getattr(module, "ENVIRONMENTS", {}).values():
            for requirement in requirements:
                packages.start("install", requirement)
        for requirement in getattr(module, "WHEELS", ()):
            packages.start("download", requirement)
    yield packages
    packages.pool.shutdown(cancel_futures=True)
