"""Isaac Lab's ``AppLauncher``: the flags of its scripts, for scripts written against it."""

from __future__ import annotations

import argparse
import logging
import os
import sys
from typing import Any

_NO_EFFECT: dict[str, dict[str, Any]] = {
    "livestream": {"type": int, "default": -1, "choices": (0, 1, 2)},
    "enable_cameras": {"action": "store_true"},
    "experience": {"type": str, "default": ""},
    "rendering_mode": {"type": str, "default": None, "choices": ("performance", "balanced", "quality", "xr")},
    "kit_args": {"type": str, "default": ""},
    "anim_recording_start_time": {"type": float, "default": 0.0},
    "anim_recording_stop_time": {"type": float, "default": 10.0},
}
"""Flags about Isaac Sim's window, cameras and renderer, none of which exists here."""

_OFF: dict[str, Any] = {"livestream": 0}
"""Values that ask for nothing, beside the defaults."""

_NO_EFFECT_IN_SCRIPTS = {"disable_fabric": ("--disable_fabric", False), "ray_proc_id": ("--ray-proc-id", None)}
"""Flags that Isaac Lab's scripts add themselves and that have no effect here: how they are written, and defaults."""

_REFUSED = {
    "xr": "there are no XR devices; leave the flag out",
    "anim_recording_enabled": "no USD animation is recorded; play --replay FILE.html writes a page that plays",
    "cpu": "write --device cpu",
}
"""Flags that ask for something that does not exist here, and what to do instead."""


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

    One line on standard error names the given flags that have no effect here.
    """

    def __init__(self, launcher_args: argparse.Namespace | dict | None = None, **kwargs: Any):
        """Take the flags.

        Args:
            launcher_args: parsed arguments, of a parser that went through :meth:`add_app_launcher_args`.
            **kwargs: further flags by name.

        Raises:
            ConfigError: a flag asks for something that does not exist here.
        """
        given = dict(vars(launcher_args) if isinstance(launcher_args, argparse.Namespace) else launcher_args or {})
        given |= kwargs
        for name, advice in _REFUSED.items():
            if given.get(name):
                from lift_lab.utils.errors import ConfigError

                raise ConfigError(f"--{name}: {advice}")
        self.app = App()
        self.device: str = given.get("device") or "auto"
        self.local_rank, self.global_rank = int(os.environ.get("LOCAL_RANK", 0)), int(os.environ.get("RANK", 0))
        if given.get("verbose") or given.get("info"):
            level = logging.DEBUG if given.get("verbose") else logging.INFO
            logging.basicConfig(level=level, format="%(levelname)s %(name)s: %(message)s")
        _tell_unused(given)

    @staticmethod
    def add_app_launcher_args(parser: argparse.ArgumentParser) -> None:
        """Add the launcher's flags to a parser.

        Args:
            parser: gets ``--device``, ``--verbose`` and ``--info``. It also accepts Isaac Sim's flags, which ``--help``
                does not show.
        """
        group = parser.add_argument_group("launcher")
        group.add_argument(
            "--device", type=str, default=None, help="cpu, cuda:N or auto (default: a GPU if there is one)"
        )
        group.add_argument("--verbose", action="store_true", help="show every log message")
        group.add_argument("--info", action="store_true", help="show informative log messages")
        hidden = parser.add_argument_group()  # not in --help
        hidden.add_argument("--headless", action="store_true", help=argparse.SUPPRESS)  # there is no window anyway
        for name, spec in _NO_EFFECT.items():
            hidden.add_argument(f"--{name}", help=argparse.SUPPRESS, **spec)
        for name in _REFUSED:
            hidden.add_argument(f"--{name}", action="store_true", help=argparse.SUPPRESS)


def _tell_unused(given: dict[str, Any]) -> None:
    """Name the flags that have no effect here in one line on standard error."""
    known = {name: (f"--{name}", spec.get("default", False)) for name, spec in _NO_EFFECT.items()}
    unused = [
        flag
        for name, (flag, default) in (known | _NO_EFFECT_IN_SCRIPTS).items()
        if given.get(name, default) not in (default, _OFF.get(name, default))
    ]
    if not unused:
        return
    browser = "; play --viewer shows the simulation in a browser" if "--livestream" in unused else ""
    print(f"no effect here: {', '.join(unused)} (there is no Omniverse){browser}", file=sys.stderr)
