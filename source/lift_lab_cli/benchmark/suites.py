"""Sets of measurements for ``lift-lab benchmark``, each in a process of its own.

``scale``: speed and memory over the number of environments. ``startup``: where the time before the first step goes.
``gpu``: everything that a machine with a GPU is wanted for, in one call. Results are written after every measurement,
so that a call that is cut short keeps what it has.
"""

from __future__ import annotations

import json
import os
import platform
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from importlib import metadata
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table

from lift_lab.utils.errors import ConfigError, LiftLabError
from lift_lab_rl.files import write_atomically

PROGRAM = [sys.executable, "-m", "lift_lab_cli"]
"""Runs the commands of this package in a process of their own."""

SCALE_SIZES = [64, 256, 1024, 4096, 16384]
GPU_SIZES = [1024, 4096, 16384]
MEMORY_ENVS = 64
"""Environments of the run that watches memory."""

ENOUGH = 0.95
"""Share of episodes that must succeed for the task to count as learnt."""

EPISODES = 100


class Results:
    """Results so far, in a file as soon as they are there."""

    def __init__(self, args: Any):
        self.path: Path | None = args.json
        self.content: dict[str, Any] = {"suite": args.suite, "task": args.task, "machine": machine(args.device)}

    def put(self, name: str, value: Any) -> None:
        """Keep a result; say so."""
        self.content[name] = value
        if self.path is not None:
            write_atomically(self.path, (json.dumps(self.content, indent=2) + "\n").encode())


def run_suite(args: Any, overrides: list[str]) -> dict[str, Any]:
    """Run the suite ``args.suite``; returns its results.

    Raises:
        ConfigError: the suite 'gpu' on a machine without a GPU, unless the flags name the device.
    """
    if args.suite == "gpu" and args.device in (None, "auto"):
        from lift_lab.sim.simulation_context import resolve_device

        if resolve_device("auto") == "cpu":
            raise ConfigError(
                "--suite gpu needs a GPU, and torch finds none here; --device cpu measures the CPU instead"
            )
    results = Results(args)
    {"scale": scale, "startup": startup, "gpu": gpu}[args.suite](args, overrides, results)
    if results.path is not None:
        print(f"written: {results.path}")
    return results.content


def scale(args: Any, overrides: list[str], results: Results) -> None:
    """Speed and bytes per environment for each size; memory over many steps at a small one."""
    if args.plot is not None:
        require_matplotlib()
    rows = []
    for size in args.sizes or SCALE_SIZES:
        rows.append(one(args, overrides, size, args.steps))
        results.put("sizes", rows)
    show_sizes(rows, args.task)
    if args.plot is not None:
        plot(rows, args.plot, args.task)
        print(f"written: {args.plot}")
    watched = one(args, overrides, MEMORY_ENVS, 1, ["--memory_steps", str(args.memory_steps or 1_000_000)])
    results.put("memory", {"num_envs": MEMORY_ENVS, **watched.get("memory", watched)})
    if "memory" in watched:
        growth = watched["memory"]["bytes_per_million_steps"]
        print(f"memory over {watched['memory']['samples'][-1][0]:,} steps: {growth:,.0f} bytes per million steps")


def startup(args: Any, overrides: list[str], results: Results) -> None:
    """Measure the time before the first step by its parts, and ``lift-lab train`` to its first iteration; the best of
    three."""
    sizes = args.sizes or [args.num_envs or 512]
    names = ("import_torch_s", "import_packages_s", "configure_s", "make_env_s", "scene_s", "compile_and_engine_s")
    names += ("managers_s", "startup_events_s", "first_reset_s", "first_step_s", "ready_s")
    table = Table("part", *(f"{size} environments" for size in sizes), title=f"{args.task}: start, in s")
    best: dict[int, dict[str, float]] = {}
    for size in sizes:
        runs = [one(args, overrides, size, 1) for _ in range(3)]
        whole = [run for run in runs if "error" not in run]
        if not whole:
            raise LiftLabError(f"no run with {size} environments succeeded: {runs[0]['error']}")
        best[size] = {name: min(run[name] for run in whole if name in run) for name in names if name in whole[0]}
        best[size]["first_iteration_s"] = min(first_iteration_s(args, overrides, size) for _ in range(2))
        results.put("startup", {str(key): value for key, value in best.items()})
    for name in best[sizes[0]]:
        table.add_row(name.removesuffix("_s").replace("_", " "), *(f"{best[size][name]:.2f}" for size in sizes))
    Console().print(table)


