"""Show a pretrained policy at work: in a browser, or as a film where there is no browser.

lift-lab demo [--task TASK] [--viewer | --video [FILE.mp4]] [flags] [overrides]

Nothing has to be trained. On a desktop the program opens the viewer's page in the browser and serves it until Ctrl-C.
Without a display, or without the package viser, it writes a film.
"""

from __future__ import annotations

import argparse
import contextlib
import importlib.util
import os
import sys
import webbrowser
from pathlib import Path
from typing import Any

from lift_lab.app import AppLauncher, cli

from .arguments import COMMON_SETTINGS, library_parser, positive
from .rsl_rl_library import RslRl, find_policy, make_runner

TASK = "Lift-Cube-Franka-CL-Play"
"""Task that is shown, unless --task names another."""

FILM = "lift_demo.mp4"
"""File of the film, in the current folder, unless --video names another."""

GOAL_SECONDS = 1.6
"""Time between two goals. Tasks draw one an episode, which leaves little to see of a policy that is fast."""

VIEWER_ENVS, FILM_ENVS = 4, 1
"""Environments that are shown, unless --num_envs says how many."""


def parse() -> tuple[argparse.Namespace, list[str]]:
    parser = cli.Parser(__doc__, multirun=False)
    parser.add_argument("--task", default=TASK, help=f"task with a pretrained policy (default: {TASK})")
    parser.add_argument("--viewer", action="store_true", help="start the viewer even without a display")
    parser.add_argument(
        "--video", nargs="?", const=FILM, default=None, metavar="FILE.mp4", help=f"write a film (default: {FILM})"
    )
    parser.add_argument("--port", type=int, default=None, help="port of the viewer (default: 8080 or any free one)")
    text = f"number of environments (default: {VIEWER_ENVS} in the viewer, {FILM_ENVS} in a film)"
    parser.add_argument("--num_envs", type=positive, default=None, help=text)
    text = "environment steps (default: until Ctrl-C in the viewer, one episode in a film)"
    parser.add_argument("--steps", type=positive, default=None, help=text)
    parser.add_argument("--seed", type=int, default=None, help="seed of the starts and goals")
    AppLauncher.add_app_launcher_args(parser)
    parser.settings |= {name: COMMON_SETTINGS[name] for name in ("seed", "device")}
    args, overrides = parser.parse()
    if args.video is not None and "=" in args.video:  # an override behind a --video without a file
        args.video, overrides = FILM, [args.video, *overrides]
    if args.video is not None and not args.video.endswith(".mp4"):
        parser.error(f"--video: expected a file ending in .mp4, got '{args.video}'")
    if args.video is not None and (args.viewer or args.port is not None):
        other = "--viewer" if args.viewer else "--port"
        parser.error(f"--video writes a film, and {other} is for the browser: give one")
    return args, overrides


def main() -> int:
    args, overrides = parse()
    AppLauncher(args)

    import lift_lab_tasks  # noqa: F401
    from lift_lab.utils.errors import MissingPackageError
    from lift_lab_tasks.utils import task_kwargs
    from lift_lab_tasks.utils.runs import find_pretrained

    task_kwargs(args.task)  # finds a wrong id
    find_pretrained(args.task)
    can_show, can_film = (importlib.util.find_spec(name) is not None for name in ("viser", "av"))
    asked = args.viewer or args.port is not None
    overrides = [*goal_overrides(args.task, overrides), *overrides]
    if asked or (args.video is None and can_show and has_display()):
        return show(args, overrides)
    if not can_film and not can_show:
        raise MissingPackageError("the demo needs viser (browser) or PyAV (film): pip install 'lift-lab[all]'")
    if args.video is None:
        reason = "there is no display" if can_show else "viser is not installed (pip install 'lift-lab[viewer]')"
        more = "; --viewer serves the browser's page all the same" if can_show else ""
        print(f"writing a film, because {reason}{more}")
    return film(args, overrides, Path(args.video or FILM))


def goal_overrides(task: str, overrides: list[str]) -> list[str]:
    """Overrides that give every command of a task a new goal after :data:`GOAL_SECONDS`.

    Args:
        task: id of the task.
        overrides: the user's; a command that they set is left alone.
    """
    from lift_lab_tasks.utils import load_cfg_from_registry

    commands = getattr(load_cfg_from_registry(task, "env_cfg_entry_point"), "commands", None)
    names = [name for name, term in vars(commands or object).items() if hasattr(term, "resampling_time_range")]
    free = [name for name in names if not any(f"env.commands.{name}" in text for text in overrides)]
    return [f"env.commands.{name}.resampling_time_range=[{GOAL_SECONDS},{GOAL_SECONDS}]" for name in free]


