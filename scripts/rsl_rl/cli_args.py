"""Flags that the rsl_rl scripts share."""

from __future__ import annotations

import argparse

from lift_lab.app import AppLauncher, cli


def make_parser(description: str | None) -> cli.Parser:
    """A parser with the flags of every rsl_rl script.

    Args:
        description: the script's docstring.
    """
    parser = cli.Parser(description)
    parser.add_argument("--task", type=str, required=True, help="id of the task (scripts/list_envs.py shows all)")
    parser.add_argument("--agent", type=str, default="rsl_rl_cfg_entry_point", help="key of the agent's configuration")
    parser.add_argument("--num_envs", type=positive, default=None, help="number of environments")
    parser.add_argument("--seed", type=int, default=None, help="seed of everything; -1 draws one")
    parser.add_argument(
        "--num_threads", type=positive, default=None, help="CPU threads (default: all); no result depends on it"
    )
    parser.add_argument("--experiment_name", type=str, default=None, help="folder of the runs under logs/rsl_rl")
    AppLauncher.add_app_launcher_args(parser)
    return parser


def positive(text: str) -> int:
    """A whole number of at least 1."""
    try:
        value = int(text)
    except ValueError:
        value = 0
    if value < 1:
        raise argparse.ArgumentTypeError(f"expected a whole number of at least 1, got '{text}'")
    return value
