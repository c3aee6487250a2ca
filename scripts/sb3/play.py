"""Run a policy that Stable-Baselines3 trained.

python scripts/sb3/play.py --task Cartpole-Play [--checkpoint PATH] [--video] [overrides]

Takes model.zip of the newest run of the task it was trained on (without -Play) unless told otherwise.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from lift_lab.app import AppLauncher, cli
from lift_lab.app.arguments import playing_parser

LOGS = Path("logs") / "sb3"


def parse():
    parser = playing_parser(__doc__, "sb3", model="model.zip", numbered="model_N_steps.zip")
    args, overrides = parser.parse()
    if args.use_last_checkpoint and args.checkpoint is not None:
        parser.error("--use_last_checkpoint and --checkpoint both name the model: give one")
    return args, overrides, parser.given_settings(args)


def main() -> int:
    args, overrides, flags = parse()
    launcher = AppLauncher(args)

    from lift_lab_rl.extras import require_package

    require_package("stable_baselines3")
    import gymnasium as gym
    import numpy as np

    import lift_lab_tasks  # noqa: F401
    from lift_lab_rl.library_ranges import check_library_cfg
    from lift_lab_rl.sb3 import Sb3VecEnvWrapper
    from lift_lab_rl.sb3_runs import build
    from lift_lab_rl.script_steps import film_playing, print_played, print_videos
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
    parent = LOGS / (args.experiment_name or task_folder(args.task))
    last = r"model_\d+_steps\.zip"
    patterns = [last] if args.use_last_checkpoint else [r"model\.zip", last]
    checkpoint = find_model(parent, args.checkpoint, args.load_run, *patterns)
    if env_cfg.sim.device == "cpu":
        use_one_torch_thread()
    env = gym.make(args.task, cfg=env_cfg)
    try:
        steps = args.steps or env.unwrapped.max_episode_length
        if args.video:
            env = film_playing(env, checkpoint.parent / "videos" / "play" / f"{checkpoint.stem}.mp4", steps)
        agent, played, _ = build(Sb3VecEnvWrapper(env), agent_cfg, checkpoint, training=False, trust=args.trust)
        vec_env: Any = played
        print(f"policy: {checkpoint}")
        obs = vec_env.reset()
        total, returns = 0.0, []
        for _ in range(steps):
            actions, _ = agent.predict(obs, deterministic=True)
            obs, rewards, dones, infos = vec_env.step(actions)
            total += float(rewards.mean())
            returns += [infos[idx]["episode"]["r"] for idx in np.flatnonzero(dones)]
        print_played(env, steps, len(returns), total)
        if returns:
            print(f"mean return of an episode: {np.mean(returns):.3f}")
    finally:
        env.close()
        launcher.app.close()
    return print_videos(env)


if __name__ == "__main__":
    cli.run(main)
