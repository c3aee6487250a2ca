"""Measure what one update of the live viewer costs: processor time of the task's step and of drawing it.

python scripts/maintainers/viewer_rate.py [--task ID] [--num_envs 1 64] [--updates 100] [--show contact_forces frames]

No browser is needed. Processor time is of all threads; the rate is what one core would reach. Updates are measured in
rounds, and the best round counts: other programs on the machine make every round slower.
"""

from __future__ import annotations

import time

from lift_lab.app import cli


def main() -> int:
    parser = cli.Parser(__doc__, overrides=False)
    parser.add_argument("--task", default="Lift-Cube-Franka-CL-Play", help="id of the task")
    parser.add_argument("--num_envs", type=int, nargs="+", default=[1, 64], help="numbers of environments to measure")
    parser.add_argument("--updates", type=int, default=100, help="updates in a round")
    parser.add_argument(
        "--show", nargs="*", default=[], help="what else is shown, e.g. colliders frames contact_forces"
    )
    args, _ = parser.parse()

    from lift_lab.visualizers import require_viser

    require_viser()
    print("environments | step, ms | drawing, ms | updates/s of one core")
    for num_envs in args.num_envs:
        step_s, draw_s = measure(args.task, num_envs, args.updates, args.show)
        rate = 1.0 / (step_s + draw_s)
        print(f"{num_envs:12} | {step_s * 1e3:8.2f} | {draw_s * 1e3:11.2f} | {rate:8.0f}", flush=True)
    return 0


ROUNDS = 8


def measure(task: str, num_envs: int, updates: int, shown: list[str]) -> tuple[float, float]:
    """Processor seconds of a step with random actions, and of drawing it."""
    import gymnasium as gym
    import torch

    import lift_lab_tasks  # noqa: F401
    from lift_lab.visualizers import open_server
    from lift_lab_rl.rsl_rl import RslRlVecEnvWrapper
    from lift_lab_rl.threads import use_one_torch_thread
    from lift_lab_rl.viewer import RandomPolicy, ViewerSession
    from lift_lab_tasks.utils import parse_env_cfg

    use_one_torch_thread()
    cfg = parse_env_cfg(task, device="cpu", num_envs=num_envs)
    cfg.seed = 1
    env = RslRlVecEnvWrapper(gym.make(task, cfg=cfg))
    server = open_server(port=0)
    try:
        policy = RandomPolicy(env)
        session = ViewerSession(env, policy, server, task)
        for what in shown:
            session._post("show", what, True)
        session.run(5)
        obs = env.get_observations()
        best = [float("inf")] * 2
        with torch.inference_mode():
            for _ in range(ROUNDS):
                spent = [0.0, 0.0]
                for _ in range(updates):
                    times = [time.process_time()]
                    obs = session._step(obs)
                    times.append(time.process_time())
                    session._draw()
                    times.append(time.process_time())
                    spent = [total + times[i + 1] - times[i] for i, total in enumerate(spent)]
                best = [min(pair) for pair in zip(best, spent, strict=True)]
    finally:
        server.stop()
        env.close()
    return best[0] / updates, best[1] / updates


if __name__ == "__main__":
    cli.run(main)
