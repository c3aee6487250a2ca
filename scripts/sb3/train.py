"""Train a policy with Stable-Baselines3's PPO.

python scripts/sb3/train.py --task Cartpole [flags] [overrides]

Writes logs/sb3/<task>/<time>/ with model.zip at the end, model_N_steps.zip on the way, TensorBoard's event files, and
params/ with the configurations. Ctrl-C saves and ends. --checkpoint starts from the weights of an earlier model.
"""

from __future__ import annotations

from functools import partial
from pathlib import Path

from lift_lab.app import AppLauncher, cli
from lift_lab.app.arguments import check_training_args, positive, training_parser

LOGS = Path("logs") / "sb3"


def parse():
    parser = training_parser(__doc__, "sb3")
    parser.add_argument("--log_interval", type=positive, default=1, help="rollouts between two lines of the log")
    parser.add_argument("--save_interval", type=positive, default=1000, help="environment steps between two models")
    parser.add_argument("--keep_all_info", action="store_true", help="put the environment's log into the infos")
    args, overrides = parser.parse()
    check_training_args(parser, args)
    return args, overrides, parser.given_settings(args)


def main() -> int:
    args, overrides, flags = parse()
    launcher = AppLauncher(args)

    from lift_lab_rl.extras import require_package

    require_package("stable_baselines3")
    import gymnasium as gym
    from stable_baselines3.common.logger import configure

    import lift_lab_tasks  # noqa: F401
    from lift_lab_rl.library_files import read_sb3
    from lift_lab_rl.library_ranges import check_library_cfg
    from lift_lab_rl.sb3 import LogCallback, Sb3VecEnvWrapper
    from lift_lab_rl.sb3_runs import SaveCallback, build, save
    from lift_lab_rl.script_steps import film_training, until_interrupted, write_configurations
    from lift_lab_rl.threads import use_one_torch_thread
    from lift_lab_rl.video import require_video
    from lift_lab_tasks.settings import Settings
    from lift_lab_tasks.utils.library_runs import model_file, task_folder
    from lift_lab_tasks.utils.runs import check_run_names, discard_if_empty, make_run_dir

    settings = Settings(args.task, args.agent, overrides, flags)
    check_library_cfg(settings.agent, args.agent)
    settings.resolve(training=True)
    env_cfg, agent_cfg = settings.env, settings.agent
    check_run_names(args)
    if args.max_iterations is not None:
        samples = args.max_iterations * agent_cfg["n_steps"] * env_cfg.scene.num_envs
        settings.set("--max_iterations", "agent.n_timesteps", samples)
    if args.video:
        require_video()
    checkpoint = None
    if args.checkpoint:
        checkpoint = model_file(args.checkpoint)
        read_sb3(checkpoint, args.trust)  # what cannot be read is refused before anything is written
    if env_cfg.sim.device == "cpu":
        use_one_torch_thread()

    run_dir = make_run_dir(LOGS / (args.experiment_name or task_folder(args.task)), args.run_name)
    env_cfg.log_dir = str(run_dir)
    env = None
    try:
        env = gym.make(args.task, cfg=env_cfg)
        print(env.unwrapped)
        env = film_training(env, args, run_dir)
        wrapped = Sb3VecEnvWrapper(env, fast_variant=not args.keep_all_info)
        agent, vec_env, timesteps = build(wrapped, agent_cfg, checkpoint, trust=args.trust)
        write_configurations(run_dir, args.task, env_cfg, agent_cfg, overrides)
        print(f"{args.task}: {wrapped.num_envs} environments on {env_cfg.sim.device}, seed {agent_cfg['seed']}")
        print(f"writing to {run_dir}", flush=True)
        agent.set_logger(configure(str(run_dir), ["stdout", "tensorboard"]))
        callbacks = [SaveCallback(args.save_interval, run_dir), LogCallback()]
        learn = partial(agent.learn, timesteps, callback=callbacks, log_interval=args.log_interval)
        ended, status = until_interrupted(learn)
        save(agent, vec_env, run_dir / "model.zip")
        print(f"{ended} after {agent.num_timesteps} samples: {run_dir / 'model.zip'}")
    finally:
        if env is not None:
            env.close()
        discard_if_empty(run_dir)
        launcher.app.close()
    return status


if __name__ == "__main__":
    cli.run(main)
