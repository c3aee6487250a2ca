"""Flags of videos, which train.py and play.py share. Everything else of the camera is in ``env.viewer``."""

from __future__ import annotations

import argparse
from typing import Any

from cli_args import positive


def add_video_args(parser: argparse.ArgumentParser) -> None:
    """Add the flags that say what a video shows."""
    group = parser.add_argument_group("video", "eye, lookat, resolution, quality and more: env.viewer.NAME=VALUE")
    group.add_argument("--video_envs", type=positive, default=None, help="environments in the frame (default: 1)")
    group.add_argument(
        "--video_camera", type=str, default=None, metavar="NAME", help="a camera of the scene instead of the free one"
    )
    group.add_argument("--video_rewards", action="store_true", help="write the reward terms over the picture")


def given_video_args(args: argparse.Namespace) -> list[str]:
    """Those of the flags that are given."""
    return [f"--{name}" for name in ("video_envs", "video_camera", "video_rewards") if getattr(args, name)]


def apply_video_args(args: argparse.Namespace, env_cfg: Any) -> None:
    """Write the flags into the environment's viewer.

    Raises:
        ConfigError: a flag without ``--video``.
    """
    from lift_lab.utils.errors import ConfigError

    given = given_video_args(args)
    if not args.video:
        if given:
            raise ConfigError(f"{given[0]} says what a video shows: add --video")
        return
    if args.video_envs is not None:
        env_cfg.viewer.num_envs = args.video_envs
    if args.video_camera is not None:
        env_cfg.viewer.cam_prim_path = args.video_camera
    if args.video_rewards:
        env_cfg.viewer.show_rewards = True
