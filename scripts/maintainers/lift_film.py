"""Make the moving pictures of README.md and of the documentation's first page.

python scripts/maintainers/lift_film.py [--output docs/images/lift] [--num_envs N] [--seed N] [overrides]

Films one episode of a pretrained policy in several environments, and writes OUTPUT.webp and OUTPUT.mp4. Needs PyAV,
and what drawing needs (docs/films.md). With 2 CPU cores it takes about two minutes.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from lift_lab.app import AppLauncher, cli
from lift_lab.utils.errors import LiftLabError
from lift_lab_cli.arguments import positive

LOOKAT, DISTANCE, AZIMUTH_DEG, ELEVATION_DEG, SPACING = (0.92, 1.38, 0.1), 3.7, 125.0, -22.0, 1.7
"""The camera, in m and degrees, and the distance between two environments in m."""
SIZE, SMOOTH = (720, 405), 2
"""Width and height of a frame, and how much larger it is drawn."""
GOAL_S = 1.25
"""Time in s after which every environment draws a new goal."""
EVERY, QUALITY, CRF = 2, 62, 24
"""Environment steps in a frame, and the quality of the two files."""


def parse():
    parser = cli.Parser(__doc__)
    parser.add_argument("--task", type=str, default="Lift-Cube-Franka-CL-Play", help="id of the task")
    parser.add_argument("--checkpoint", type=str, default="pretrained", help="the policy")
    parser.add_argument("--num_envs", type=positive, default=6, help="environments in the frame")
    parser.add_argument("--seed", type=int, default=4, help="where cubes and goals are")
    parser.add_argument("--output", type=Path, default=Path("docs/images/lift"), help="the files, without ending")
    AppLauncher.add_app_launcher_args(parser)
    return parser.parse()


def film(args: Any, overrides: list[str]) -> Any:
    """A film of one episode in every environment.

    Raises:
        LiftLabError: a cube did not reach its goal.
    """
    import gymnasium as gym
    import torch

    import lift_lab_tasks  # noqa: F401
    from lift_lab.envs.frame_capture import FrameCapture
    from lift_lab_cli.rsl_rl_library import make_runner
    from lift_lab_tasks.utils.hydra import compose
    from lift_lab_tasks.utils.runs import find_checkpoint

    env_cfg, agent_cfg = compose(args.task, "rsl_rl_cfg_entry_point", overrides)
    env_cfg.scene.num_envs, env_cfg.scene.env_spacing = args.num_envs, SPACING
    env_cfg.seed, env_cfg.sim.device, agent_cfg.device = args.seed, "cpu", "cpu"
    viewer = env_cfg.viewer
    viewer.num_envs, viewer.resolution = args.num_envs, (SIZE[0] * SMOOTH, SIZE[1] * SMOOTH)
    env_cfg.commands.object_pose.resampling_time_range = (GOAL_S, GOAL_S)
    env_cfg.commands.object_pose.current_pose_visualizer_cfg.markers["frame"].visible = False
    env, runner = make_runner(gym.make(args.task, cfg=env_cfg), agent_cfg)
    inner: Any = env.unwrapped
    runner.load_policy(str(find_checkpoint(agent_cfg, args.checkpoint, ".*", args.task)))
    policy = runner.get_inference_policy(device="cpu")
    capture, frames = FrameCapture(inner), []
    with torch.inference_mode():
        obs, _ = env.reset()
        for step in range(inner.max_episode_length - 1):
            if step % EVERY == 0:
                frames.append(capture.frame())
            obs, *_ = env.step(policy(obs))
    goals_w = inner.command_manager.get_term("object_pose").goal_pos_w
    left = (goals_w - inner.scene["object"].data.root_pos_w).norm(dim=1)
    if left.max() > 0.05:
        missed = ", ".join(f"{distance:.2f}" for distance in left.tolist())
        raise LiftLabError(f"with seed {args.seed} the cubes end {missed} m from their goals: choose another --seed")
    made = capture.film(frames, 1.0 / (inner.step_dt * EVERY))
    env.close()
    return made


def draw(film: Any, output: Path) -> list[Path]:
    """Draw a film into a WebP picture and an mp4 video. Returns the files."""
    import mujoco
    import numpy as np
    from PIL import Image

    from lift_lab.drawing.framing import View
    from lift_lab.drawing.mp4 import Mp4Writer
    from lift_lab.drawing.scene import SceneDrawer

    model = mujoco.MjModel.from_binary_path("film.mjb", {"film.mjb": film.model})
    drawer = SceneDrawer(model, film.width, film.height, film.origins, fine=True)
    drawn = []
    for picture in film.pictures:
        picture.view = View(LOOKAT, DISTANCE, AZIMUTH_DEG, ELEVATION_DEG)
        drawn.append(Image.fromarray(drawer.draw(picture)).resize(SIZE, Image.Resampling.LANCZOS))
    drawer.close()
    output.parent.mkdir(parents=True, exist_ok=True)
    webp, video = output.with_suffix(".webp"), output.with_suffix(".mp4")
    first, *others = drawn
    duration_ms = round(1000 / film.fps)
    first.save(webp, save_all=True, append_images=others, duration=duration_ms, loop=0, quality=QUALITY, method=6)
    writer = Mp4Writer(video, film.fps, crf=CRF)
    for image in drawn:
        writer.add(np.asarray(image))
    writer.close()
    return [webp, video]


def main() -> int:
    args, overrides = parse()
    for file in draw(film(args, overrides), args.output):
        print(f"{file} ({file.stat().st_size / 1e3:.0f} kB)")
    return 0


if __name__ == "__main__":
    cli.run(main)
