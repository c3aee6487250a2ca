"""Measure one task: the parts of its start, the speed of environment and engine, and memory."""

from __future__ import annotations

import contextlib
import gc
import platform
import resource
import sys
import time
import warnings
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

if TYPE_CHECKING:
    from lift_lab.envs import ManagerBasedRLEnv

WARM_UP = 5
"""Steps before the clock starts."""


def measure_task(args: Any, overrides: list[str], start: float) -> dict[str, Any]:
    """Start a task and measure it.

    Args:
        args: flags of the program.
        overrides: in hydra's grammar.
        start: when the program began, on the clock of ``time.perf_counter``.

    Returns:
        Plain values by name.
    """
    import torch

    torch_s = time.perf_counter() - start
    import gymnasium as gym

    import lift_lab_tasks  # noqa: F401
    from lift_lab.envs import ManagerBasedEnv, ManagerBasedRLEnv
    from lift_lab.scene import InteractiveScene
    from lift_lab.sim import SimulationContext
    from lift_lab.sim.physics import make_physics
    from lift_lab.utils.errors import ConfigError
    from lift_lab_rl.threads import use_one_torch_thread
    from lift_lab_tasks.settings import Settings

    packages_s = time.perf_counter() - start - torch_s
    before = time.perf_counter()
    agent = None if args.profile_training is None else "rsl_rl_cfg_entry_point"
    settings = Settings(args.task, agent, overrides, args.flag_settings)
    settings.resolve(training=agent is not None)
    env_cfg = settings.env
    flag = "--profile" if args.profile else "--profile_training" if args.profile_training is not None else None
    if flag and env_cfg.sim.device != "cpu":
        raise ConfigError(f"{flag} counts CPU time; give --device cpu, not '{env_cfg.sim.device}'")
    configured_s = time.perf_counter() - before
    if env_cfg.sim.device == "cpu":
        use_one_torch_thread()
    held = memory_bytes(env_cfg.sim.device)
    parts: dict[str, float] = {}
    before = time.perf_counter()
    with (
        timed(parts, "scene_s", InteractiveScene, "__init__"),
        timed(parts, "compile_and_engine_s", SimulationContext, "reset"),
        timed(parts, "managers_s", ManagerBasedRLEnv, "load_managers"),
        timed(parts, "startup_events_s", ManagerBasedEnv, "_apply_startup_events"),
    ):
        env = gym.make(args.task, cfg=env_cfg)
    inner = cast("ManagerBasedRLEnv", env.unwrapped)
    made_s = time.perf_counter() - before
    before = time.perf_counter()
    env.reset()
    reset_s = time.perf_counter() - before
    before = time.perf_counter()
    env.step(torch.zeros(inner.num_envs, inner.action_manager.total_action_dim, device=inner.device))
    synchronise(inner.device)
    first_step_s = time.perf_counter() - before
    ready_s = time.perf_counter() - start
    used = memory_bytes(inner.device) - held

    physics = inner.sim.physics
    result = {
        "task": args.task,
        "num_envs": inner.num_envs,
        "steps": args.steps,
        "decimation": inner.cfg.decimation,
        "engine": physics.name,
        "device": inner.device,
        "machine": f"{platform.processor() or platform.machine()}, Python {platform.python_version()}",
        "import_torch_s": torch_s,
        "import_packages_s": packages_s,
        "configure_s": configured_s,
        "make_env_s": made_s,
        **parts,
        "first_reset_s": reset_s,
        "first_step_s": first_step_s,
        "ready_s": ready_s,
        "env_memory_bytes": used,
    }
    alone = make_physics(
        physics.model, inner.num_envs, inner.device, env_cfg.sim.physics, **physics.options_of(env_cfg.sim)
    )
    env_s, physics_s, captures = measure(env, physics, alone, args.steps, args.seed)
    alone.close()
    result |= {
        "physics_steps_per_s": inner.num_envs * args.steps * inner.cfg.decimation / physics_s,
        "env_steps_per_s": inner.num_envs * args.steps / env_s,
        "ratio": physics_s / env_s,
        "captures_while_measuring": captures,
        "peak_memory_mib": peak_memory_mib(),
    }
    if torch.device(inner.device).type == "cuda":
        result["waits_in_steps"] = host_waits(env, args.seed)
    if args.profile:
        from .step_profile import profile_steps, show_profile

        result["profile_s"] = profile_steps(env, args.steps, args.seed)
        show_profile(result["profile_s"], f"CPU time of a step of {inner.num_envs} environments")
    if args.profile_training is not None:
        from .step_profile import show_profile
        from .training_profile import profile_training

        result["profile_training_s"] = profile_training(env, settings.agent, args.profile_training)
        show_profile(result["profile_training_s"], f"CPU time of a training iteration of {inner.num_envs} environments")
    if args.memory_steps is not None:
        result["memory"] = watch_memory(env, args.memory_steps, args.seed)
    env.close()
    return result


