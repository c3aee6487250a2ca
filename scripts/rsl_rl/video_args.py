"""Flags of videos, which train.py and play.py share. Everything else of the camera is in ``env.viewer``."""

from __future__ import annotations

import argparse

from cli_args import positive

from lift_lab.app import cli

SETTINGS = {
    "video_envs": ("env.viewer.num_envs",),
    "video_camera": ("env.viewer.cam_prim_path",),
    "video_rewards": ("env.viewer.show_rewards",),
}
"""What the flags set."""


def add_video_args(parser: cli.Parser) -> None:
    """Add the flags that say what a video shows."""
    parser.settings |= SETTINGS
    group = parser.add_argument_group("video", "eye, lookat, resolution, quality and more: env.viewer.NAME=VALUE")
    group.add_argument("--video_envs", type=positive, default=None, help="environments in the frame (default: 1)")
    group.add_argument(
        "--video_camera", type=str, default=None, metavar="NAME", help="a camera of the scene instead of the free one"
    )
    group.add_argument("--video_rewards", action="store_true", help="write the reward terms over the picture")


def check_video_args(parser: cli.Parser, args: argparse.Namespace) -> None:
    """End with one line where a flag is given without ``--video``."""
    given = given_video_args(args)
    if given and args.video in (None, False):
        parser.error(f"{given[0]} says what a video shows: add --video")


def given_video_args(args: argparse.Namespace) -> list[str]:
    """Those of the flags that are given."""
    return [f"--{name}" for name in SETTINGS if getattr(args, name)]
