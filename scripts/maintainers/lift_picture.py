"""Draw four moments of one lift side by side: the picture in README.md.

python scripts/maintainers/lift_picture.py --checkpoint PATH [--output docs/images/lift.png] [overrides]

Approach, grasp, lift and goal of the first episode of one environment. Needs an OpenGL library and Pillow.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

from lift_lab.app import AppLauncher, cli
from lift_lab.utils.errors import LiftLabError

os.environ.setdefault("MUJOCO_GL", "egl")

EYE, LOOKAT = (0.95, -1.2, 0.62), (0.28, 0.0, 0.33)
PANEL, GAP = (400, 450), 6
"""Width and height of one moment in pixels, and the space between two."""
LIFTED_M, HALFWAY, REACHED_M = 0.028, 0.5, 0.02
"""Height of the cube's centre at the grasp, share of the way to the goal, and distance that counts as there."""
SETTLE_STEPS = 20
"""Steps from reaching the goal to the last picture."""


def parse():
    parser = cli.Parser(__doc__)
    parser.add_argument("--task", type=str, default="Lift-Cube-Franka-Play", help="id of the task")
    parser.add_argument("--checkpoint", type=Path, required=True, help="the policy")
    parser.add_argument("--seed", type=int, default=4, help="where cube and goal are")
    parser.add_argument("--output", type=Path, default=Path("docs/images/lift.png"), help="the picture")
    AppLauncher.add_app_launcher_args(parser)
    return parser.parse()


def moments(task: str, checkpoint: Path, seed: int, overrides: list[str]) -> Any:
    """A film of the four moments.

    Raises:
        LiftLabError: the episode ended before the cube was at its goal.
    """
    import gymnasium as gym
    import torch

    import lift_lab_tasks  # noqa: F401
    from lift_lab.envs.frame_capture import FrameCapture
    from lift_lab_rl.rsl_rl import LiftLabRunner, RslRlVecEnvWrapper, to_rsl_rl
    from lift_lab_tasks.utils.hydra import compose

    env_cfg, agent_cfg = compose(task, "rsl_rl_cfg_entry_point", overrides)
    env_cfg.scene.num_envs, env_cfg.seed, env_cfg.sim.device = 1, seed, "cpu"
    env_cfg.viewer.eye, env_cfg.viewer.lookat, env_cfg.viewer.resolution = EYE, LOOKAT, PANEL
    env_cfg.viewer.quality = "fine"
    env_cfg.commands.object_pose.current_pose_visualizer_cfg.markers["frame"].visible = False
    env = RslRlVecEnvWrapper(gym.make(task, cfg=env_cfg), clip_actions=agent_cfg.clip_actions)
    inner: Any = env.unwrapped
    runner = LiftLabRunner(env, to_rsl_rl(agent_cfg, env.get_observations().keys()), None, "cpu")
    runner.load_policy(str(checkpoint))
    policy = runner.get_inference_policy(device="cpu")
    capture, frames = FrameCapture(inner), []
    with torch.inference_mode():
        obs, _ = env.reset()
        start, reached = _to_goal(inner), None
        for step in range(inner.max_episode_length - 1):
            obs, *_ = env.step(policy(obs))
            height, left = float(inner.scene["object"].data.root_pos_w[0, 2]), _to_goal(inner)
            wanted = (
                step >= 8,
                height > LIFTED_M,
                height > LIFTED_M and left < HALFWAY * start,
                reached is not None and step >= reached + SETTLE_STEPS,
            )
            if reached is None and left < REACHED_M:
                reached = step
            if len(frames) < len(wanted) and wanted[len(frames)]:
                frames.append(capture.frame())
    if len(frames) < 4:
        raise LiftLabError(f"the cube did not reach its goal with seed {seed}: choose another --seed")
    made = capture.film(frames, 1.0)
    env.close()
    return made


def _to_goal(env: Any) -> float:
    """Distance of the cube to its goal in m."""
    goal_w = env.command_manager.get_term("object_pose").goal_pos_w[0]
    return float((goal_w - env.scene["object"].data.root_pos_w[0]).norm())


def draw(film: Any, output: Path) -> None:
    """Draw a film's pictures side by side into a PNG file of at most 256 colours."""
    import mujoco
    import numpy as np
    from PIL import Image

    from lift_lab.drawing.scene import SceneDrawer

    model = mujoco.MjModel.from_binary_path("film.mjb", {"film.mjb": film.model})
    drawer = SceneDrawer(model, film.width, film.height, film.origins, fine=True)
    parts: list[np.ndarray] = []
    for picture in film.pictures:
        parts += [drawer.draw(picture), np.full((film.height, GAP, 3), 255, dtype=np.uint8)]
    strip = np.concatenate(parts[:-1], axis=1)
    drawer.close()
    output.parent.mkdir(parents=True, exist_ok=True)
    Image.fromarray(strip).quantize(256).save(output, optimize=True)


def main() -> int:
    args, overrides = parse()
    draw(moments(args.task, args.checkpoint, args.seed, overrides), args.output)
    print(f"{args.output} ({args.output.stat().st_size / 1e3:.0f} kB)")
    return 0


if __name__ == "__main__":
    cli.run(main)
