"""Train a policy with a learning library: ``python -m lift_lab_cli.train [--library NAME] --task TASK ...``."""

from __future__ import annotations

import argparse
import time
from pathlib import Path
from typing import Any

from lift_lab.app import AppLauncher, cli
from lift_lab.app.endings import exit_status

from .arguments import VIDEO_INTERVAL, VIDEO_LENGTH, check_video_flags, library_parser
from .library import Library, Run

START = time.perf_counter()


def main(library: Library | None = None) -> int:
    """Train. Returns the exit status: 0, or 128 plus the number of the signal that ended the training.

    Args:
        library: with which; None for the one that ``--library`` names, else rsl_rl.
    """
    parser, library = library_parser(library, training=True)
    args, overrides = parser.parse()
    check_video_flags(parser, args)
    library.check_training_flags(parser, args)
    AppLauncher(args)

    from lift_lab_rl.optional_packages import require_package

    require_package(library.package, library.name)
    import gymnasium as gym
    from rich.console import Console

    import lift_lab_tasks  # noqa: F401
    from lift_lab_rl import distributed
    from lift_lab_rl.run_params import write_params
    from lift_lab_rl.threads import use_one_torch_thread
    from lift_lab_rl.video import require_video
    from lift_lab_tasks.utils.runs import discard_unused, fingerprint

    console = Console()
    place = distributed.place(getattr(args, "distributed", False))

    def say(text: str) -> None:
        if place.is_main:
            console.print(text, markup=False, highlight=False, soft_wrap=True)

    settings = library.make_settings(args, overrides, True, place)
    args.video = args.video and place.is_main
    if args.video:
        require_video()
    checkpoint = library.find_start(settings, args, place)
    if settings.env.sim.device == "cpu":
        use_one_torch_thread()

    with distributed.group(place, getattr(settings.agent, "device", settings.env.sim.device)):
        folder = distributed.from_main(library.new_folder(settings, args) if place.is_main else None)
        settings.env.log_dir = str(folder)
        settings.env.export_io_descriptors = settings.env.export_io_descriptors and place.is_main
        if place.is_distributed:
            seed = distributed.from_main(settings.seed)
            settings.seed = None if seed is None else seed + place.rank
        run = Run(args, settings, folder, checkpoint, fingerprint(settings.env, settings.agent), place, console)
        env = None
        try:
            env = _filmed(gym.make(args.task, cfg=settings.env), args, folder, say)
            training = library.training(env, run)
            say(str(env.unwrapped))
            if settings.env.export_io_descriptors:
                say(f"IO descriptors: {folder / 'io_descriptors' / 'IO_descriptors.yaml'}")
            training.begin(say)
            if place.is_main:
                continues = checkpoint if library.continues_runs else None
                write_params(folder, args.task, settings.env, settings.agent, overrides, continues)
            inner: Any = env.unwrapped
            count = f"{place.world_size} x {inner.num_envs}" if place.is_distributed else inner.num_envs
            say(f"{args.task}: {count} environments on {settings.env.sim.device}, seed {settings.seed}")
            say(f"writing to {folder}")
            say(f"started in {time.perf_counter() - START:.1f} s")
            stopped_by = training.learn()
            say(f"{'finished' if stopped_by is None else 'ended early'} {training.finish()}")
        finally:
            if env is not None:
                env.close()
            discard_unused(folder)
    return 0 if stopped_by is None else exit_status(stopped_by)


def _filmed(env: Any, args: argparse.Namespace, folder: Path, say: Any) -> Any:
    """The environment, with videos of it in ``videos/train`` where the flags ask for them."""
    from lift_lab_rl.video import RecordVideo

    if not args.video:
        return env
    videos = folder / "videos" / "train"
    interval = args.video_interval or VIDEO_INTERVAL
    length = min(args.video_length or VIDEO_LENGTH, interval)
    return RecordVideo(env, lambda step: videos / f"step_{step}.mp4", interval, length, say=say)


if __name__ == "__main__":
    cli.run(main)
