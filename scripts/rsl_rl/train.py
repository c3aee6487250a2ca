"""Train a policy with rsl_rl's PPO.

python scripts/rsl_rl/train.py --task Lift-Cube-Franka [flags] [overrides]

Writes logs/rsl_rl/<experiment>/<time>[_name]/ with model_N.pt (after N iterations), model_best.pt, TensorBoard's event
files, and params/ with the configurations. Ctrl-C finishes the iteration, saves and ends. A run is continued with
--resume; max_iterations counts the iterations of both together.
"""

from __future__ import annotations

import os
import time

from cli_args import make_parser, positive

from lift_lab.app import AppLauncher, cli

START = time.perf_counter()


def parse():
    parser = make_parser(__doc__)
    parser.add_argument("--max_iterations", type=positive, default=None, help="iterations of the whole run")
    parser.add_argument("--run_name", type=str, default=None, help="appended to the run's folder name")
    parser.add_argument("--resume", action="store_true", help="continue an earlier run (default: the newest)")
    parser.add_argument("--load_run", type=str, default=None, help="regular expression of the run to continue")
    parser.add_argument(
        "--checkpoint", type=str, default=None, help="checkpoint to continue: path, latest, best or file name"
    )
    parser.add_argument("--logger", choices=["tensorboard", "wandb", "neptune"], default=None, help="where curves go")
    parser.add_argument("--log_project_name", type=str, default=None, help="project name for wandb or neptune")
    parser.add_argument("--video", action="store_true", help="record videos while training")
    parser.add_argument("--video_length", type=positive, default=200, help="steps in a video")
    parser.add_argument("--video_interval", type=positive, default=2000, help="steps between the starts of two videos")
    return parser.parse()


def main() -> int:
    args, overrides = parse()
    launcher = AppLauncher(args)
    if args.video:
        os.environ.setdefault("MUJOCO_GL", "egl")

    import gymnasium as gym
    from rich.console import Console

    import lift_lab_tasks  # noqa: F401
    from lift_lab.utils.errors import ConfigError
    from lift_lab.utils.io import dump_yaml
    from lift_lab_rl.rsl_rl import LiftLabRunner, RslRlVecEnvWrapper, to_rsl_rl
    from lift_lab_rl.rsl_rl.progress import Progress
    from lift_lab_rl.rsl_rl.runner import checkpoint_iteration
    from lift_lab_rl.threads import use_one_torch_thread
    from lift_lab_rl.video import RecordVideo, require_video
    from lift_lab_tasks.utils import runs
    from lift_lab_tasks.utils.hydra import compose

    console = Console()

    def say(text: str) -> None:
        console.print(text, markup=False, highlight=False, soft_wrap=True)

    env_cfg, agent_cfg = compose(args.task, args.agent, overrides)
    for name in ("max_iterations", "run_name", "experiment_name", "load_run", "logger"):
        if getattr(args, name) is not None:
            setattr(agent_cfg, name, getattr(args, name))
    if args.log_project_name is not None:
        if agent_cfg.logger == "tensorboard":
            raise ConfigError("--log_project_name needs --logger wandb or neptune")
        setattr(agent_cfg, f"{agent_cfg.logger}_project", args.log_project_name)
    runs.apply_flags(env_cfg, agent_cfg, args, args.task, overrides)
    resume = args.resume or agent_cfg.resume
    if args.video:
        require_video()
    checkpoint = None
    if resume:
        checkpoint = runs.find_checkpoint(agent_cfg, args.checkpoint or agent_cfg.load_checkpoint, agent_cfg.load_run)
        done = checkpoint_iteration(checkpoint)
        if done >= agent_cfg.max_iterations:
            raise ConfigError(
                f"'{checkpoint}' has finished {done} of {agent_cfg.max_iterations} iterations; "
                f"ask for more with --max_iterations"
            )
    elif args.checkpoint or args.load_run:
        raise ConfigError("--checkpoint and --load_run continue a run: add --resume")
    if env_cfg.sim.device == "cpu":
        use_one_torch_thread()

    run_dir = runs.new_run_dir(agent_cfg)
    env_cfg.log_dir = str(run_dir)
    fingerprint = runs.fingerprint(env_cfg, agent_cfg)
    env = gym.make(args.task, cfg=env_cfg, render_mode="rgb_array" if args.video else None)
    try:
        say(str(env.unwrapped))
        if args.video:
            env = RecordVideo(env, run_dir / "videos" / "train", args.video_interval, args.video_length)
        wrapped = RslRlVecEnvWrapper(env, clip_actions=agent_cfg.clip_actions)
        plain = to_rsl_rl(agent_cfg, wrapped.get_observations().keys())
        runner = LiftLabRunner(wrapped, plain, run_dir, agent_cfg.device, fingerprint)
        if checkpoint is not None:
            runner.load(str(checkpoint))
            say(f"resuming {checkpoint}: {runner.load_resume_state(checkpoint)}")
        run_dir.mkdir(parents=True, exist_ok=True)
        dump_yaml(run_dir / "params" / "env.yaml", env_cfg)
        dump_yaml(run_dir / "params" / "agent.yaml", agent_cfg)
        dump_yaml(run_dir / "params" / "run.yaml", {"task": args.task, "overrides": list(overrides)})
        say(f"{args.task}: {wrapped.num_envs} environments on {wrapped.device}, seed {agent_cfg.seed}")
        say(f"writing to {run_dir}")
        say(f"started in {time.perf_counter() - START:.1f} s")
        left = agent_cfg.max_iterations - runner.current_learning_iteration
        progress = Progress(f"{args.task} {run_dir.name}", console)
        finished = runner.learn(left, init_at_random_ep_len=True, progress=progress)
        last = run_dir / f"model_{runner.current_learning_iteration}.pt"
        say(f"{'finished' if finished else 'ended early'} after {runner.current_learning_iteration} iterations: {last}")
    finally:
        env.close()
        launcher.app.close()
    return 0


if __name__ == "__main__":
    cli.run(main)
