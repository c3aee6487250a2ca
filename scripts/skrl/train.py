"""Train a policy with skrl.

python scripts/skrl/train.py --task Cartpole [flags] [overrides]

Writes logs/skrl/<task>/<time>_ppo_torch[_name]/ with checkpoints/agent_N.pt (after N environment steps) and
best_agent.pt, TensorBoard's event files, and params/ with the configurations. Ctrl-C saves and ends. --checkpoint
starts from the weights of an earlier agent.
"""

from __future__ import annotations

import shutil
from pathlib import Path
from types import SimpleNamespace

from lift_lab.app import AppLauncher, cli
from lift_lab.app.arguments import check_training_args, training_parser

LOGS = Path("logs") / "skrl"


def parse():
    parser = training_parser(__doc__, "skrl")
    args, overrides = parser.parse()
    check_training_args(parser, args)
    return args, overrides, parser.given_settings(args)


def main() -> int:
    args, overrides, flags = parse()
    launcher = AppLauncher(args)

    from lift_lab_rl.extras import require_package

    require_package("skrl")
    import gymnasium as gym
    from skrl.utils.runner.torch import Runner

    import lift_lab_tasks  # noqa: F401
    from lift_lab_rl.library_files import read_skrl
    from lift_lab_rl.library_ranges import check_library_cfg, check_skrl_mini_batches, refusals_of
    from lift_lab_rl.script_steps import film_training, until_interrupted, write_configurations
    from lift_lab_rl.skrl import SkrlVecEnvWrapper
    from lift_lab_rl.skrl_runs import load_agent
    from lift_lab_rl.threads import use_one_torch_thread
    from lift_lab_rl.video import require_video
    from lift_lab_tasks.settings import Settings
    from lift_lab_tasks.utils.library_runs import model_file, task_folder
    from lift_lab_tasks.utils.runs import check_run_names, discard_empty_parents, make_run_dir

    settings = Settings(args.task, args.agent, overrides, flags)
    check_library_cfg(settings.agent, args.agent)
    settings.resolve(training=True)
    env_cfg, agent_cfg = settings.env, settings.agent
    check_run_names(args)
    if args.max_iterations is not None:
        steps = args.max_iterations * agent_cfg["agent"]["rollouts"]
        settings.set("--max_iterations", "agent.trainer.timesteps", steps)
    agent_cfg["trainer"]["close_environment_at_exit"] = False
    if args.video:
        require_video()
    checkpoint = None
    if args.checkpoint:
        checkpoint = model_file(args.checkpoint)
        read_skrl(checkpoint, args.trust)  # what cannot be read is refused before anything is written
    if env_cfg.sim.device == "cpu":
        use_one_torch_thread()

    experiment = agent_cfg["agent"]["experiment"]
    parent = LOGS / (args.experiment_name or experiment["directory"] or task_folder(args.task))
    name = args.run_name or experiment["experiment_name"]
    check_run_names(SimpleNamespace(experiment_name=experiment["directory"] or None, run_name=name))
    run_dir = make_run_dir(parent, agent_cfg["agent"]["class"].lower(), "torch", name)
    experiment["directory"], experiment["experiment_name"] = str(run_dir.parent), run_dir.name
    env_cfg.log_dir = str(run_dir)
    env = None
    try:
        env = gym.make(args.task, cfg=env_cfg)
        print(env.unwrapped)
        env = film_training(env, args, run_dir)
        check_skrl_mini_batches(agent_cfg, env_cfg.scene.num_envs)
        with refusals_of("skrl"):
            runner = Runner(SkrlVecEnvWrapper(env), agent_cfg)
        if checkpoint is not None:
            load_agent(runner.agent, checkpoint, args.trust)
        write_configurations(run_dir, args.task, env_cfg, agent_cfg, overrides)
        inner = env.unwrapped
        print(f"{args.task}: {inner.num_envs} environments on {env_cfg.sim.device}, seed {agent_cfg['seed']}")
        print(f"writing to {run_dir}", flush=True)
        ended, status = until_interrupted(runner.run)
        steps = inner.common_step_counter
        last = run_dir / "checkpoints" / f"agent_{steps}.pt"
        last.parent.mkdir(exist_ok=True)
        runner.agent.save(str(last))
        print(f"{ended} after {steps} environment steps: {last}")
    finally:
        if env is not None:
            env.close()
        if not (run_dir / "params").is_dir():  # refused: skrl's agent has begun an event file
            shutil.rmtree(run_dir)
            discard_empty_parents(run_dir)
        launcher.app.close()
    return status


if __name__ == "__main__":
    cli.run(main)
