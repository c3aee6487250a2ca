"""Flags that the training and playing scripts of all learning libraries share."""

from __future__ import annotations

import argparse

from .app_launcher import AppLauncher
from .cli import Parser


def task_parser(description: str | None, agent: str, logs: str) -> Parser:
    """A parser with the flags of every script that runs a task with an agent.

    Args:
        description: the script's docstring.
        agent: default key of the agent's configuration.
        logs: folder of the library's runs, for the help text.
    """
    parser = Parser(description)
    parser.add_argument("--task", type=str, required=True, help="id of the task (scripts/list_envs.py shows all)")
    parser.add_argument("--agent", type=str, default=agent, help="key of the agent's configuration")
    parser.add_argument("--num_envs", type=positive, default=None, help="number of environments")
    parser.add_argument("--seed", type=int, default=None, help="seed of everything; -1 draws one")
    parser.add_argument(
        "--num_threads", type=positive, default=None, help="CPU threads (default: all); no result depends on it"
    )
    parser.add_argument("--experiment_name", type=str, default=None, help=f"folder of the runs under {logs}")
    AppLauncher.add_app_launcher_args(parser)
    return parser


def add_training_video_args(parser: argparse.ArgumentParser) -> None:
    """Add the flags that film a training."""
    parser.add_argument("--video", action="store_true", help="record videos while training")
    parser.add_argument("--video_length", type=positive, default=200, help="steps in a video")
    parser.add_argument("--video_interval", type=positive, default=2000, help="steps between the starts of two videos")


def positive(text: str) -> int:
    """A whole number of at least 1."""
    try:
        value = int(text)
    except ValueError:
        value = 0
    if value < 1:
        raise argparse.ArgumentTypeError(f"expected a whole number of at least 1, got '{text}'")
    return value
