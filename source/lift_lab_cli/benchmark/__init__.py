"""Measure the speed of a task: physics alone, and the whole environment with random actions.

lift-lab benchmark --task Lift-Cube-Franka --num_envs 1024 --steps 200 [--json FILE] [overrides]
lift-lab benchmark --suite scale|startup|gpu [--sizes 64,1024] [--json FILE] [overrides]

The engine is measured on a second copy of it. Before every step the copy gets the environment's own states and
controls. It takes the same physics steps and keeps the same fields current (body poses among them). So both see the
same contacts, one after the other in the same seconds. A suite measures in fresh processes (docs/performance.md).
"""

from __future__ import annotations

import time

START = time.perf_counter()
"""Start of the program, on the clock of ``time.perf_counter``."""

import json  # noqa: E402
from pathlib import Path  # noqa: E402

from lift_lab.app import AppLauncher, cli  # noqa: E402

from ..arguments import COMMON_SETTINGS, positive  # noqa: E402

SUITES = ("scale", "startup", "gpu")

USED_BY = {
    "steps": (None, "scale", "gpu"),
    "num_envs": (None, "startup", "gpu"),
    "memory_steps": (None, "scale"),
    "profile": (None,),
    "profile_training": (None,),
    "sizes": SUITES,
    "plot": ("scale",),
    "train_seconds": ("gpu",),
    "cold": ("gpu",),
}
"""Flags that not every suite reads, and those that do; None is a call without a suite."""

SUITE_TASK = "Lift-Cube-Franka-CL"
"""Task of a suite, unless --task names another."""


def parse():
    parser = cli.Parser(__doc__)
    parser.add_argument("--task", type=str, default=None, help="id of the task")
    parser.add_argument("--suite", choices=SUITES, default=None, help=f"set of measurements of {SUITE_TASK}")
    parser.add_argument("--num_envs", type=positive, default=None, help="number of environments")
    parser.add_argument("--steps", type=positive, default=None, help="environment steps to measure (default: 200)")
    parser.add_argument("--seed", type=int, default=42, help="seed of environment and actions (default: 42)")
    parser.add_argument("--num_threads", type=positive, default=None, help="CPU threads (default: all)")
    parser.add_argument(
        "--memory_steps", type=positive, default=None, help="steps over all environments during which memory is watched"
    )
    parser.add_argument("--profile", action="store_true", help="also show the CPU time of each part of a step")
    parser.add_argument(
        "--profile_training",
        type=positive,
        default=None,
        help="show the CPU time of each part of this many training iterations",
    )
    parser.add_argument("--json", type=Path, default=None, help="file for the results")
    suites = parser.add_argument_group("suites")
    suites.add_argument("--sizes", type=sizes, default=None, help="numbers of environments, separated by commas")
    suites.add_argument("--plot", type=Path, default=None, help="file for the plot of the suite 'scale'")
    suites.add_argument("--train_seconds", type=positive, default=None, help="longest training of 'gpu' (default: 300)")
    suites.add_argument("--cold", action="store_true", help="suite 'gpu': compile the kernels again and time it")
    AppLauncher.add_app_launcher_args(parser)
    parser.settings |= COMMON_SETTINGS
    args, overrides = parser.parse()
    for name, users in USED_BY.items():
        if getattr(args, name) not in (None, False) and args.suite not in users:
            where = " or ".join("no --suite" if user is None else f"--suite {user}" for user in users)
            parser.error(f"--{name} belongs to {where}")
    if args.suite == "startup" and args.sizes is not None and args.num_envs is not None:
        parser.error("--sizes and --num_envs both say how many environments: give one")
    if args.suite is None and args.task is None:
        parser.error("the following arguments are required: --task (or --suite)")
    args.steps, args.train_seconds = args.steps or 200, args.train_seconds or 300
    return args, overrides


def sizes(text: str) -> list[int]:
    """Whole numbers of at least 1."""
    return [positive(part) for part in text.split(",")]


def main() -> int:
    args, overrides = parse()
    if args.json is not None:
        from lift_lab_rl.files import check_target

        check_target(args.json)
    if args.suite is not None:
        from .suites import run_suite

        args.task = args.task or SUITE_TASK
        run_suite(args, overrides)
        return 0
    launcher = AppLauncher(args)
    from .measure import measure_task

    result = measure_task(args, overrides, START)
    launcher.app.close()
    show(result)
    if args.json is not None:
        from lift_lab_rl.files import write_atomically

        write_atomically(args.json, (json.dumps(result, indent=2) + "\n").encode())
        print(f"written: {args.json}")
    return 0


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
        elif key in ("profile_s", "profile_training_s"):
            continue
        elif key == "memory":
            key, value = "memory growth", f"{value['bytes_per_million_steps']:,.0f} bytes per million steps"
        table.add_row(key, str(value))
    Console().print(table)
