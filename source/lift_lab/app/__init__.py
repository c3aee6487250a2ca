"""Command lines: Isaac Lab's ``AppLauncher`` without a simulator, and helpers of all scripts.

Importing this package loads neither torch nor mujoco. So ``--help`` answers at once, and a script can set environment
variables before it imports them.
"""

from .app_launcher import AppLauncher

__all__ = ["AppLauncher"]
