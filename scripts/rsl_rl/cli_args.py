"""Flags that the rsl_rl scripts share."""

from __future__ import annotations

import argparse

from lift_lab.app import cli
from lift_lab.app.arguments import positive, task_parser

__all__ = ["add_checkpoint_args", "make_parser", "positive"]


def make_parser(description: str | None) -> cli.Parser:
    """A parser with the flags of every rsl_rl script.

    Args:
        description: the script's docstring.
    """
    return task_parser(description, "rsl_rl_cfg_entry_point", "logs/rsl_rl")


def add_checkpoint_args(parser: argparse.ArgumentParser) -> None:
    """Add the flags that say which policy acts."""
    parser.add_argument(
        "--checkpoint", type=str, default=None, help="path, latest (default), best, pretrained, or a file name"
    )
    parser.add_argument(
        "--load_run", type=str, default=None, help="regular expression of the run (default: the newest)"
    )
