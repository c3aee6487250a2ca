"""Lookup of USD files: local ones, and those that asset packages register for names and Isaac Lab's paths."""

from __future__ import annotations

import importlib
import io
import os
import shutil
from collections.abc import Mapping
from pathlib import Path
from typing import Literal

from .errors import FileError, suggest

NUCLEUS_SCHEME = "nucleus://"
"""Scheme of the asset strings below. They name assets, not a server."""

NUCLEUS_ASSET_ROOT_DIR = "nucleus:/"
"""Root of the asset strings."""

NVIDIA_NUCLEUS_DIR = f"{NUCLEUS_ASSET_ROOT_DIR}/NVIDIA"
"""Isaac Lab's ``NVIDIA`` asset folder."""

ISAAC_NUCLEUS_DIR = f"{NUCLEUS_ASSET_ROOT_DIR}/Isaac"
"""Isaac Lab's ``Isaac`` asset folder."""

ISAACLAB_NUCLEUS_DIR = f"{ISAAC_NUCLEUS_DIR}/IsaacLab"
"""Isaac Lab's ``Isaac/IsaacLab`` asset folder."""

_PACKAGE = "lift_lab_assets"
"""Package whose files ship with lift_lab. It registers them when it is imported, which the first look-up does."""

_shipped_files: dict[Path, Mapping[str, str]] = {}
"""Folder of USD files -> file names in Isaac Lab of the files in it."""


def register_assets(folder: Path, isaac_names: Mapping[str, str]) -> None:
    """Let file names and Isaac Lab's asset paths lead to the USD files of a folder.

    Args:
        folder: absolute path; of several folders the one that was registered first comes first.
        isaac_names: file name in Isaac Lab -> file in ``folder``. Others lead to the file of the same stem.
    """
    _shipped_files[folder] = isaac_names


def shipped_folders() -> Mapping[Path, Mapping[str, str]]:
    """Registered folders, each with Isaac Lab's names of its files."""
    importlib.import_module(_PACKAGE)
    return _shipped_files


def resolve_usd_path(path: str | Path) -> Path:
    """Find the local file that an asset path means.

    Args:
        path: a local file, the name of a file that ships, or an Isaac Lab asset path such as
            ``f"{ISAAC_NUCLEUS_DIR}/Props/Blocks/DexCube/dex_cube_instanceable.usd"``.

    Returns:
        Absolute path of an existing file.

    Raises:
        FileError: no such file; names the nearest ones.
    """
    if _is_remote(path):
        name = str(path).rstrip("/").rpartition("/")[2]
        shipped = _shipped(name)
        if shipped is not None:
            return shipped
        known = [name for names in shipped_folders().values() for name in names]
        known += [name for folder in shipped_folders() for name in _file_names(folder) if ".usd" in name]
        raise FileError(f"no local asset stands for '{path}'; {suggest(name, known)}")
    local = Path(path).expanduser()
    if local.is_file():
        return local.absolute()
    if local.parent == Path():
        shipped = _shipped(local.name)
        if shipped is not None:
            return shipped
    folders = [local.parent] if local.parent.is_dir() and local.parent != Path() else [*shipped_folders()]
    known = [name for folder in folders for name in _file_names(folder)]
    where = ", ".join(f"'{folder}'" for folder in folders)
    raise FileError(f"no file '{path}'; in {where} {suggest(local.name, known)}")


def check_file_path(path: str | Path) -> Literal[0, 1, 2]:
    """Say where a file is: 0 nowhere, 1 it is local, 2 it is an asset path that a shipped file stands for."""
    if not _is_remote(path) and Path(path).is_file():
        return 1
    try:
        resolve_usd_path(path)
    except FileError:
        return 0
    return 2


def retrieve_file_path(path: str | Path, download_dir: str | None = None, force_download: bool = True) -> str:
    """Absolute path of a local file, copying shipped assets into ``download_dir`` where one is given.

    Args:
        path: as in :func:`resolve_usd_path`.
        download_dir: folder that receives a copy of an asset that is not already a local path. None copies nothing.
        force_download: whether an existing copy is overwritten.

    Raises:
        FileError: no such file.
    """
    source = resolve_usd_path(path)
    if download_dir is None or check_file_path(path) == 1:
        return str(source)
    target = Path(download_dir).absolute() / source.name
    target.parent.mkdir(parents=True, exist_ok=True)
    if force_download or not target.is_file():
        shutil.copyfile(source, target)
    return str(target)


def read_file(path: str | Path) -> io.BytesIO:
    """Contents of a file that :func:`resolve_usd_path` finds.

    Raises:
        FileError: no such file.
    """
    return io.BytesIO(resolve_usd_path(path).read_bytes())


def _is_remote(path: str | Path) -> bool:
    return not isinstance(path, os.PathLike) and (path.startswith("nucleus:") or "://" in path)


def _shipped(name: str) -> Path | None:
    """The registered file of that name in Isaac Lab or here, whichever USD extension it has."""
    for folder, isaac_names in shipped_folders().items():
        name = isaac_names.get(name, name)
        stem = Path(name).stem
        for candidate in (name, f"{stem}.usda", f"{stem}.usd", f"{stem}.usdc"):
            if (folder / candidate).is_file():
                return folder / candidate
    return None


def _file_names(folder: Path) -> list[str]:
    return sorted(file.name for file in folder.iterdir() if file.is_file()) if folder.is_dir() else []
