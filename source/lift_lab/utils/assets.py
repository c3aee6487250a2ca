"""Where USD files are found, and how Isaac Lab's Nucleus paths map to the files that ship with lift_lab."""

from __future__ import annotations

import io
import os
import shutil
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

_ROOT = Path(__file__).resolve().parents[2]
_PACKAGED = _ROOT / "lift_lab_assets" / "usd"

ASSETS_USD_DIR: Path = _PACKAGED if _PACKAGED.is_dir() else _ROOT.parent / "assets" / "usd"
"""Folder of the USD files that ship: in the installed package, else in the checkout."""

PRETRAINED_DIR: Path = ASSETS_USD_DIR.parent / "pretrained"
"""Folder of the policies that ship, a folder for each task."""

NUCLEUS_ASSETS: dict[str, str] = {
    "panda_instanceable.usd": "franka_panda.usda",
    "dex_cube_instanceable.usd": "cube.usda",
    "table_instanceable.usd": "table.usda",
    "sektion_cabinet_instanceable.usd": "cabinet.usda",
}
"""File name of an Isaac Lab asset -> file in :data:`ASSETS_USD_DIR`. Others map to the file of the same stem."""


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
        shipped = _shipped(NUCLEUS_ASSETS.get(name, name))
        if shipped is not None:
            return shipped
        known = [*NUCLEUS_ASSETS, *(file for file in _file_names(ASSETS_USD_DIR) if ".usd" in file)]
        raise FileError(f"no local asset stands for '{path}'; {suggest(name, known)}")
    local = Path(path).expanduser()
    if local.is_file():
        return local.absolute()
    if local.parent == Path():
        shipped = _shipped(local.name)
        if shipped is not None:
            return shipped
    folder = local.parent if local.parent.is_dir() and local.parent != Path() else ASSETS_USD_DIR
    raise FileError(f"no file '{path}'; in '{folder}' {suggest(local.name, _file_names(folder))}")


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
    """The shipped file of that name, whichever USD extension it has."""
    stem = Path(name).stem
    for candidate in (name, f"{stem}.usda", f"{stem}.usd", f"{stem}.usdc"):
        file = ASSETS_USD_DIR / candidate
        if file.is_file():
            return file
    return None


def _file_names(folder: Path) -> list[str]:
    return sorted(file.name for file in folder.iterdir() if file.is_file()) if folder.is_dir() else []