def gpu(args: Any, overrides: list[str], results: Results) -> None:
    """Compile times, speed over sizes beside the engine's own graph, captures and waits, and time to learn the task."""
    environ = dict(os.environ)
    if args.cold:
        folder = Path(tempfile.mkdtemp(prefix="warp-cache-"))
        environ["WARP_CACHE_PATH"] = str(folder)
        cold = one(args, overrides, args.num_envs or 4096, 1, environ=environ)
        results.put("first_start", {**cold, "kernel_cache_bytes": sum(f.stat().st_size for f in folder.rglob("*.*"))})
    rows = []
    for size in args.sizes or GPU_SIZES:
        rows.append(one(args, overrides, size, args.steps, environ=environ))
        results.put("sizes", rows)
    show_sizes(rows, args.task)
    for row in rows:
        if row.get("captures_while_measuring"):
            print(f"{row['num_envs']} environments: {row['captures_while_measuring']} graphs captured while measuring")
        for place, count in row.get("waits_in_steps", {}).items():
            print(f"{row['num_envs']} environments: the host waited {count} times in 20 steps at {place}")
    results.put("training", time_to_learn(args, overrides, environ, results))


# -- measurements


def one(
    args: Any,
    overrides: list[str],
    num_envs: int,
    steps: int,
    more: list[str] | None = None,
    environ: dict[str, str] | None = None,
) -> dict[str, Any]:
    """One run of ``lift-lab benchmark`` in a process of its own: its results, or ``error``."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "result.json"
        flags = [f"--num_envs={num_envs}", f"--steps={steps}", f"--seed={args.seed}", f"--json={file}", *(more or [])]
        flags += [*shared(args), *(text for text in overrides if not text.startswith("agent."))]
        begin = time.perf_counter()
        done = subprocess.run(
            [*PROGRAM, "benchmark", f"--task={args.task}", *flags],
            env=environ,
            capture_output=True,
            text=True,
        )
        seconds = time.perf_counter() - begin
        if done.returncode == 0:
            result = json.loads(file.read_text())
            speed = f"{result['env_steps_per_s']:,.0f} environment steps/s, {result['ratio']:.2f} of the engine"
            print(f"{num_envs} environments: {speed} ({seconds:.0f} s)", flush=True)
            return result
    error = (done.stderr.strip().splitlines() or [f"exit status {done.returncode}"])[-1]
    print(f"{num_envs} environments: {error}", flush=True)
    return {"num_envs": num_envs, "error": error}


def shared(args: Any) -> list[str]:
    """Flags that every process gets."""
    given = {"device": args.device, "num_threads": args.num_threads}
    return [f"--{name}={value}" for name, value in given.items() if value is not None]


def first_iteration_s(args: Any, overrides: list[str], num_envs: int) -> float:
    """Seconds from starting ``lift-lab train`` to the end of its first iteration."""
    with tempfile.TemporaryDirectory() as folder:
        begin = time.perf_counter()
        process = start_training(args, overrides, num_envs, ["--max_iterations=1"], folder, dict(os.environ))
        assert process.stdout is not None
        for line in process.stdout:
            if line.strip().startswith("1/1 "):
                seconds = time.perf_counter() - begin
                process.communicate()
                return seconds
        raise LiftLabError(f"lift-lab train ended with status {process.wait()} before its first iteration")


def start_training(
    args: Any, overrides: list[str], num_envs: int | None, more: list[str], folder: str, environ: dict[str, str]
) -> subprocess.Popen[str]:
    """``lift-lab train`` as a process whose output is one stream of lines; its runs go below ``folder``."""
    size = [] if num_envs is None else [f"--num_envs={num_envs}"]
    flags = [f"--task={args.task}", f"--seed={args.seed}", *size, *more, *shared(args), *overrides]
    return subprocess.Popen(
        [*PROGRAM, "train", *flags],
        cwd=folder,
        env={**environ, "PYTHONUNBUFFERED": "1"},
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    )


def time_to_learn(args: Any, overrides: list[str], environ: dict[str, str], results: Results) -> dict[str, Any]:
    """Train for ``args.train_seconds`` at most, then find the first checkpoint that is good enough.

    Returns:
        ``seconds_to_learn`` from starting the script to writing that checkpoint (None: none is good enough),
        ``iterations_to_learn``, and ``checkpoints``: (iteration, seconds, share of successes).
    """
    with tempfile.TemporaryDirectory() as folder:
        began = time.time()
        save = [] if any(text.startswith("agent.save_interval=") for text in overrides) else ["agent.save_interval=25"]
        process = start_training(args, [*overrides, *save], args.num_envs, [], folder, environ)
        lines = read_until(process, began + args.train_seconds)
        checkpoints = sorted(Path(folder).glob("logs/rsl_rl/*/*/model_[0-9]*.pt"), key=lambda p: p.stat().st_mtime)
        progress = [line for line in lines if " | left " in line]
        found: dict[str, Any] = {"last_line": progress[-1].strip() if progress else "", "status": process.returncode}
        if not checkpoints:
            return found | {"error": (lines or [""])[-1].strip()}
        results.put("training", found)
        looked_at = []
        answer: dict[str, Any] = {"seconds_to_learn": None, "iterations_to_learn": None}
        for path in checkpoints:
            seconds = path.stat().st_mtime - began
            try:
                share = success_of(args, overrides, path, environ)
            except LiftLabError as error:
                return found | answer | {"error": str(error)}
            iteration = int(path.stem.rpartition("_")[2])
            looked_at.append((iteration, seconds, share))
            print(f"iteration {iteration}, {seconds:.0f} s: {share:.0%} of {EPISODES} episodes", flush=True)
            results.put("training", {**found, "checkpoints": looked_at})
            if share >= ENOUGH:
                answer = {"seconds_to_learn": seconds, "iterations_to_learn": iteration}
                break
        return found | answer | {"checkpoints": looked_at}


def read_until(process: subprocess.Popen[str], end: float) -> list[str]:
    """Lines of a training, which is asked to end at the time ``end`` and left to save."""
    import threading

    lines: list[str] = []
    assert process.stdout is not None
    stream = process.stdout
    reader = threading.Thread(target=lambda: lines.extend(stream), daemon=True)
    reader.start()
    while reader.is_alive() and time.time() < end:
        reader.join(0.5)
    if reader.is_alive():
        process.send_signal(signal.SIGINT)
        reader.join(120)
    process.wait(60)
    return lines


def success_of(args: Any, overrides: list[str], checkpoint: Path, environ: dict[str, str]) -> float:
    """Share of successes of a checkpoint's policy in ``lift-lab evaluate``."""
    env_overrides = [text for text in overrides if not text.startswith("agent.save_interval=")]
    file = checkpoint.with_suffix(".json")
    flags = [f"--task={args.task}", f"--checkpoint={checkpoint}", f"--episodes={EPISODES}", f"--json={file}"]
    command = [*PROGRAM, "evaluate", *flags, *shared(args), *env_overrides]
    done = subprocess.run(command, env=environ, capture_output=True, text=True)
    if done.returncode != 0:
        raise LiftLabError(f"lift-lab evaluate: {(done.stderr.strip().splitlines() or ['failed'])[-1]}")
    return json.loads(file.read_text())["success_rate"][str(EPISODES)]


