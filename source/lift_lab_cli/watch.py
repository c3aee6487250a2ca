"""Show a policy in a browser, live or as a page that plays by itself: ``play --viewer`` and ``--replay``."""

from __future__ import annotations

import argparse
import contextlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

from lift_lab.app import cli, endings

from .arguments import given_video_flags
from .rsl_rl_library import check_agent, find_policy, make_runner
from .scripted import MOST_ENVS, SCRIPTED


def add_watching_flags(parser: argparse.ArgumentParser) -> None:
    """Add the flags of the viewer and the replay."""
    parser.add_argument("--viewer", action="store_true", help="show the policy live in a browser on this machine")
    parser.add_argument(
        "--port", type=int, default=None, help="port of the viewer (default: 8080); 0 takes any free one"
    )
    parser.add_argument(
        "--replay", type=Path, default=None, metavar="FILE.html", help="write a page that plays the episode"
    )


def check_watching_flags(parser: cli.Parser, args: argparse.Namespace) -> None:
    """End with one line where a flag would have no effect."""
    if args.port is not None and not args.viewer:
        parser.error("--port is the viewer's: add --viewer")
    video_flags = given_video_flags(args)
    if video_flags and (args.viewer or args.replay is not None):
        parser.error(f"{video_flags[0]} belongs to --video, not to --viewer and --replay")
    if args.replay is not None and args.replay.suffix != ".html":
        parser.error(f"--replay: expected a file ending in .html, got '{args.replay}'")
    if args.viewer and args.replay is not None:
        parser.error("choose one of --viewer and --replay FILE.html")


def watch(args: argparse.Namespace, overrides: list[str], ready: Callable[[str], None] | None = None) -> int:
    """Show a policy.

    Args:
        args: flags of ``play``.
        overrides: in hydra's grammar.
        ready: is called with the viewer's address once the page can be opened.

    Raises:
        LiftLabError: flags that do not go together, a port that is taken, viser missing, no checkpoint, ...
    """
    from lift_lab.utils.errors import ConfigError
    from lift_lab.visualizers import DEFAULT_PORT, open_server, require_viser
    from lift_lab_rl.files import check_target

    if args.video is not None:
        raise ConfigError("--video films off screen: leave it out with --viewer and --replay")
    require_viser()
    if args.replay is not None:
        check_target(args.replay)
        return _run(args, overrides, None)
    server = open_server(DEFAULT_PORT if args.port is None else args.port, args.task)
    try:
        return _run(args, overrides, server, ready)
    finally:
        server.stop()


def _run(args: argparse.Namespace, overrides: list[str], server, ready: Callable[[str], None] | None = None) -> int:
    import gymnasium as gym

    import lift_lab_tasks  # noqa: F401
    from lift_lab.utils.errors import ConfigError
    from lift_lab_rl.evaluation import add_success_probe
    from lift_lab_rl.threads import use_one_torch_thread
    from lift_lab_rl.viewer import ViewerSession, record_replay
    from lift_lab_tasks.settings import Settings
    from lift_lab_tasks.utils import task_kwargs

    check_agent(args)
    settings = Settings(args.task, None if args.agent in SCRIPTED else args.agent, overrides, args.flag_settings)
    settings.resolve(num_envs=min(settings.env.scene.num_envs, MOST_ENVS))
    env_cfg, agent_cfg = settings.env, settings.agent
    env_cfg.seed = 42 if env_cfg.seed is None else env_cfg.seed
    checkpoint = None if agent_cfg is None else find_policy(settings, args)
    with contextlib.suppress(ConfigError):  # not every task says what success is
        add_success_probe(env_cfg, task_kwargs(args.task).get("success"))
    if env_cfg.sim.device == "cpu":
        use_one_torch_thread()
    made = gym.make(args.task, cfg=env_cfg)
    try:
        env, policy = _policy(args, made, agent_cfg, checkpoint)
        print(f"policy: {args.agent if checkpoint is None else checkpoint}")
        if server is None:
            size = record_replay(env, policy, args.replay, args.steps or env.unwrapped.max_episode_length)
            print(f"replay: {args.replay} ({size / 1e6:.1f} MB)")
            return 0
        session = ViewerSession(env, policy, server, args.task)
        address = f"http://127.0.0.1:{server.get_port()}"
        print(f"viewer: {address} (Ctrl-C ends it)", flush=True)
        if ready is not None:
            ready(address)
        with endings.handled(session.stop):
            session.run(args.steps)
        print(f"{session.steps} steps of {env.num_envs} environments")
    finally:
        made.close()
    return 0


def _policy(args: argparse.Namespace, made: Any, agent_cfg: Any, checkpoint: Path | None) -> tuple[Any, Any]:
    """The wrapped environment and the policy."""
    from lift_lab_rl.rsl_rl import RslRlVecEnvWrapper
    from lift_lab_rl.viewer import CheckpointPolicy, RandomPolicy, ZeroPolicy

    if checkpoint is None:
        env = RslRlVecEnvWrapper(made)
        return env, ZeroPolicy(env) if args.agent == "zero" else RandomPolicy(env)
    env, runner = make_runner(made, agent_cfg)
    return env, CheckpointPolicy(runner, checkpoint, agent_cfg.device)
