"""Run a trained policy: ``python -m lift_lab_cli.play [--library NAME] --task TASK ...``."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from lift_lab.app import AppLauncher, cli

from .arguments import check_video_flags, library_parser
from .library import Library, Player
from .pace import Pace
from .scripted import SCRIPTED, ScriptedPlayer, check_scripted_flags, scripted_settings, video_file


def main(library: Library | None = None) -> int:
    """Play. Returns the exit status: 1 if a video is missing that was asked for.

    Args:
        library: that trained the policy; None for the one that ``--library`` names, else rsl_rl.
    """
    parser, library = library_parser(library, training=False)
    args, overrides = parser.parse()
    if args.video is not None and "=" in args.video:  # an override behind a --video without a file
        args.video, overrides = "", [args.video, *overrides]
    if args.video and not args.video.endswith(".mp4"):
        parser.error(f"--video: expected a file ending in .mp4, got '{args.video}'")
    if args.real_time and getattr(args, "replay", None) is not None:
        parser.error("--real-time paces a simulation: --replay writes a page, which plays in real time by itself")
    check_scripted_flags(parser, args)
    library.check_playing_flags(parser, args)
    check_video_flags(parser, args)
    AppLauncher(args)
    status = library.show(args, overrides)
    return _play(library, args, overrides) if status is None else status


def _play(library: Library, args: argparse.Namespace, overrides: list[str]) -> int:
    from lift_lab_rl.optional_packages import require_package

    scripted = args.agent in SCRIPTED
    if not scripted:
        require_package(library.package, library.name)
    import gymnasium as gym

    import lift_lab_tasks  # noqa: F401
    from lift_lab_rl.distributed import Place
    from lift_lab_rl.threads import use_one_torch_thread
    from lift_lab_rl.video import require_video

    if args.video is not None:
        require_video()
    settings = (
        scripted_settings(args, overrides) if scripted else library.make_settings(args, overrides, False, Place())
    )
    checkpoint = None if scripted else library.find_policy(settings, args)
    if settings.env.sim.device == "cpu":
        use_one_torch_thread()
    env: Any = gym.make(args.task, cfg=settings.env)
    try:
        args.steps = steps = args.steps or args.video_length or env.unwrapped.max_episode_length
        if args.video is not None:
            if checkpoint is None:
                default = video_file(args.task, args.agent)
            else:
                default = library.output_folder(settings, checkpoint) / "videos" / "play" / f"{checkpoint.stem}.mp4"
            env = _filmed(env, Path(args.video or default), args.video_length or steps)
        if checkpoint is None:
            player: Player = ScriptedPlayer(env, args.agent)
        else:
            player = library.player(env, settings, args, checkpoint)
        print(f"policy: {args.agent if checkpoint is None else checkpoint}")
        player.begin(print)
        reward, episodes = 0.0, 0
        pace = Pace(env.unwrapped.step_dt) if args.real_time else None
        for _ in range(steps):
            mean, ended = player.step()
            reward, episodes = reward + mean, episodes + ended
            if pace is not None:
                pace.wait()
        print(f"{steps} steps of {env.unwrapped.num_envs} environments, {episodes} episodes ended")
        if pace is not None:
            print(pace.summary())
        print(f"mean reward: {reward / (steps * env.unwrapped.step_dt):.3f} per second")
        player.end(print)
    finally:
        env.close()
    if args.video is None:
        return 0
    for path in env.files:
        print(f"video: {path}")
    return 0 if env.problem is None else 1


def _filmed(env: Any, file: Path, length: int) -> Any:
    """The environment, with one video of its first steps."""
    from lift_lab_rl.files import check_target
    from lift_lab_rl.video import RecordVideo

    check_target(file)
    return RecordVideo(env, lambda _: file, interval=1 << 60, length=length, background=False)


if __name__ == "__main__":
    cli.run(main)
