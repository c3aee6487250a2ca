"""Command lines: Isaac Lab's ``AppLauncher`` without a simulator behind it, and what all scripts share.

Importing this package is cheap: neither torch nor mujoco is touched, so that ``--help`` answers at once and a script
can set environment variables before they are imported.
"""

from .app_launcher import AppLauncher

__all__ = ["AppLauncher"]
