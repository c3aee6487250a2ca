"""Measure how fast a task runs: physics alone, and the whole environment with random actions, in one run.

python scripts/benchmark.py --task Lift-Cube-Franka --num_envs 1024 --steps 200 [--json FILE] [overrides]

The engine is measured on a second copy of it that is given the environment's own states and controls before every step
and takes the same physics steps, so that both see the same contacts, turn by turn in the same seconds.
"""

from __future__ import annotations

import time

START = time.perf_counter()

import json  # noqa: E402
import platform  # noqa: E402
import resource  # noqa: E402
import sys  # noqa: E402
from pathlib import Path  # noqa: E402

from lift_lab.app import AppLauncher, cli  # noqa: E402

WARM_UP = 5
"""Steps before the clock starts."""


def parse():
    parser = cli.Parser(__doc__)
    parser.add_argument("--task", type=str, required=True, help="id of the task")
    parser.add_argument("--num_envs", type=int, default=None, help="number of environments")
    parser.add_argument("--steps", type=int, default=200, help="environment steps to measure")
    parser.add_argument("--seed", type=int, default=42, help="seed of environment and actions")
    parser.add_argument("--num_threads", type=int, default=None, help="CPU threads (default: all)")
    parser.add_argument("--json", type=Path, default=None, help="file for the results")
    AppLauncher.add_app_launcher_args(parser)
    args, overrides = parser.parse()
    for name in ("num_envs", "steps", "num_threads"):
        value = getattr(args, name)
        if value is not None and value < 1:
            parser.error(f"argument --{name}: expected a whole number of at least 1, got '{value}'")
    return args, overrides


def main() -> int:
    args, overrides = parse()
    launcher = AppLauncher(args)

    import torch

    torch_s = time.perf_counter() - START
    import lift_lab_tasks  # noqa: F401

    tasks_s = time.perf_counter() - START - torch_s
    import gymnasium as gym

    from lift_lab.sim.physics import make_physics
    from lift_lab_rl.files import write_atomically
    from lift_lab_rl.threads import use_one_torch_thread
    from lift_lab_tasks.utils import runs
    from lift_lab_tasks.utils.hydra import compose

    env_cfg, _ = compose(args.task, None, overrides)
    runs.apply_flags(env_cfg, None, args, args.task, overrides)
    if env_cfg.sim.device == "cpu":
        use_one_torch_thread()
    before = time.perf_counter()
    env = gym.make(args.task, cfg=env_cfg)
    inner = env.unwrapped
    made_s = time.perf_counter() - before
    before = time.perf_counter()
    env.reset()
    reset_s = time.perf_counter() - before
    before = time.perf_counter()
    env.step(torch.zeros(inner.num_envs, inner.action_manager.total_action_dim, device=inner.device))
    first_step_s = time.perf_counter() - before

    physics = inner.sim.physics
    alone = make_physics(
        physics.model, inner.num_envs, inner.device, env_cfg.sim.physics, num_threads=env_cfg.sim.num_threads
    )
    env_s, physics_s = measure(env, physics, alone, args.steps, args.seed)
    decimation, count = inner.cfg.decimation, inner.num_envs * args.steps
    result = {
        "task": args.task,
        "num_envs": inner.num_envs,
        "steps": args.steps,
        "decimation": decimation,
        "engine": physics.name,
        "device": inner.device,
        "machine": f"{platform.processor() or platform.machine()}, Python {platform.python_version()}",
        "physics_steps_per_s": count * decimation / physics_s,
        "env_steps_per_s": count / env_s,
        "ratio": physics_s / env_s,
        "import_torch_s": torch_s,
        "import_tasks_s": tasks_s,
        "make_env_s": made_s,
        "first_reset_s": reset_s,
        "first_step_s": first_step_s,
        "peak_memory_mib": peak_memory_mib(),
    }
    if torch.device(inner.device).type == "cuda":
        result["peak_gpu_memory_mib"] = torch.cuda.max_memory_allocated(inner.device) / 2**20
    alone.close()
    env.close()
    launcher.app.close()
    show(result)
    if args.json is not None:
        write_atomically(args.json, (json.dumps(result, indent=2) + "\n").encode())
        print(f"written: {args.json}")
    return 0


def measure(env, physics, alone, steps: int, seed: int) -> tuple[float, float]:
    """Seconds that the environment and the engine alone took for ``steps`` environment steps each.

    Args:
        env: environment, after a reset.
        physics: its engine.
        alone: another engine of the same model.
        steps: environment steps to measure.
        seed: seed of the random actions.
    """
    import torch

    inner = env.unwrapped
    generator = torch.Generator(device=inner.device).manual_seed(seed)
    shape = (inner.num_envs, inner.action_manager.total_action_dim)
    cuda = torch.device(inner.device).type == "cuda"

    def now() -> float:
        if cuda:
            torch.cuda.synchronize(inner.device)
        return time.perf_counter()

    names = [name for name in ("qpos", "qvel", "act", "mocap_pos", "mocap_quat") if physics.field(name).numel()]
    env_s = physics_s = 0.0
    # Episodes of all ages, as in training.
    inner.episode_length_buf = torch.randint(
        0, inner.max_episode_length, (inner.num_envs,), generator=generator, device=inner.device
    )
    for step in range(-WARM_UP, steps):
        actions = torch.randn(shape, generator=generator, device=inner.device)
        before_step = {name: physics.field(name).reshape(inner.num_envs, -1).clone() for name in names}
        start = now()
        with torch.inference_mode():
            env.step(actions)
        middle = now()
        for name, values in before_step.items():
            alone.write(name, values)
        alone.write("ctrl", physics.field("ctrl"))
        begin = now()
        alone.step(inner.cfg.decimation)
        end = now()
        if step >= 0:
            env_s += middle - start
            physics_s += end - begin
    return env_s, physics_s


def peak_memory_mib() -> float:
    """Most memory this process ever held, in MiB."""
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak / 2**20 if sys.platform == "darwin" else peak / 2**10


def show(result: dict) -> None:
    """Print the results as a table."""
    from rich.console import Console
    from rich.table import Table

    table = Table(
        "measure", "value", title=f"{result['task']}, {result['num_envs']} environments", title_justify="left"
    )
    for key, value in result.items():
        if isinstance(value, float):
            value = f"{value:,.0f}" if value >= 1000 else f"{value:.3f}"
        table.add_row(key, str(value))
    Console().print(table)


if __name__ == "__main__":
    cli.run(main)
