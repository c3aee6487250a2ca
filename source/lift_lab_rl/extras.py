"""Optional packages: a check that names the extra which brings them."""

from __future__ import annotations

import importlib.util

from lift_lab.utils.errors import MissingPackageError

EXTRAS = {"skrl": "skrl", "stable_baselines3": "sb3"}
"""Extra of lift-lab that installs a package."""


def require_package(package: str) -> None:
    """Check that an optional package is there, before anything of it is imported.

    Raises:
        MissingPackageError: it is not installed.
    """
    if importlib.util.find_spec(package) is None:
        raise missing_package(package)


def missing_package(package: str) -> MissingPackageError:
    """The error that says how to install an optional package."""
    return MissingPackageError(f"this needs {package}: pip install 'lift-lab[{EXTRAS[package]}]'")
