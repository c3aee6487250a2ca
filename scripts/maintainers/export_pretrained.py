"""Make a run's policy the one that ships for a task: what ``--checkpoint pretrained`` plays and evaluates.

python scripts/maintainers/export_pretrained.py CHECKPOINT --task TASK [--evaluation RESULTS.json] [--out FOLDER]

Writes assets/pretrained/TASK/{policy.pt, policy.onnx, card.json}: the actor alone, under 300 kB each. The card takes
its numbers from what ``evaluate.py --task TASK --checkpoint CHECKPOINT --json RESULTS.json`` wrote.
"""

from __future__ import annotations

from pathlib import Path

from lift_lab.app import AppLauncher, cli
from lift_lab_cli.arguments import COMMON_SETTINGS


def parse():
    parser = cli.Parser(__doc__)
    parser.add_argument("checkpoint", type=Path, help="model_N.pt of a run")
    parser.add_argument("--task", type=str, required=True, help="id of the task")
    parser.add_argument("--evaluation", type=Path, default=None, help="results of evaluate.py --json")
    parser.add_argument("--out", type=Path, default=None, help="folder (default: assets/pretrained)")
    parser.add_argument("--agent", type=str, default="rsl_rl_cfg_entry_point", help="key of the agent's configuration")
    AppLauncher.add_app_launcher_args(parser)
    parser.settings["device"] = COMMON_SETTINGS["device"]
    return parser.parse()


def main() -> int:
    args, overrides = parse()
    launcher = AppLauncher(args)

    import gymnasium as gym

    import lift_lab_tasks  # noqa: F401
    from lift_lab_assets.files import PRETRAINED_DIR
    from lift_lab_rl.files import read_json
    from lift_lab_rl.rsl_rl import LiftLabRunner, RslRlVecEnvWrapper, to_rsl_rl
    from lift_lab_rl.rsl_rl.pretrained import write_pretrained
    from lift_lab_tasks.settings import Settings
    from lift_lab_tasks.utils import runs

    results = None if args.evaluation is None else read_json(args.evaluation)
    name = runs.pretrained_name(args.task)
    settings = Settings(args.task, args.agent, overrides, args.flag_settings)
    settings.resolve(num_envs=16)
    agent_cfg = settings.agent
    env = gym.make(args.task, cfg=settings.env)
    try:
        wrapped = RslRlVecEnvWrapper(env, clip_actions=agent_cfg.clip_actions)
        runner = LiftLabRunner(wrapped, to_rsl_rl(agent_cfg, wrapped.get_observations().keys()), None, agent_cfg.device)
        files = write_pretrained(runner, args.checkpoint, (args.out or PRETRAINED_DIR) / name, name, results)
    finally:
        env.close()
        launcher.app.close()
    for path in files:
        print(f"written: {path} ({path.stat().st_size} bytes)")
    return 0


if __name__ == "__main__":
    cli.run(main)