def measure(env, physics, alone, steps: int, seed: int) -> tuple[float, float, int]:
    """Seconds that the environment and the engine alone took for ``steps`` environment steps each.

    Args:
        env: environment, after a reset.
        physics: its engine.
        alone: another engine of the same model.
        steps: environment steps to measure.
        seed: seed of the random actions.

    Returns:
        Both times, and the number of graphs that were captured meanwhile, which should be none.
    """
    import torch

    inner = cast("ManagerBasedRLEnv", env.unwrapped)
    generator = torch.Generator(device=inner.device).manual_seed(seed)
    shape = (inner.num_envs, inner.action_manager.total_action_dim)

    def now() -> float:
        synchronise(inner.device)
        return time.perf_counter()

    for name in physics.bound_fields:
        alone.field(name)
    names = [name for name in ("qpos", "qvel", "act", "mocap_pos", "mocap_quat") if physics.field(name).numel()]
    env_s = physics_s = 0.0
    graphs: dict = {}
    # Episodes of all ages, as in training.
    inner.episode_length_buf = torch.randint(
        0, inner.max_episode_length, (inner.num_envs,), generator=generator, device=inner.device
    )
    for step in range(-WARM_UP, steps):
        if step == 0:
            graphs = captured(physics)
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
    return env_s, physics_s, len(captured(physics).keys() - graphs.keys())


def captured(physics) -> dict:
    """The engine's graphs by their identity, kept alive so that no other takes it; none on the CPU's own engine."""
    return {id(graph): graph for graph in getattr(physics, "_graphs", {}).values()}


def host_waits(env, seed: int, steps: int = 20) -> dict[str, int]:
    """Count the places where the host waited for the GPU in some steps: file and line -> how often (CUDA only)."""
    import torch

    inner = cast("ManagerBasedRLEnv", env.unwrapped)
    generator = torch.Generator(device=inner.device).manual_seed(seed)
    shape = (inner.num_envs, inner.action_manager.total_action_dim)
    actions = [torch.randn(shape, generator=generator, device=inner.device) for _ in range(steps)]
    found: dict[str, int] = {}
    with warnings.catch_warnings(record=True) as caught, torch.inference_mode():
        warnings.simplefilter("always")
        torch.cuda.set_sync_debug_mode("warn")
        for action in actions:
            env.step(action)
        torch.cuda.set_sync_debug_mode("default")
    for warning in caught:
        if "synchroniz" in str(warning.message):
            place = "/".join(Path(warning.filename).parts[-2:]) + f":{warning.lineno}"
            found[place] = found.get(place, 0) + 1
    return found


def watch_memory(env, env_steps: int, seed: int) -> dict:
    """Memory of this process over many steps with random actions.

    Returns:
        ``samples``: pairs (environment steps so far, bytes); ``bytes_per_million_steps``: growth over the last four
        fifths, where caches have filled.
    """
    import torch

    inner = cast("ManagerBasedRLEnv", env.unwrapped)
    generator = torch.Generator(device=inner.device).manual_seed(seed)
    shape = (inner.num_envs, inner.action_manager.total_action_dim)
    count = max(20, -(-env_steps // inner.num_envs))
    every = max(1, count // 100)
    samples = []
    with torch.inference_mode():
        for step in range(1, count + 1):
            env.step(torch.randn(shape, generator=generator, device=inner.device))
            if step % every == 0:
                gc.collect()
                samples.append((step * inner.num_envs, memory_bytes(inner.device)))
    late = samples[len(samples) // 5 :]
    grown, steps = late[-1][1] - late[0][1], late[-1][0] - late[0][0]
    return {"samples": samples, "bytes_per_million_steps": grown / max(1, steps) * 1e6}


@contextlib.contextmanager
def timed(parts: dict[str, float], name: str, owner: type, method: str):
    """Add the seconds spent in a method to ``parts`` while the body runs."""
    original = getattr(owner, method)

    def call(*args, **kwargs):
        before = time.perf_counter()
        try:
            return original(*args, **kwargs)
        finally:
            parts[name] = parts.get(name, 0.0) + time.perf_counter() - before

    setattr(owner, method, call)
    try:
        yield
    finally:
        setattr(owner, method, original)


def synchronise(device: str) -> None:
    """Wait for a GPU."""
    import torch

    if torch.device(device).type == "cuda":
        torch.cuda.synchronize(device)


def memory_bytes(device: str) -> int:
    """Memory in use now: of the GPU, or resident memory of this process."""
    import torch

    if torch.device(device).type == "cuda":
        free, total = torch.cuda.mem_get_info(device)
        return total - free
    statm = Path("/proc/self/statm")
    if statm.is_file():
        return int(statm.read_text().split()[1]) * resource.getpagesize()
    return int(peak_memory_mib() * 2**20)


def peak_memory_mib() -> float:
    """Most memory this process ever held, in MiB."""
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak / 2**20 if sys.platform == "darwin" else peak / 2**10
