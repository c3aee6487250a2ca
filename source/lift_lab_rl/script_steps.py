"""What the training and playing scripts of all learning libraries do alike: films, a run's files, closing lines."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import gymnasium as gym

from lift_lab.app.endings import exit_status, number_of
from lift_lab.utils.io import dump_yaml

from .files import check_target
from .video import RecordVideo


def film_training(env: gym.Env, args: argparse.Namespace, run_dir: Path, say: Callable[[str], None] = print) -> gym.Env:
    """The environment, with videos of it in ``videos/train`` where the flags ask for them.

    Args:
        env: a manager-based environment.
        args: flags of :func:`~lift_lab.app.arguments.add_training_video_args`.
        run_dir: folder of the run.
        say: shows a line to the user.
    """
    if not args.video:
        return env
    folder = run_dir / "videos" / "train"
    length = min(args.video_length, args.video_interval)
    return RecordVideo(env, lambda step: folder / f"step_{step}.mp4", args.video_interval, length, say=say)


def film_playing(env: gym.Env, file: Path, length: int) -> RecordVideo:
    """The environment, with one video of its first steps.

    Args:
        env: a manager-based environment.
        file: the video.
        length: steps in it.

    Raises:
        FileError: the video cannot be written.
    """
    check_target(file)
    return RecordVideo(env, lambda _: file, interval=1 << 60, length=length, background=False)


def write_configurations(
    run_dir: Path,
    task: str,
    env_cfg: Any,
    agent_cfg: Any,
    overrides: Sequence[str],
    continues: Path | None = None,
) -> None:
    """Write what a run is made of to its folder ``params``, which is made if need be.

    Args:
        run_dir: folder of the run.
        task: the task's name.
        env_cfg: the environment's configuration.
        agent_cfg: the algorithm's.
        overrides: what the command line changed.
        continues: checkpoint of another run that this one goes on from. Kept as folder and file name, so that runs
            may be moved together.
    """
    dump_yaml(run_dir / "params" / "env.yaml", env_cfg)
    dump_yaml(run_dir / "params" / "agent.yaml", agent_cfg)
    origin = {} if continues is None else {"continues": f"{continues.parent.name}/{continues.name}"}
    dump_yaml(run_dir / "params" / "run.yaml", {"task": task, "overrides": list(overrides), **origin})


def until_interrupted(train: Callable[[], Any]) -> tuple[str, int]:
    """Train until it is done, or until Ctrl-C, SIGTERM or a lost terminal ends it.

    Returns:
        Which of them, in words for the user, and the script's exit status.
    """
    try:
        train()
    except KeyboardInterrupt as interrupt:
        return "ended early", exit_status(number_of(interrupt))
    return "finished", 0


def print_played(env: gym.Env, steps: int, episodes: int, reward: float) -> None:
    """Say what was played.

    Args:
        env: the environment.
        steps: environment steps.
        episodes: episodes that ended.
        reward: sum over the steps of the environments' mean reward.
    """
    inner: Any = env.unwrapped
    print(f"{steps} steps of {inner.num_envs} environments, {episodes} episodes ended")
    print(f"mean reward: {reward / (steps * inner.step_dt):.3f} per second")


def print_videos(env: gym.Env) -> int:
    """Name the videos of an environment that is closed, if it was filmed; returns 1 if one is missing, else 0."""
    if not isinstance(env, RecordVideo):
        return 0
    for path in env.files:
        print(f"video: {path}")
    return 0 if env.problem is None else 1
