"""Command-line helpers of the scripts: arguments followed by overrides, and errors in one line.

A user's mistake ends a script with one line on standard error and exit status 2. Anything else is a bug: it keeps its
traceback and has exit status 1. A script that a signal ends has status 128 plus the signal's number.
"""

from __future__ import annotations

import argparse
import errno
import os
import signal
import sys
from collections.abc import Callable, Sequence
from difflib import get_close_matches
from typing import Any, NamedTuple

from . import children, endings, output, program

_DISK = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO, errno.EROFS)
"""What a full or failing disk answers."""

_GYMNASIUM = " was raised from the environment creator for "
"""What gymnasium.make adds to a TypeError, with the whole configuration after it (gymnasium 1.2 to 1.4)."""

USAGE_ERROR = 2
"""Exit status after a user's mistake."""


class FlagSetting(NamedTuple):
    """An entry of a configuration that a flag sets."""

    flag: str
    """The flag, such as ``--num_envs``."""
    path: str
    """Path of the entry, such as ``env.scene.num_envs``."""
    value: Any


class Parser(argparse.ArgumentParser):
    """Argument parser whose errors are one line, and that takes ``key=value`` overrides after its flags.

    Attributes:
        settings: name of a flag, without dashes -> paths of the entries of the configurations that it sets.
    """

    def __init__(self, description: str | None, overrides: bool = True, multirun: bool | None = None):
        """Make an empty parser.

        Args:
            description: what the script does.
            overrides: whether the script takes overrides.
            multirun: whether it can be run once for each combination of the values that these list; None if it takes
                overrides.
        """
        epilog = (
            "Other arguments are overrides of the task's configuration in hydra's grammar, e.g. "
            "env.episode_length_s=10 env.rewards.NAME.weight=20 env.events.NAME=null agent.seed=1"
        )
        first = (description or "").strip().partition("\n\n")[0]
        name, epilog = program.current().name, epilog if overrides else None
        super().__init__(name, description=first, epilog=epilog, allow_abbrev=False)
        self.settings: dict[str, tuple[str, ...]] = {}
        self.takes_overrides = overrides
        self.takes_multirun = overrides if multirun is None else multirun
        if self.takes_multirun:
            text = "run once for each combination of listed values, as in agent.seed=1,2"
            self.add_argument("-m", "--multirun", action="store_true", help=text)

    def parse(self, argv: Sequence[str] | None = None) -> tuple[argparse.Namespace, list[str]]:
        """Flags and overrides. With ``--multirun``, the script is run once for each combination, and this one exits.

        Args:
            argv: arguments; None for the process's.

        Returns:
            The flags, and the overrides as they were written. ``flag_settings`` of the flags is a list of the entries
            of configurations that the given ones set, by :attr:`settings`.
        """
        args, rest = self.parse_known_args(argv)
        flags = [text for text in rest if text.startswith("-")]
        if flags:
            self.error(f"unknown flag '{flags[0]}'; {self._nearest_flag(flags[0])}")
        if rest and not self.takes_overrides:
            self.error(f"unexpected argument '{rest[0]}'")
        if self.takes_multirun and args.multirun:
            from .multirun import run_each

            raise SystemExit(run_each(sys.argv[1:] if argv is None else argv, rest))
        args.flag_settings = self._given_settings(args)
        return args, rest

    def _given_settings(self, args: argparse.Namespace) -> list[FlagSetting]:
        given = {name: getattr(args, name, None) for name in self.settings}
        return [
            FlagSetting(f"--{name}", path, value)
            for name, value in given.items()
            if value is not None and value is not False
            for path in self.settings[name]
        ]

    def error(self, message: str) -> None:  # type: ignore[override]
        """Print one line and exit."""
        print(f"error: {message}", file=sys.stderr)
        raise SystemExit(USAGE_ERROR)

    def _nearest_flag(self, flag: str) -> str:
        shown = (action for action in self._actions if action.help is not argparse.SUPPRESS)
        known = [option for action in shown for option in action.option_strings]
        near = get_close_matches(flag.partition("=")[0], known, n=3, cutoff=0.6)
        return f"did you mean {', '.join(near)}?" if near else "--help lists all"


def run(main: Callable[[], int | None]) -> None:
    """Run a script's main function and exit.

    Signals that ask the process to end, and output that cannot be written, are handled as in
    :mod:`~lift_lab.app.endings` and :mod:`~lift_lab.app.output`.

    Args:
        main: returns the exit status, None for 0.
    """
    if sys.platform == "win32":  # locks, signals and the sandbox of USD files need POSIX
        print("error: lift_lab does not run on Windows itself: use WSL 2 (docs/install.md)", file=sys.stderr)
        raise SystemExit(USAGE_ERROR)
    children.follow_parent()
    is_ignored = endings.is_ignored(endings.HANGUP)
    with output.guarded() as (out, _):
        try:
            with endings.handled():
                status = _status(main, out)
        except KeyboardInterrupt as again:  # before the first signal was dealt with
            endings.ignore()
            status = endings.exit_status(endings.number_of(again))
        out.flush()
        if out.problem is not None and not is_ignored:
            status = status or endings.exit_status(endings.HANGUP)
            if not out.reader_ended:
                print(f"ended: {out.problem}", file=sys.stderr)
    raise SystemExit(status)


def _status(main: Callable[[], int | None], out: output.Output) -> int:
    """Run a main function; its exit status, also after an error of the user or a signal."""
    if "MUJOCO_GL" in os.environ:
        from lift_lab.drawing.opengl import mujoco_problem

        problem = mujoco_problem()
        if problem is not None:
            print(f"error: {problem}", file=sys.stderr)
            return USAGE_ERROR
    try:
        status = main() or 0
        out.flush()  # may find that nobody reads
        return status
    except KeyboardInterrupt as interrupt:
        endings.ignore()
        number = endings.number_of(interrupt)
        if number != endings.HANGUP or out.problem is None:
            print("interrupted" if number == signal.SIGINT else f"ended by {interrupt}", file=sys.stderr)
        return endings.exit_status(number)
    except Exception as error:
        from lift_lab.utils.errors import LiftLabError

        if isinstance(error, OSError) and not isinstance(error, LiftLabError):
            if error.filename is not None:
                error = LiftLabError(f"{error.strerror}: '{error.filename}'")
            elif error.errno in _DISK:  # of a write, which does not know the file's name
                error = LiftLabError(f"a file could not be written: {error.strerror}")
        if not isinstance(error, LiftLabError):
            raise
        text = str(error).partition(_GYMNASIUM)[0]
        print(f"error: {' '.join(text.split())}", file=sys.stderr)
        return USAGE_ERROR
