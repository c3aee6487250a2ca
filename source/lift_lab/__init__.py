"""Robot-learning environments on MuJoCo, written as Isaac Lab's are."""

from typing import Any

from .isaac import finder as _finder

__version__: str
"""Version of the installed distribution, from ``pyproject.toml``; "unknown" in a checkout that is not installed."""

_finder.install()


def __getattr__(name: str) -> Any:
    if name == "__version__":
        from importlib import metadata  # takes longer to import than all of the above

        try:
            return metadata.version("lift-lab")
        except metadata.PackageNotFoundError:
            return "unknown"
    raise AttributeError(f"module 'lift_lab' has no attribute '{name}'")
