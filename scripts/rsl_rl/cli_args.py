"""Flags that the rsl_rl scripts share."""

from __future__ import annotations

import argparse
import re
from collections.abc import Sequence
from pathlib import Path

from lift_lab.app import cli
from lift_lab.app.arguments import positive, task_parser

__all__ = ["add_checkpoint_args", "check_agent", "check_checkpoint_args", "make_parser", "positive", "split_overrides"]

_OVERRIDE = re.compile(r"\+{0,2}(env|agent)[./].*=|~(env|agent)[./]")


def make_parser(description: str | None) -> cli.Parser:
    """A parser with the flags of every rsl_rl script.

    Args:
        description: the script's docstring.
    """
    parser = task_parser(description, "rsl_rl_cfg_entry_point", "logs/rsl_rl")
    parser.settings["experiment_name"] = ("agent.experiment_name",)
    return parser


def add_checkpoint_args(parser: argparse.ArgumentParser) -> None:
    """Add the flags that say which policy acts."""
    parser.add_argument(
        "--checkpoint", type=str, default=None, help="path, latest (default), best, pretrained, or a file name"
    )
    parser.add_argument(
        "--load_run", type=str, default=None, help="regular expression of the run (default: the newest)"
    )


def check_checkpoint_args(parser: cli.Parser, args: argparse.Namespace) -> None:
    """End with one line where ``--load_run`` says nothing, because ``--checkpoint`` names the policy by itself."""
    named = args.checkpoint is not None and (args.checkpoint == "pretrained" or Path(args.checkpoint).exists())
    if args.load_run is not None and named:
        parser.error(f"--load_run chooses among runs, but --checkpoint {args.checkpoint} names the policy: give one")


def check_agent(args: argparse.Namespace, *more: str) -> None:
    """Check that rsl_rl can use the agent's configuration.

    Args:
        args: flags ``task`` and ``agent``.
        more: what else may be given.

    Raises:
        NotFoundError: no such task, or the agent is none of its agents for rsl_rl.
    """
    from lift_lab.utils.errors import NotFoundError, suggest
    from lift_lab_tasks.utils import task_kwargs
    from lift_lab_tasks.utils.parse_cfg import ENV_CFG

    entries = task_kwargs(args.task)
    other = [key for key, entry in entries.items() if key == ENV_CFG or str(entry).endswith(".yaml")]
    usable = [key for key in entries if key.endswith("_entry_point") and key not in other]
    if args.agent not in (*usable, *more):
        raise NotFoundError(
            f"task '{args.task}' has no '{args.agent}' for rsl_rl; {suggest(args.agent, [*usable, *more])}"
        )


def split_overrides(words: Sequence[str]) -> tuple[list[str], list[str]]:
    """Overrides among the words of a command line, and the others: flags with several values would take both."""
    overrides = [word for word in words if _OVERRIDE.match(word)]
    return overrides, [word for word in words if word not in overrides]