def has_display() -> bool:
    """Whether a browser can open a window for this user."""
    if sys.platform in ("darwin", "win32"):
        return "SSH_CONNECTION" not in os.environ
    return bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))


def show(args: argparse.Namespace, overrides: list[str]) -> int:
    """Serve the viewer until Ctrl-C, and open its page where there is a display."""
    from lift_lab.visualizers import DEFAULT_PORT, is_free

    from .watch import watch

    port = args.port
    if port is None:
        port = DEFAULT_PORT if is_free(DEFAULT_PORT) else 0
    words = ["--task", args.task, "--checkpoint", "pretrained", "--viewer", "--port", str(port)]
    words += ["--steps", str(args.steps)] if args.steps else []
    parser, _ = library_parser(RslRl(), training=False)
    played, _ = parser.parse(words)
    played.flag_settings = [*args.flag_settings, *number_of_envs(args, overrides, VIEWER_ENVS, "env.scene.num_envs")]
    return watch(played, overrides, open_page if has_display() else None)


def number_of_envs(args: argparse.Namespace, overrides: list[str], usual: int, *paths: str) -> list[cli.FlagSetting]:
    """Settings for the number of environments.

    Args:
        args: flags.
        overrides: the user's; without --num_envs they decide.
        usual: the number without either.
        paths: entries that hold it.
    """
    free = [path for path in paths if args.num_envs or not any(text.startswith(f"{path}=") for text in overrides)]
    return [cli.FlagSetting("--num_envs", path, args.num_envs or usual) for path in free]


def open_page(address: str) -> None:
    """Open a page in the user's browser; say so if there is none."""
    if not webbrowser.open(address):
        print("no browser was found: open the address by hand", flush=True)


def film(args: argparse.Namespace, overrides: list[str], file: Path) -> int:
    """Write a film of whole episodes and count their successes.

    Raises:
        LiftLabError: the film cannot be drawn or written.
    """
    import gymnasium as gym
    import torch

    from lift_lab.utils.errors import ConfigError
    from lift_lab_rl.evaluation import add_success_probe
    from lift_lab_rl.files import check_target
    from lift_lab_rl.threads import use_one_torch_thread
    from lift_lab_rl.video import RecordVideo, VideoError, require_video
    from lift_lab_rl.viewer.success import SuccessCounter
    from lift_lab_tasks.settings import Settings
    from lift_lab_tasks.utils import task_kwargs

    def say(text: str) -> None:
        if not text.startswith("warning: "):  # that becomes the error below
            print(text, flush=True)

    require_video()
    check_target(file)
    sizes = number_of_envs(args, overrides, FILM_ENVS, "env.scene.num_envs", "env.viewer.num_envs")
    settings = Settings(args.task, "rsl_rl_cfg_entry_point", overrides, [*args.flag_settings, *sizes])
    settings.resolve()
    with contextlib.suppress(ConfigError):  # not every task says what success is
        add_success_probe(settings.env, task_kwargs(args.task).get("success"))
    args.checkpoint = "pretrained"
    checkpoint = find_policy(settings, args)
    if settings.env.sim.device == "cpu":
        use_one_torch_thread()
    made: Any = gym.make(args.task, cfg=settings.env)
    try:
        steps = args.steps or made.unwrapped.max_episode_length
        made = RecordVideo(made, lambda _: file, 1 << 60, steps, background=False, say=say)
        env, runner = make_runner(made, settings.agent)
        runner.load_policy(str(checkpoint))
        policy = runner.get_inference_policy(device=settings.agent.device)
        success = SuccessCounter(made.unwrapped)
        print(f"policy: {checkpoint}", flush=True)
        succeeded: set[int] = set()
        obs, _ = env.reset()
        with torch.inference_mode():
            for _ in range(steps):
                obs, _, dones, _ = env.step(policy(obs).to(env.device))
                policy.reset(dones)
                succeeded |= {number for number in range(env.num_envs) if success.has_succeeded(number)}
                success.note(dones)
        if success.is_known:
            print(f"success: in {len(succeeded)} of {env.num_envs} environments")
        print(f"{steps} frames are drawn, about 0.1 s each without a GPU", flush=True)
    finally:
        made.close()
    if made.problem is not None:
        raise VideoError(f"{made.problem}; lift-lab demo --viewer needs only a browser")
    for path in made.files:
        print(f"film: {path}")
    return 0
