"""Flags that the training and playing scripts of all learning libraries share."""

from __future__ import annotations

import argparse

from .app_launcher import AppLauncher
from .cli import Parser

TRAINING_VIDEO = {"video_length": 200, "video_interval": 2000}
"""Flags of the videos of a training and their defaults, in steps."""


COMMON_SETTINGS = {
    "num_envs": ("env.scene.num_envs",),
    "seed": ("env.seed", "agent.seed"),
    "device": ("env.sim.device", "agent.device"),
    "num_threads": ("env.sim.num_threads", "agent.num_threads"),
}
"""What the flags of every script set, where a configuration has it."""


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
    parser.settings |= COMMON_SETTINGS
    return parser


def training_parser(description: str | None, library: str) -> Parser:
    """A parser with the flags of the script that trains with a library whose configuration is a dictionary.

    Args:
        description: the script's docstring.
        library: its short name: ``sb3``, ``skrl``.
    """
    parser = _library_parser(description, library)
    parser.add_argument("--max_iterations", type=positive, default=None, help="rollouts")
    parser.add_argument("--run_name", type=str, default=None, help="appended to the run's folder name")
    parser.add_argument("--checkpoint", type=str, default=None, help="model to start from: path")
    add_training_video_args(parser)
    return parser


def check_training_args(parser: Parser, args: argparse.Namespace) -> None:
    """End with one line where flags of :func:`training_parser`'s parser disagree."""
    if args.trust and args.checkpoint is None:
        parser.error("--trust says how a checkpoint is read: add --checkpoint")
    check_training_video_args(parser, args)


def playing_parser(description: str | None, library: str, model: str, numbered: str) -> Parser:
    """A parser with the flags of the script that plays what :func:`training_parser`'s trained.

    Args:
        description: the script's docstring.
        library: its short name.
        model: name of the file that is played unless told otherwise, for the help text.
        numbered: name of the files that were saved on the way, for the help text.
    """
    parser = _library_parser(description, library)
    parser.add_argument("--checkpoint", type=str, default=None, help="path, or regular expression of the file name")
    parser.add_argument("--load_run", type=str, default=None, help="regular expression of the run (default: newest)")
    parser.add_argument("--use_last_checkpoint", action="store_true", help=f"the last {numbered}, not {model}")
    parser.add_argument("--steps", type=positive, default=None, help="environment steps (default: one episode)")
    parser.add_argument("--video", action="store_true", help="write an mp4 of all steps")
    return parser


def _library_parser(description: str | None, library: str) -> Parser:
    parser = task_parser(description, f"{library}_cfg_entry_point", f"logs/{library} (default: the task's id)")
    parser.add_argument(
        "--trust", action="store_true", help="read a checkpoint that holds pickled objects: this runs code in the file"
    )
    return parser


def add_training_video_args(parser: argparse.ArgumentParser) -> None:
    """Add the flags that film a training."""
    parser.add_argument("--video", action="store_true", help="make videos while training, in a process of their own")
    length, interval = TRAINING_VIDEO.values()
    parser.add_argument(
        "--video_length", type=positive, default=None, help=f"steps in a video (default: {length}); needs --video"
    )
    parser.add_argument(
        "--video_interval",
        type=positive,
        default=None,
        help=f"steps between the starts of two videos (default: {interval}); needs --video",
    )


def check_training_video_args(parser: Parser, args: argparse.Namespace) -> None:
    """End with one line where a flag of the videos is given without ``--video``; set the others to their defaults."""
    for name, default in TRAINING_VIDEO.items():
        if getattr(args, name) is not None and not args.video:
            parser.error(f"--{name} says what a video shows: add --video")
        setattr(args, name, getattr(args, name) or default)


def positive(text: str) -> int:
    """A whole number of at least 1."""
    try:
        value = int(text)
    except ValueError:
        value = 0
    if value < 1:
        raise argparse.ArgumentTypeError(f"expected a whole number of at least 1, got '{text}'")
    return value
