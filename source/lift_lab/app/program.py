"""The program that runs: its name as the user called it, and how to run it again in another process."""

from __future__ import annotations

import contextlib
import sys
from collections.abc import Iterator, Sequence
from typing import NamedTuple


class Program(NamedTuple):
    """A program that the user called."""

    name: str
    """Its name in usage lines and messages: ``lift-lab train`` or ``scripts/rsl_rl/train.py``."""
    python_arguments: tuple[str, ...]
    """Arguments of the Python interpreter that run it again."""

    @property
    def command(self) -> str:
        """Command that starts it in a shell: ``lift-lab train`` or ``python scripts/rsl_rl/train.py``."""
        return f"python {self.name}" if self.name.endswith(".py") else self.name


_entered: list[Program] = []


def current() -> Program:
    """The program that runs: the innermost of :func:`entered`, or what Python was started with."""
    if _entered:
        return _entered[-1]
    path = sys.argv[0]
    spec = getattr(sys.modules["__main__"], "__spec__", None)
    if spec is not None and spec.origin == path:
        return Program(f"python -m {spec.name}", ("-m", spec.name))
    return Program(path, (path,))


@contextlib.contextmanager
def entered(program: Program, arguments: Sequence[str]) -> Iterator[None]:
    """Make a sub-command the current program, and its arguments those of the process.

    Args:
        program: the sub-command.
        arguments: its arguments.
    """
    argv = sys.argv
    _entered.append(program)
    sys.argv = [argv[0], *arguments]
    try:
        yield
    finally:
        sys.argv = argv
        _entered.pop()
