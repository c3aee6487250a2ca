"""Run a trained policy, and export it.

python scripts/rsl_rl/play.py --task TASK [--checkpoint PATH|latest|best|pretrained] [--video [FILE.mp4]] [overrides]

Takes the newest checkpoint of the newest run unless told otherwise. Writes exported/policy.pt (TorchScript) and
exported/policy.onnx beside it, both checked against the policy, and with --video an mp4.
"""

from __future__ import annotations

from pathlib import Path

from cli_args import add_checkpoint_args, check_agent, check_checkpoint_args, make_parser, positive
from video_args import add_video_args, check_video_args, given_video_args
from watching import SCRIPTED, add_watching_args, check_watching_args, is_asked, watch

from lift_lab.app import AppLauncher, cli


def parse():
    parser = make_parser(__doc__)
    add_checkpoint_args(parser)
    parser.add_argument("--steps", type=positive, default=None, help="environment steps (default: one episode)")
    parser.add_argument(
        "--video", nargs="?", const="", default=None, metavar="FILE.mp4", help="write an mp4 (default: beside the run)"
    )
    parser.add_argument("--video_length", type=positive, default=None, help="steps in the video, and to take")
    add_video_args(parser)
    add_watching_args(parser)
    args, overrides = parser.parse()
    if args.video is not None and "=" in args.video:  # an override behind a --video without a file
        args.video, overrides = "", [args.video, *overrides]
    if args.video and not args.video.endswith(".mp4"):
        parser.error(f"--video: expected a file ending in .mp4, got '{args.video}'")
    if args.video is None and args.video_length is not None:
        parser.error("--video_length says how long a video is: add --video")
    check_checkpoint_args(parser, args)
    check_watching_args(parser, args, given_video_args(args))
    check_video_args(parser, args)
    args.steps = args.steps or args.video_length
    args.video, args.video_file = args.video is not None, args.video
    return args, overrides, parser.given_settings(args)


def main() -> int:
    args, overrides, flags = parse()
    launcher = AppLauncher(args)
    if is_asked(args):
        return watch(args, overrides, flags)

    import gymnasium as gym
    import torch

    import lift_lab_tasks  # noqa: F401
    from lift_lab_rl.nonfinite import check_step
    from lift_lab_rl.rsl_rl import (
        LiftLabRunner,
        RslRlVecEnvWrapper,
        export_policy_as_jit,
        export_policy_as_onnx,
        to_rsl_rl,
    )
    from lift_lab_rl.script_steps import film_playing, print_played, print_videos
    from lift_lab_rl.threads import use_one_torch_thread
    from lift_lab_rl.video import require_video
    from lift_lab_tasks.settings import Settings
    from lift_lab_tasks.utils import runs

    if args.video:
        require_video()
    check_agent(args, *SCRIPTED)
    settings = Settings(args.task, args.agent, overrides, flags)
    settings.resolve()
    env_cfg, agent_cfg = settings.env, settings.agent
    runs.check_run_names(agent_cfg)
    checkpoint = runs.find_checkpoint(agent_cfg, args.checkpoint, args.load_run, args.task)
    runs.note_other_task(checkpoint, args.task)
    if env_cfg.sim.device == "cpu":
        use_one_torch_thread()
    env = gym.make(args.task, cfg=env_cfg)
    try:
        steps = args.steps or env.unwrapped.max_episode_length
        if args.video:
            file = Path(
                args.video_file or runs.output_dir(agent_cfg, checkpoint) / "videos" / "play" / f"{checkpoint.stem}.mp4"
            )
            env = film_playing(env, file, args.video_length or steps)
        wrapped = RslRlVecEnvWrapper(env, clip_actions=agent_cfg.clip_actions)
        runner = LiftLabRunner(wrapped, to_rsl_rl(agent_cfg, wrapped.get_observations().keys()), None, agent_cfg.device)
        runner.load_policy(str(checkpoint))
        print(f"policy: {checkpoint}")
        network = runner.alg.get_policy()
        exported = runs.output_dir(agent_cfg, checkpoint) / "exported"
        print(f"exported: {export_policy_as_jit(network, None, exported)}")
        print(f"exported: {export_policy_as_onnx(network, exported)}")

        policy = runner.get_inference_policy(device=agent_cfg.device)
        obs, _ = wrapped.reset()
        ended, total = 0, torch.zeros(wrapped.num_envs, device=wrapped.device)
        logs: dict[str, list[tuple[float, int]]] = {}
        with torch.inference_mode():
            for _ in range(steps):
                obs, rewards, dones, extras = wrapped.step(policy(obs).to(wrapped.device))
                check_step(wrapped, obs, rewards, extras)
                policy.reset(dones)
                total += rewards
                count = int(dones.sum())
                ended += count
                if count:
                    for key, value in extras["log"].items():
                        logs.setdefault(key, []).append((float(value), count))
        print_played(env, steps, ended, total.mean().item())
        for key, values in logs.items():
            mean = sum(value * weight for value, weight in values) / sum(weight for _, weight in values)
            print(f"{key}: {mean:.4f}")
    finally:
        env.close()
        launcher.app.close()
    return print_videos(env)


if __name__ == "__main__":
    cli.run(main)
