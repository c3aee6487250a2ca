"""Measure a trained policy: success rate, reward and time to success over whole episodes.

lift-lab evaluate --task TASK [--checkpoint PATH|latest|best|pretrained] --episodes 100 [--json FILE]

The policy acts without noise. Every environment runs whole episodes, and all count alike: see lift_lab_rl.evaluation.
"""

from __future__ import annotations

import json
import re
import sys
from pathlib import Path

from lift_lab.app import AppLauncher, cli

from .arguments import add_checkpoint_flags, check_checkpoint_flags, positive, split_overrides, task_parser
from .rsl_rl_library import RslRl, check_agent, find_policy, make_runner

MOST_ENVS = 1024
"""Environments that run at once, unless --num_envs says otherwise."""


def parse():
    parser = task_parser(__doc__, "rsl_rl_cfg_entry_point", "logs/rsl_rl")
    parser.settings |= RslRl.flag_settings
    add_checkpoint_flags(parser)
    parser.add_argument("--episodes", type=positive, default=100, help="number of episodes (default: 100)")
    parser.add_argument(
        "--success", type=str, default=None, help="success function module:name, called with env (default: the task's)"
    )
    parser.add_argument(
        "--perturb",
        action="extend",
        nargs="+",
        default=[],
        metavar="NAME=NUMBER",
        help="change the task: mass=2 and friction=0.5 are factors, pose=1.5 starts outside the trained range up to "
        "this factor, delay=0.01 delays actions by seconds; several can be combined",
    )
    parser.add_argument("--json", type=Path, default=None, help="file for the results")
    overrides, words = split_overrides(sys.argv[1:])
    args, overrides = parser.parse([*overrides, *words])
    check_checkpoint_flags(parser, args)
    if "standard" in args.perturb:
        parser.error("--perturb standard is several evaluations: use lift-lab study (here perturbations act together)")
    return args, overrides


def main() -> int:
    args, overrides = parse()
    AppLauncher(args)

    import gymnasium as gym

    import lift_lab_tasks  # noqa: F401
    from lift_lab_rl.counters import load_counters
    from lift_lab_rl.evaluation import add_success_probe, evaluate
    from lift_lab_rl.files import check_target, write_atomically
    from lift_lab_rl.perturbations import perturb_all
    from lift_lab_rl.threads import use_one_torch_thread
    from lift_lab_tasks.settings import Settings
    from lift_lab_tasks.utils import import_user_module, task_kwargs

    check_agent(args)
    if args.json is not None:
        check_target(args.json)
    settings = Settings(args.task, args.agent, overrides, args.flag_settings)
    settings.resolve(num_envs=min(args.episodes, MOST_ENVS))
    env_cfg, agent_cfg = settings.env, settings.agent
    perturb_all(env_cfg, args.perturb)
    checkpoint = find_policy(settings, args)
    if args.success is not None and re.fullmatch(r"[\w.]+:[\w.]+", args.success):
        import_user_module(args.success.partition(":")[0])
    add_success_probe(env_cfg, args.success or task_kwargs(args.task).get("success"))
    if env_cfg.sim.device == "cpu":
        use_one_torch_thread()
    env = gym.make(args.task, cfg=env_cfg)
    try:
        wrapped, runner = make_runner(env, agent_cfg)
        infos = runner.load_policy(str(checkpoint))
        # Again from the start, now with the curriculum where the checkpoint left it: also if it is driven by success,
        # for which the reset is one of episodes that all failed.
        wrapped.seed(env_cfg.seed)
        wrapped.reset()
        load_counters(env.unwrapped, infos.get("env_state", {}))
        result = evaluate(wrapped, runner.get_inference_policy(device=agent_cfg.device), args.episodes)
    finally:
        env.close()
    summary = result.summary()
    show(" ".join([args.task, *args.perturb]), checkpoint, summary)
    if args.json is not None:
        content = {"task": args.task, "checkpoint": str(checkpoint), "seed": env_cfg.seed, "perturb": args.perturb}
        content |= summary
        write_atomically(args.json, (json.dumps(content, indent=2) + "\n").encode())
        print(f"written: {args.json}")
    return 0


def show(task: str, checkpoint: Path, summary: dict) -> None:
    """Print the results as a table."""
    from rich.console import Console
    from rich.table import Table

    from lift_lab_rl.episode_logs import FAILURES
    from lift_lab_rl.scalar_names import SUCCESS_RATE

    table = Table(title=f"{task}, {checkpoint.parent.name}/{checkpoint.name}", title_justify="left")
    for name in ("measure", "value"):
        table.add_column(name, overflow="fold")
    for count, rate in summary["success_rate"].items():
        low, high = summary["success_rate_interval"][count]
        text = f"{round(rate * int(count))} of {count} ({rate:.1%}, 95 % interval {low:.1%} to {high:.1%})"
        table.add_row(f"success rate, first {count} episodes", text)
    table.add_row("mean reward ± deviation", f"{summary['mean_reward']:.2f} ± {summary['std_reward']:.2f}")
    table.add_row("min / max reward", f"{summary['min_reward']:.2f} / {summary['max_reward']:.2f}")
    seconds = summary["time_to_success_s"]
    table.add_row("mean time to success", "-" if seconds is None else f"{seconds:.2f} s")
    table.add_row("mean episode length", f"{summary['mean_episode_length']:.1f} steps")
    table.add_row("terminations", ", ".join(f"{name} {count}" for name, count in summary["terminations"].items()))
    for key, value in summary["logs"].items():
        if key.startswith("Metrics/") and key != SUCCESS_RATE and not key.startswith(FAILURES):
            table.add_row(key, f"{value:.4g}")
    Console().print(table)


if __name__ == "__main__":
    cli.run(main)
