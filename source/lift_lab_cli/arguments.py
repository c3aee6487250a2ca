"""Flags of the programs, and the entries of the configurations that they set."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from lift_lab.app import AppLauncher
from lift_lab.app.cli import Parser

if TYPE_CHECKING:
    from .library import Library

COMMON_SETTINGS = {
    "num_envs": ("env.scene.num_envs",),
    "seed": ("env.seed", "agent.seed"),
    "device": ("env.sim.device", "agent.device"),
    "num_threads": ("env.sim.num_threads", "agent.num_threads"),
}
"""Fields of the configuration that the flags of every program set."""

VIDEO_SETTINGS = {
    "video_envs": ("env.viewer.num_envs",),
    "video_camera": ("env.viewer.cam_prim_path",),
    "video_rewards": ("env.viewer.show_rewards",),
}
"""Fields that the flags for the contents of a video set. Other settings of the camera are overrides of
``env.viewer``."""

VIDEO_LENGTH, VIDEO_INTERVAL = 200, 2000
"""Steps in a video of a training, and between the starts of two."""


def positive(text: str) -> int:
    """A whole number of at least 1."""
    try:
        value = int(text)
    except ValueError:
        value = 0
    if value < 1:
        raise argparse.ArgumentTypeError(f"expected a whole number of at least 1, got '{text}'")
    return value


def task_parser(description: str | None, agent: str, logs: str, agent_help: str = "") -> Parser:
    """A parser with the flags of every program that runs a task with an agent.

    Args:
        description: what the program does.
        agent: default key of the agent's configuration.
        logs: folder of the library's runs, for the help text.
        agent_help: values that --agent accepts besides a key.
    """
    parser = Parser(description)
    parser.add_argument(
        "--task",
        type=str,
        required=True,
        help="id of the task (lift-lab list shows all), or MODULE:ID of your own",
    )
    parser.add_argument(
        "--agent", type=str, default=agent, help=f"key of the agent's configuration (default: {agent}){agent_help}"
    )
    parser.add_argument("--num_envs", type=positive, default=None, help="number of environments")
    parser.add_argument("--seed", type=int, default=None, help="seed of all random numbers; -1 draws one")
    parser.add_argument(
        "--num_threads", type=positive, default=None, help="CPU threads (default: all); results do not depend on it"
    )
    parser.add_argument("--experiment_name", type=str, default=None, help=f"folder of the runs under {logs}")
    AppLauncher.add_app_launcher_args(parser)
    parser.add_argument("--disable_fabric", action="store_true", help=argparse.SUPPRESS)  # Isaac Lab's
    parser.settings |= COMMON_SETTINGS
    return parser


def library_parser(library: Library | None, training: bool) -> tuple[Parser, Library]:
    """A parser with the flags of ``train`` or ``play``, and the library.

    Args:
        library: the library; None for the one that ``--library`` on the command line names, else rsl_rl.
        training: whether the program trains.
    """
    chosen = library is None
    if library is None:
        from .library import find_library

        first = argparse.ArgumentParser(add_help=False, allow_abbrev=False)
        first.add_argument("--library", nargs="?", default="rsl_rl", const="rsl_rl")  # the parser refuses one without
        library = find_library(first.parse_known_args()[0].library)
    logs = f"logs/{library.name}" + ("" if library.continues_runs else " (default: the task's id)")
    description = library.training_help if training else library.playing_help
    agent_help = "" if training else "; zero, random: actions without a policy"
    parser = task_parser(description, f"{library.name}_cfg_entry_point", logs, agent_help)
    parser.settings |= library.flag_settings
    if chosen:
        parser.add_argument("--library", default="rsl_rl", help="learning library: name, or module:Class")
    if training:
        parser.add_argument("--run_name", type=str, default=None, help="appended to the run's folder name")
        library.add_training_flags(parser)
        text = "write io_descriptors/IO_descriptors.yaml to the run: inputs and outputs of the policy"
        parser.add_argument("--export_io_descriptors", action="store_true", help=text)
        parser.settings |= {"export_io_descriptors": ("env.export_io_descriptors",)}
        parser.add_argument("--ray-proc-id", "-rid", type=int, default=None, help=argparse.SUPPRESS)  # Isaac Lab's
        text = "record videos during the training, in another process"
        parser.add_argument("--video", action="store_true", help=text)
        text = f"steps of a video (default: {VIDEO_LENGTH}); needs --video"
        parser.add_argument("--video_length", type=positive, default=None, help=text)
        text = f"steps between the starts of two videos (default: {VIDEO_INTERVAL}); needs --video"
        parser.add_argument("--video_interval", type=positive, default=None, help=text)
    else:
        library.add_playing_flags(parser)
        parser.add_argument("--steps", type=positive, default=None, help="environment steps (default: one episode)")
        text = "run no faster than real time"
        parser.add_argument("--real-time", action="store_true", help=text)
        text = "write an mp4 (default: beside the run)"
        parser.add_argument("--video", nargs="?", const="", default=None, metavar="FILE.mp4", help=text)
        parser.add_argument("--video_length", type=positive, default=None, help="steps of the video and of the run")
    _add_video_flags(parser)
    return parser, library


# -- checkpoints of rsl_rl


def add_checkpoint_flags(parser: Parser) -> None:
    """Add the flags that say which of rsl_rl's policies acts."""
    parser.add_argument(
        "--checkpoint", type=str, default=None, help="path, latest (default), best, pretrained, or a file name"
    )
    parser.add_argument(
        "--load_run", type=str, default=None, help="regular expression of the run (default: the newest)"
    )
    parser.add_argument("--use_pretrained_checkpoint", action="store_true", help="the same as --checkpoint pretrained")


