"""Isaac Lab's ``AppLauncher``: the flags of its scripts, for scripts written against it."""

from __future__ import annotations

import argparse
import logging
import os
import sys
from typing import Any

_IGNORED: dict[str, dict[str, Any]] = {
    "headless": {"action": "store_true"},
    "livestream": {"type": int, "default": -1},
    "enable_cameras": {"action": "store_true"},
    "xr": {"action": "store_true"},
    "experience": {"type": str, "default": ""},
    "rendering_mode": {"type": str, "default": None},
    "kit_args": {"type": str, "default": ""},
    "anim_recording_enabled": {"action": "store_true"},
    "anim_recording_start_time": {"type": float, "default": 0.0},
    "anim_recording_stop_time": {"type": float, "default": 10.0},
}
"""Flags about Isaac Sim's window, cameras and renderer, none of which exists here."""


class App:
    """Stands for the simulator's process: it runs until it is closed."""

    def __init__(self) -> None:
        self._running = True

    def is_running(self) -> bool:
        """Whether :meth:`close` was not called yet."""
        return self._running

    def close(self) -> None:
        """End. May be called again."""
        self._running = False


class AppLauncher:
    """Reads the launcher's flags; there is nothing to launch.

    Flags that have no meaning here are named in one line on standard error.
    """

    def __init__(self, launcher_args: argparse.Namespace | dict | None = None, **kwargs: Any):
        """Take the flags.

        Args:
            launcher_args: parsed arguments, of a parser that went through :meth:`add_app_launcher_args`.
            **kwargs: further flags by name.
        """
        given = dict(vars(launcher_args) if isinstance(launcher_args, argparse.Namespace) else launcher_args or {})
        given |= kwargs
        self.app = App()
        self.device: str = given.get("device") or "auto"
        self.local_rank, self.global_rank = int(os.environ.get("LOCAL_RANK", 0)), int(os.environ.get("RANK", 0))
        if given.get("verbose") or given.get("info"):
            level = logging.DEBUG if given.get("verbose") else logging.INFO
            logging.basicConfig(level=level, format="%(levelname)s %(name)s: %(message)s")
        unused = [f"--{name}" for name, spec in _IGNORED.items() if given.get(name, _default(spec)) != _default(spec)]
        if unused:
            print(f"ignored: {', '.join(unused)} (there is no simulator window here)", file=sys.stderr)

    @staticmethod
    def add_app_launcher_args(parser: argparse.ArgumentParser) -> None:
        """Add the launcher's flags to a parser.

        Args:
            parser: gets ``--device``, ``--verbose``, ``--info``, and flags of Isaac Sim that are ignored here.
        """
        group = parser.add_argument_group("launcher")
        group.add_argument(
            "--device", type=str, default=None, help="cpu, cuda:N or auto (default: a GPU if there is one)"
        )
        group.add_argument("--verbose", action="store_true", help="show every log message")
        group.add_argument("--info", action="store_true", help="show informative log messages")
        ignored = parser.add_argument_group("Isaac Sim's flags", "accepted and ignored: there is no window here")
        for name, spec in _IGNORED.items():
            ignored.add_argument(f"--{name}", **spec)


def _default(spec: dict[str, Any]) -> Any:
    return False if spec.get("action") == "store_true" else spec["default"]
