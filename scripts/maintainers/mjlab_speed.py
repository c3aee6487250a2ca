"""Speed of mjlab's lift task; scripts/maintainers/mjlab_compare.py runs this in mjlab's own virtual environment.

python mjlab_speed.py --num_envs 256 --steps 50 --device cpu --json FILE
"""

from __future__ import annotations

import argparse
import contextlib
import json
import os
import sys
import time
from importlib import metadata

parser = argparse.ArgumentParser()
parser.add_argument("--task", default="Mjlab-Lift-Cube-Yam")
parser.add_argument("--num_envs", type=int, required=True)
parser.add_argument("--steps", type=int, required=True)
parser.add_argument("--warm_up", type=int, default=5)
parser.add_argument("--seed", type=int, default=42)
parser.add_argument("--device", required=True)
parser.add_argument("--json", required=True)
args = parser.parse_args()

START = time.perf_counter()
os.environ.setdefault("MUJOCO_GL", "disable")  # mjlab asks for EGL, which a machine without a screen may lack
with contextlib.redirect_stdout(sys.stderr):
    import mjlab.tasks  # noqa: F401  # pyright: ignore[reportMissingImports]
    import torch
    from mjlab.envs import ManagerBasedRlEnv  # pyright: ignore[reportMissingImports]
    from mjlab.tasks.registry import load_env_cfg  # pyright: ignore[reportMissingImports]
    from mjlab.utils.torch import configure_torch_backends  # pyright: ignore[reportMissingImports]

    # as its own train script does
    configure_torch_backends()
    cfg = load_env_cfg(args.task)
    cfg.scene.num_envs = args.num_envs
    cfg.seed = args.seed
    env = ManagerBasedRlEnv(cfg, args.device)
    env.reset()
generator = torch.Generator(device=args.device).manual_seed(args.seed)
shape = (args.num_envs, env.action_manager.total_action_dim)
# Episodes of all ages, as in training.
env.episode_length_buf = torch.randint(
    0, env.max_episode_length, (args.num_envs,), generator=generator, device=args.device
)


def now() -> float:
    """The time, once the device has done everything."""
    if args.device.startswith("cuda"):
        torch.cuda.synchronize(args.device)
    return time.perf_counter()


env_s = physics_s = 0.0
ready_s = 0.0
with torch.inference_mode():
    for step in range(-args.warm_up, args.steps):
        actions = torch.randn(shape, generator=generator, device=args.device)
        begin = now()
        env.step(actions)
        middle = now()
        if step == -args.warm_up:
            ready_s = middle - START
        for _ in range(cfg.decimation):
            env.sim.step()
        end = now()
        if step >= 0:
            env_s += middle - begin
            physics_s += end - middle
count = args.num_envs * args.steps
result = {
    "task": args.task,
    "num_envs": args.num_envs,
    "steps": args.steps,
    "decimation": cfg.decimation,
    "timestep_s": cfg.sim.mujoco.timestep,
    "device": args.device,
    "env_steps_per_s": count / env_s,
    "physics_steps_per_s": count * cfg.decimation / physics_s,
    "ready_s": ready_s,
    "versions": {name: metadata.version(name) for name in ("mjlab", "mujoco", "mujoco-warp", "warp-lang", "torch")},
}
with open(args.json, "w") as file:
    json.dump(result, file)
