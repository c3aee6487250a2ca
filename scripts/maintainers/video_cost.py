"""Measure what train.py --video costs: processor time of filming beside that of stepping, and of drawing.

python scripts/maintainers/video_cost.py [--task ID] [--num_envs 512] [--steps 100] [--length 5] [--interval 50]

Steps with random actions; the learner, which filming does not touch, is left out, so the share is of collection alone.
Processor time is of all threads of a process, so it means the same on a busy machine.
"""

from __future__ import annotations

import resource
import tempfile
import time
from pathlib import Path

from lift_lab.app import cli
from lift_lab_cli.arguments import positive


def main() -> int:
    parser = cli.Parser(__doc__, overrides=False)
    parser.add_argument("--task", default="Lift-Cube-Franka", help="id of the task")
    parser.add_argument("--num_envs", type=positive, default=512, help="number of environments")
    parser.add_argument("--steps", type=positive, default=100, help="steps to measure")
    parser.add_argument("--length", type=positive, default=5, help="steps in a video")
    parser.add_argument("--interval", type=positive, default=50, help="steps between the starts of two videos")
    parser.add_argument("--video_envs", type=positive, default=1, help="environments in the frame")
    args, _ = parser.parse()
    step_s, film_s, draw_s, videos = measure(args)
    frames = videos * args.length
    print(f"{args.steps} steps of {args.num_envs} environments, {videos} videos of {args.length} frames")
    print(f"process that collects: {step_s:.2f} s stepping, {film_s:.3f} s filming ({film_s / step_s:.2%})")
    print(f"processes that draw: {draw_s:.2f} s ({draw_s / max(1, frames):.2f} s a frame)")
    return 0


def measure(args) -> tuple[float, float, float, int]:
    """Processor seconds of stepping, of filming and of drawing, and the number of videos."""
    import gymnasium as gym
    import torch

    import lift_lab_tasks  # noqa: F401
    from lift_lab_rl.rsl_rl import RslRlVecEnvWrapper
    from lift_lab_rl.threads import use_one_torch_thread
    from lift_lab_rl.video import RecordVideo
    from lift_lab_tasks.utils import parse_env_cfg

    class Timed(gym.Wrapper):
        """Counts the processor time of the steps below it."""

        seconds = 0.0

        def step(self, action):
            start = time.process_time()
            result = self.env.step(action)
            self.seconds += time.process_time() - start
            return result

    use_one_torch_thread()
    cfg = parse_env_cfg(args.task, device="cpu", num_envs=args.num_envs)
    cfg.seed, cfg.viewer.num_envs = 1, args.video_envs
    with tempfile.TemporaryDirectory() as folder:
        bare = Timed(gym.make(args.task, cfg=cfg))
        # at normal priority: processor time is the same, and a busy machine ends the measurement
        filmed = RecordVideo(
            bare, lambda step: Path(folder) / f"step_{step}.mp4", args.interval, args.length, background=False
        )
        whole = Timed(filmed)
        env = RslRlVecEnvWrapper(whole)
        try:
            actions = torch.empty(env.num_envs, env.num_actions)
            with torch.inference_mode():
                for _ in range(args.steps):
                    env.step(actions.uniform_(-1.0, 1.0))
        finally:
            env.close()
        # read once the drawing processes have been waited for
        children = resource.getrusage(resource.RUSAGE_CHILDREN)
    if filmed.problem is not None:
        print(f"not every video was drawn: {filmed.problem}")
    return bare.seconds, whole.seconds - bare.seconds, children.ru_utime + children.ru_stime, len(filmed.files)


if __name__ == "__main__":
    cli.run(main)
