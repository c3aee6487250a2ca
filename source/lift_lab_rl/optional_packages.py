"""Optional packages: a check that names the extra which installs them."""

from __future__ import annotations

import importlib.util

from lift_lab.utils.errors import MissingPackageError


def require_package(package: str, extra: str) -> None:
    """Check that an optional package is there, before anything of it is imported.

    Args:
        package: the package.
        extra: of lift-lab, which installs it.

    Raises:
        MissingPackageError: it is not installed.
    """
    if importlib.util.find_spec(package) is None:
        raise missing_package(package, extra)


def missing_package(package: str, extra: str) -> MissingPackageError:
    """The error that says how to install an optional package."""
    return MissingPackageError(f"this needs {package}: pip install 'lift-lab[{extra}]'")
