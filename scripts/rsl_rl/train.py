"""Train a policy with rsl_rl's PPO.

python scripts/rsl_rl/train.py --task Lift-Cube-Franka [flags] [overrides]

Writes logs/rsl_rl/<experiment>/<time>[_name]/ with model_N.pt (after N iterations), model_best.pt, TensorBoard's event
files, and params/ with the configurations. Ctrl-C, SIGTERM and a lost terminal finish the iteration, save and end with
status 128 plus the signal's number. A run is continued with --resume; max_iterations counts the iterations of both.

Several processes: torchrun --nproc_per_node=2 scripts/rsl_rl/train.py --distributed ... (docs/scaling.md).
"""

from __future__ import annotations

import sys
import time

from cli_args import check_agent, make_parser, positive
from video_args import add_video_args, check_video_args

from lift_lab.app import AppLauncher, cli
from lift_lab.app.arguments import add_training_video_args, check_training_video_args

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
    parser.add_argument("--log_project_name", type=str, default=None, help="project name for wandb")
    parser.add_argument(
        "--distributed", action="store_true", help="share the gradients with the other processes of torchrun"
    )
    add_training_video_args(parser)
    add_video_args(parser)
    names = ("max_iterations", "run_name", "load_run", "logger")
    parser.settings |= {name: (f"agent.{name}",) for name in names}
    args, overrides = parser.parse()
    check_training_video_args(parser, args)
    check_video_args(parser, args)
    return args, overrides, parser.given_settings(args)


def main() -> int:
    args, overrides, flags = parse()
    launcher = AppLauncher(args)

    import gymnasium as gym
    from rich.console import Console

    import lift_lab_tasks  # noqa: F401
    from lift_lab.app.endings import exit_status
    from lift_lab.utils.errors import ConfigError
    from lift_lab_rl import distributed
    from lift_lab_rl.rsl_rl import LiftLabRunner, RslRlVecEnvWrapper, to_rsl_rl
    from lift_lab_rl.rsl_rl.progress import Progress
    from lift_lab_rl.rsl_rl.run_files import checkpoint_iteration
    from lift_lab_rl.rsl_rl.wandb_writer import require_logger
    from lift_lab_rl.script_steps import film_training, write_configurations
    from lift_lab_rl.threads import use_one_torch_thread
    from lift_lab_rl.video import require_video
    from lift_lab_tasks.settings import Settings
    from lift_lab_tasks.utils import runs

    console = Console()
    place = distributed.place(args.distributed)

    def say(text: str) -> None:
        if place.is_main:
            console.print(text, markup=False, highlight=False, soft_wrap=True)

    def warn(text: str) -> None:
        if place.is_main:
            print(text, file=sys.stderr)

    check_agent(args)
    settings = Settings(args.task, args.agent, overrides, flags)
    env_cfg, agent_cfg = settings.env, settings.agent
    require_logger(agent_cfg.logger)
    if args.log_project_name is not None:
        if agent_cfg.logger == "tensorboard":
            raise ConfigError("--log_project_name needs --logger wandb")
        settings.set("--log_project_name", f"agent.{agent_cfg.logger}_project", args.log_project_name)
    if place.is_distributed:
        for cfg in (env_cfg.sim, agent_cfg):
            cfg.num_threads = place.num_threads() if cfg.num_threads is None else cfg.num_threads
    settings.resolve(training=True)
    runs.check_run_names(agent_cfg)
    runs.note_annealing(agent_cfg, settings.given, say)
    env_cfg.sim.device, agent_cfg.device = place.device(env_cfg.sim.device), place.device(agent_cfg.device)
    args.video = args.video and place.is_main
    resume = args.resume or agent_cfg.resume
    if args.video:
        require_video()
    checkpoint = None
    if resume:
        wanted = args.checkpoint or agent_cfg.load_checkpoint
        checkpoint = runs.find_checkpoint(agent_cfg, wanted, agent_cfg.load_run, args.task, True, warn)
        runs.note_other_task(checkpoint, args.task, say)
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

    with distributed.group(place, agent_cfg.device):
        run_dir = distributed.from_main(runs.new_run_dir(agent_cfg) if place.is_main else None)
        env_cfg.log_dir = str(run_dir)
        if place.is_distributed:
            settings.seed = distributed.from_main(settings.seed) + place.rank
        fingerprint = runs.fingerprint(env_cfg, agent_cfg)
        env = None
        try:
            env = gym.make(args.task, cfg=env_cfg)
            env = film_training(env, args, run_dir, say)
            wrapped = RslRlVecEnvWrapper(env, clip_actions=agent_cfg.clip_actions)
            plain = to_rsl_rl(agent_cfg, wrapped.get_observations().keys())
            runner = LiftLabRunner(wrapped, plain, run_dir, agent_cfg.device, fingerprint, place)
            say(str(env.unwrapped))
            if checkpoint is not None:
                runner.load(str(checkpoint))
                say(f"resuming {checkpoint}: {runner.load_resume_state(checkpoint)}")
            if place.is_main:
                write_configurations(run_dir, args.task, env_cfg, agent_cfg, overrides, checkpoint)
            count = f"{place.world_size} x {wrapped.num_envs}" if place.is_distributed else wrapped.num_envs
            say(f"{args.task}: {count} environments on {wrapped.device}, seed {agent_cfg.seed}")
            say(f"writing to {run_dir}")
            say(f"started in {time.perf_counter() - START:.1f} s")
            left = agent_cfg.max_iterations - runner.current_learning_iteration
            progress = Progress(f"{args.task} {run_dir.name}", console) if place.is_main else None
            finished = runner.learn(left, init_at_random_ep_len=True, progress=progress)
            done = runner.current_learning_iteration
            end = "finished" if finished else "ended early"
            say(f"{end} after {done} iterations: {run_dir / f'model_{done}.pt'}")
            status = 0 if runner.stopped_by is None else exit_status(runner.stopped_by)
        finally:
            if env is not None:
                env.close()
            runs.discard_if_empty(run_dir)
            launcher.app.close()
    return status


if __name__ == "__main__":
    cli.run(main)