def machine(device: str | None) -> dict[str, Any]:
    """Describe the machine on which the numbers were measured."""
    packages = ("torch", "mujoco", "mujoco-warp", "warp-lang", "rsl-rl-lib")
    found: dict[str, Any] = {
        "system": platform.platform(),
        "python": platform.python_version(),
        "cpus": len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count(),
        "versions": {name: metadata.version(name) for name in packages},
        "device": device or "auto",
        "load_average_1min": os.getloadavg()[0] if hasattr(os, "getloadavg") else None,
    }
    info = Path("/proc/cpuinfo")
    if info.is_file():
        names = [line.partition(":")[2].strip() for line in info.read_text().splitlines() if "model name" in line]
        found["cpu"] = names[0] if names else platform.machine()
    if shutil.which("nvidia-smi"):
        query = ["nvidia-smi", "--query-gpu=name,driver_version,memory.total", "--format=csv,noheader"]
        found["gpus"] = subprocess.run(query, capture_output=True, text=True).stdout.strip().splitlines()
    return found


# -- showing


def show_sizes(rows: list[dict[str, Any]], task: str) -> None:
    """A table of speed and memory over the number of environments."""
    names = ("environments", "environment steps/s", "physics steps/s", "of the engine", "bytes per environment", "note")
    table = Table(*names, title=task, title_justify="left")
    for row in rows:
        if "error" in row:
            table.add_row(f"{row['num_envs']:,}", *[""] * 4, row["error"])
            continue
        speeds = (f"{row['env_steps_per_s']:,.0f}", f"{row['physics_steps_per_s']:,.0f}", f"{row['ratio']:.2f}")
        table.add_row(f"{row['num_envs']:,}", *speeds, f"{row['env_memory_bytes'] / row['num_envs']:,.0f}", "")
    Console().print(table)


def require_matplotlib() -> None:
    """Raises ConfigError when there is nothing to draw with."""
    try:
        import matplotlib  # noqa: F401
    except ModuleNotFoundError as error:
        raise ConfigError("--plot needs matplotlib: pip install 'lift-lab[report]'") from error


def plot(rows: list[dict[str, Any]], path: Path, task: str) -> None:
    """Speed of environment and engine, and bytes per environment, over the number of environments."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    rows = [row for row in rows if "error" not in row]
    sizes = [row["num_envs"] for row in rows]
    figure, (speed, memory) = plt.subplots(1, 2, figsize=(10, 4), layout="constrained")
    speed.plot(sizes, [row["env_steps_per_s"] for row in rows], "o-", label="environment")
    speed.plot(sizes, [row["physics_steps_per_s"] / row["decimation"] for row in rows], "s--", label="engine alone")
    speed.set(xscale="log", yscale="log", xlabel="environments", ylabel="environment steps/s")
    speed.legend()
    memory.plot(sizes, [row["env_memory_bytes"] / row["num_envs"] for row in rows], "o-")
    memory.set(xscale="log", yscale="log", xlabel="environments", ylabel="bytes per environment")
    figure.suptitle(task)
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path)
    plt.close(figure)
