"""Run a policy that skrl trained.

python scripts/skrl/play.py --task Cartpole-Play [--checkpoint PATH] [--video] [overrides]

Takes best_agent.pt of the newest run of the task (without -Play) unless told otherwise.
"""

from __future__ import annotations

from pathlib import Path

from lift_lab.app import AppLauncher, cli
from lift_lab.app.arguments import playing_parser

LOGS = Path("logs") / "skrl"


def parse():
    parser = playing_parser(__doc__, "skrl", model="best_agent.pt", numbered="agent_N.pt")
    args, overrides = parser.parse()
    if args.use_last_checkpoint and args.checkpoint is not None:
        parser.error("--use_last_checkpoint and --checkpoint both name the model: give one")
    return args, overrides, parser.given_settings(args)


def main() -> int:
    args, overrides, flags = parse()
    launcher = AppLauncher(args)

    from lift_lab_rl.extras import require_package

    require_package("skrl")
    import gymnasium as gym
    import torch
    from skrl.utils.runner.torch import Runner

    import lift_lab_tasks  # noqa: F401
    from lift_lab_rl.library_ranges import check_library_cfg, refusals_of
    from lift_lab_rl.script_steps import film_playing, print_played, print_videos
    from lift_lab_rl.skrl import SkrlVecEnvWrapper
    from lift_lab_rl.skrl_runs import load_agent
    from lift_lab_rl.threads import use_one_torch_thread
    from lift_lab_rl.video import require_video
    from lift_lab_tasks.settings import Settings
    from lift_lab_tasks.utils.library_runs import find_model, task_folder
    from lift_lab_tasks.utils.runs import check_run_names

    if args.video:
        require_video()
    settings = Settings(args.task, args.agent, overrides, flags)
    check_library_cfg(settings.agent, args.agent)
    settings.resolve()
    env_cfg, agent_cfg = settings.env, settings.agent
    check_run_names(args)
    experiment = agent_cfg["agent"]["experiment"]
    parent = LOGS / (args.experiment_name or experiment["directory"] or task_folder(args.task))
    last = r"agent_\d+\.pt"
    patterns = [last] if args.use_last_checkpoint else [r"best_agent\.pt", last]
    checkpoint = find_model(parent, args.checkpoint, args.load_run, *patterns, folder="checkpoints")
    experiment["write_interval"] = experiment["checkpoint_interval"] = 0
    agent_cfg["trainer"]["close_environment_at_exit"] = False
    if env_cfg.sim.device == "cpu":
        use_one_torch_thread()
    env = gym.make(args.task, cfg=env_cfg)
    try:
        steps = args.steps or env.unwrapped.max_episode_length
        if args.video:
            env = film_playing(env, checkpoint.parents[1] / "videos" / "play" / f"{checkpoint.stem}.mp4", steps)
        wrapped = SkrlVecEnvWrapper(env)
        with refusals_of("skrl"):
            agent = Runner(wrapped, agent_cfg).agent
        load_agent(agent, checkpoint, args.trust)
        agent.enable_training_mode(False, apply_to_models=True)
        print(f"policy: {checkpoint}")
        obs, _ = wrapped.reset()
        total, ended = 0.0, 0
        with torch.inference_mode():
            for step in range(steps):
                actions, outputs = agent.act(obs, wrapped.state(), timestep=step, timesteps=steps)
                obs, rewards, terminated, truncated, _ = wrapped.step(outputs.get("mean_actions", actions))
                total += float(rewards.mean())
                ended += int((terminated | truncated).sum())
        print_played(env, steps, ended, total)
    finally:
        env.close()
        launcher.app.close()
    return print_videos(env)


if __name__ == "__main__":
    cli.run(main)