def check_checkpoint_flags(parser: Parser, args: argparse.Namespace) -> None:
    """Enter ``--use_pretrained_checkpoint`` into ``--checkpoint``, and end with one line where flags contradict.

    ``--load_run`` says nothing where ``--checkpoint`` names the policy by itself.
    """
    if args.use_pretrained_checkpoint:
        if args.checkpoint not in (None, "pretrained"):
            parser.error(
                f"--use_pretrained_checkpoint and --checkpoint {args.checkpoint} both name the policy: give one"
            )
        args.checkpoint = "pretrained"
    named = args.checkpoint is not None and (args.checkpoint == "pretrained" or Path(args.checkpoint).exists())
    if args.load_run is not None and named:
        parser.error(f"--load_run chooses among runs, but --checkpoint {args.checkpoint} names the policy: give one")


# -- videos


def _add_video_flags(parser: Parser) -> None:
    group = parser.add_argument_group("video", "eye, lookat, resolution, quality and more: env.viewer.NAME=VALUE")
    group.add_argument("--video_envs", type=positive, default=None, help="environments in the frame (default: 1)")
    group.add_argument(
        "--video_camera", type=str, default=None, metavar="NAME", help="camera of the scene (default: the free camera)"
    )
    group.add_argument("--video_rewards", action="store_true", help="write the reward terms over the picture")
    parser.settings |= VIDEO_SETTINGS


def check_video_flags(parser: Parser, args: argparse.Namespace) -> None:
    """End with one line where a flag that says what a video shows is given without ``--video``."""
    given = given_video_flags(args)
    if given and args.video in (None, False):
        parser.error(f"{given[0]} says what a video shows: add --video")


def given_video_flags(args: argparse.Namespace) -> list[str]:
    """Return the given flags for the contents of a video."""
    names = ("video_length", "video_interval", *VIDEO_SETTINGS)
    return [f"--{name}" for name in names if getattr(args, name, None)]


# -- overrides between the values of a flag


def split_overrides(words: Sequence[str]) -> tuple[list[str], list[str]]:
    """Overrides among the words of a command line, and the others: flags with several values would take both."""
    overrides = [word for word in words if _is_override(word)]
    return overrides, [word for word in words if word not in overrides]


def _is_override(word: str) -> bool:
    key, equals, _ = word.partition("=")
    owner = key.lstrip("+~").replace("/", ".").partition(".")
    return owner[0] in ("env", "agent") and bool(owner[1]) and (bool(equals) or word.startswith("~"))
