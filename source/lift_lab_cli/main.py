"""The console command ``lift-lab``, whose sub-commands are the programs of this package."""

from __future__ import annotations

import importlib
import sys
from difflib import get_close_matches
from typing import NamedTuple

from lift_lab.app import cli, program


class Command(NamedTuple):
    """A sub-command."""

    module: str
    """Module of this package with its function ``main``."""
    help: str
    """Description in one line."""


COMMANDS = {
    "train": Command("train", "train a policy"),
    "play": Command("play", "run a policy: film it, show it in a browser, export it"),
    "evaluate": Command("evaluate", "measure the success rate of a policy"),
    "study": Command("study", "train and evaluate curriculum and baseline over seeds"),
    "report": Command("report", "draw the curves and tables of trainings"),
    "list": Command("list_envs", "list the tasks"),
    "describe": Command("describe", "show what a task is made of"),
    "benchmark": Command("benchmark", "measure the speed of a task"),
    "demo": Command("demo", "show a pretrained policy at work, in a browser or as a film"),
    "port": Command("port", "port a package of Isaac Lab 2.x"),
    "usd": Command("usd_info", "import a USD file and report the result"),
}
"""Sub-commands by name, in the order of the help text."""


def main(name: str = "lift-lab", arguments: tuple[str, ...] = ("-m", "lift_lab_cli")) -> int:
    """Run the sub-command that the command line names.

    Args:
        name: name of this program in usage lines and messages.
        arguments: arguments of the Python interpreter that run this program again.

    Returns:
        The exit status.
    """
    words = sys.argv[1:]
    first = words[0] if words else "--help"
    if first in ("-h", "--help"):
        print(usage(name))
        return 0
    if first == "--version":
        import lift_lab

        print(f"lift-lab {lift_lab.__version__}")
        return 0
    if first not in COMMANDS:
        near = get_close_matches(first, COMMANDS, n=3, cutoff=0.5)
        hint = f"did you mean {', '.join(near)}?" if near else f"{name} --help lists all"
        kind = "flag" if first.startswith("-") else "command"
        print(f"error: unknown {kind} '{first}'; {hint}", file=sys.stderr)
        return cli.USAGE_ERROR
    with program.entered(program.Program(f"{name} {first}", (*arguments, first)), words[1:]):
        return importlib.import_module(f".{COMMANDS[first].module}", __package__).main()


def usage(name: str) -> str:
    """Help text with one line for each sub-command.

    Args:
        name: name of this program.
    """
    width = max(map(len, COMMANDS))
    lines = [f"  {word:{width}}  {command.help}" for word, command in COMMANDS.items()]
    return "\n".join(
        [
            f"usage: {name} COMMAND [flags] [overrides]",
            "",
            "Robot learning on MuJoCo, written as in Isaac Lab.",
            "",
            "commands:",
            *lines,
            "",
            f"{name} COMMAND --help lists the flags of a command; {name} --version names the version.",
        ]
    )


def console() -> None:
    """Run the console command ``lift-lab`` and exit."""
    cli.run(main)
