"""Importing all sub-packages of a package, so that each can register its tasks."""

from __future__ import annotations

import importlib
import pkgutil
from collections.abc import Sequence


def import_packages(package_name: str, blacklist_pkgs: Sequence[str] = ()) -> None:
    """Import every sub-package, at any depth, but no plain module (Isaac Lab's ``import_packages``).

    Args:
        package_name: the package.
        blacklist_pkgs: packages whose dotted name contains one of these are skipped, with all below them.
    """
    package = importlib.import_module(package_name)
    for info in pkgutil.iter_modules(package.__path__, f"{package_name}."):
        if info.ispkg and not any(blacklisted in info.name for blacklisted in blacklist_pkgs):
            import_packages(info.name, blacklist_pkgs)
