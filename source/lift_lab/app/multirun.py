"""Sweeps: ``--multirun`` runs a script once for each combination of the values that its overrides list.

The grammar is hydra's: ``agent.algorithm.gamma=0.98,0.99``, ``env/curriculum=step,linear``, ``env.seed=range(1,4)``.
Runs come one after the other, each in a process of its own (hydra's local launcher); no folder is made for the sweep.
"""

from __future__ import annotations

import itertools
import signal
import subprocess
import sys
from collections.abc import Sequence

from lift_lab.utils.errors import ConfigError

from . import program
from .children import child_environment
from .endings import number_of

FLAGS = ("-m", "--multirun")
"""Flags that ask for a sweep (hydra's)."""


def expand(overrides: Sequence[str]) -> list[list[str]]:
    """The overrides of each run of a sweep, the last override changing fastest.

    Args:
        overrides: in hydra's grammar.

    Raises:
        ConfigError: an override cannot be read, or lists no values but an interval.
    """
    from hydra.core.override_parser.overrides_parser import OverridesParser
    from hydra.errors import HydraException

    parser = OverridesParser.create()
    choices: list[list[str]] = []
    for text in overrides:
        try:
            override = parser.parse_override(text)
            if not override.is_sweep_override():
                choices.append([text])
                continue
            if not override.is_discrete_sweep():
                raise ConfigError(f"override '{text}': an interval has no values to run through; list them")
            key = override.get_key_element()
            choices.append([f"{key}={value}" for value in override.sweep_string_iterator()])
        except HydraException as error:
            raise ConfigError(f"cannot read the override '{text}': {str(error).strip().splitlines()[0]}") from error
    return [list(job) for job in itertools.product(*choices)]


def run_each(argv: Sequence[str], overrides: Sequence[str]) -> int:
    """Run the current program once for each combination.

    Args:
        argv: its arguments.
        overrides: those of them that are overrides.

    Returns:
        0, or the exit status of the first run that failed; the others run all the same.
    """
    jobs = expand(overrides)
    flags = [text for text in argv if text not in overrides and text not in FLAGS]
    failed: list[tuple[int, int]] = []
    for number, job in enumerate(jobs, 1):
        print(f"[{number}/{len(jobs)}] {' '.join(job)}", flush=True)
        process = subprocess.Popen(
            [sys.executable, *program.current().python_arguments, *flags, *job], env=child_environment()
        )
        try:
            status = process.wait()
        except KeyboardInterrupt as interrupt:
            number = number_of(interrupt)
            if number != signal.SIGINT:  # Ctrl-C on a terminal comes to the run, too
                process.send_signal(number)
            process.wait()
            raise
        if status:
            failed.append((number, status))
    if failed:
        numbers = ", ".join(str(number) for number, _ in failed)
        print(f"{len(failed)} of {len(jobs)} runs failed: {numbers}", file=sys.stderr)
        return failed[0][1]
    return 0
