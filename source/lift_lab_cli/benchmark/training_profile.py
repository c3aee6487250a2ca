"""Profile of a training iteration: CPU time of this process by part of the iteration."""

from __future__ import annotations

import contextlib
from collections.abc import Mapping
from typing import Any

from .step_profile import Clock, measured, step_parts

ENGINE = ("physics", "search for failures", "resets: kinematics")
"""Parts of an environment step that are the engine's; the others are the environment's."""


def training_parts(runner: Any) -> list[tuple[Any, str, str | Mapping[str, str]]]:
    """(object, method, name of the part, or its names by the part that calls it), for rsl_rl's runner."""
    from lift_lab_rl.rsl_rl import ppo
    from lift_lab_rl.rsl_rl.mlp_gradients import AutogradMlp, EluMlp

    algorithm, logger, guard = runner.alg, runner.logger, runner.guard
    checks = ("look_at_rollout", "check_rollout", "keep", "check_update")
    step = [
        (owner, method, "physics" if name in ENGINE else "environment: managers and resets")
        for owner, method, name in step_parts(runner.env.unwrapped)
    ]
    parts = {"actor: noise, probabilities": "actor: network", "returns": "critic: network"}
    return [
        *step,
        (runner.env, "step", "environment: managers and resets"),
        (algorithm, "act", "actor: noise, probabilities"),
        (algorithm, "process_env_step", "storage"),
        (algorithm, "compute_returns", "returns"),
        (logger, "process_env_step", "sums of episodes"),
        (logger, "log_iteration", "logs"),
        *((guard, method, "search for NaN") for method in checks if guard is not None),
        (algorithm, "update", "update: the rest"),
        (algorithm, "_gather", "update: gathers"),
        (algorithm, "_policy_loss", "update: loss"),
        (algorithm, "_value_loss", "update: loss"),
        (algorithm, "_clip", "update: clipping"),
        (algorithm.optimizer, "step", "update: optimizer"),
        (ppo, "update_normalization", "update: normalisation"),
        *((kind, "forward", {**parts, "": "update: forward"}) for kind in (EluMlp, AutogradMlp)),
        *((kind, "backward", "update: backward") for kind in (EluMlp, AutogradMlp)),
    ]


def profile_training(env: Any, agent_cfg: Any, iterations: int) -> dict[str, float]:
    """CPU seconds a training iteration by part, the largest first; from a new policy, with episodes of all ages.

    Args:
        env: environment on the CPU.
        agent_cfg: agent of rsl_rl; the learner gets one thread, so that no two of its parts run at once.
        iterations: iterations to measure, after one that is not counted.
    """
    import torch

    from lift_lab_rl.rsl_rl import LiftLabRunner, RslRlVecEnvWrapper, to_rsl_rl

    agent_cfg.num_threads, agent_cfg.evaluation = 1, None
    with torch.inference_mode():  # in which the environment has been stepped
        wrapped = RslRlVecEnvWrapper(env, clip_actions=agent_cfg.clip_actions)
    runner = LiftLabRunner(wrapped, to_rsl_rl(agent_cfg, wrapped.get_observations().keys()), device="cpu")
    runner.learn(1, init_at_random_ep_len=True)
    with contextlib.ExitStack() as stack:
        clock = Clock()
        for owner, method, name in training_parts(runner):
            stack.enter_context(measured(clock, owner, method, name))
        clock.restart()
        runner.learn(iterations)
        clock.tick()
    return dict(sorted(((k, v / iterations) for k, v in clock.seconds.items()), key=lambda item: -item[1]))
