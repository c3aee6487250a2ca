"""Evaluation of the policy during a training, and the end of the training once the task is solved.

The policy that would be shipped (the EMA where there is one) acts without noise, on starts of seeds that the training
does not use, in environments of its own. These are built when they are first needed. The training's random numbers are
put back afterwards, so its bits do not depend on evaluations. Whether an evaluation takes place depends on counts
alone, never on time: a run that is continued ends at the same iteration.
"""

from __future__ import annotations

import copy
import math
import time
from dataclasses import dataclass
from typing import Any

import torch

from lift_lab.managers.manager_term_cfg import leave_out_training_only
from lift_lab.utils.errors import ConfigError, StateMismatchError
from lift_lab_rl.counters import counters, load_counters, manager_env
from lift_lab_rl.episode_logs import FAILURES
from lift_lab_rl.evaluation import Evaluation, add_success_probe, evaluate
from lift_lab_rl.random_state import load_rng_state, rng_state
from lift_lab_rl.scalar_names import SUCCESS_RATE

from .evaluation_cfg import criteria
from .vecenv_wrapper import RslRlVecEnvWrapper

MOST_ENVS = 50
"""Environments of an evaluation, unless their number is given: fewer steps are lost when the first ones fail."""


def num_eval_envs(cfg: dict[str, Any]) -> int:
    """Environments that run the episodes of an evaluation.

    Args:
        cfg: entries of :class:`~lift_lab_rl.rsl_rl.evaluation_cfg.RslRlEvaluationCfg`.
    """
    return cfg["num_envs"] or min(cfg["episodes"], MOST_ENVS)


def evaluation_env_cfg(env: RslRlVecEnvWrapper, cfg: dict[str, Any]) -> Any:
    """Return the configuration of the environments that evaluate a policy: the training's, without aids of training.

    Args:
        env: wrapped environment of the training.
        cfg: entries of :class:`~lift_lab_rl.rsl_rl.evaluation_cfg.RslRlEvaluationCfg`.

    Raises:
        ConfigError: the task does not say what success is.
    """
    inner = env.unwrapped
    own: Any = inner.cfg.copy()
    own.scene.num_envs, own.seed = num_eval_envs(cfg), cfg["seed"]
    own.recorders, own.log_dir, own.export_io_descriptors = None, None, False
    leave_out_training_only(own)
    try:
        add_success_probe(own, None if inner.spec is None else inner.spec.kwargs.get("success"))
    except ConfigError as error:
        raise ConfigError(f"agent.evaluation: {error}; or train with --no_evaluation") from error
    return own


@dataclass
class EvaluationResult:
    """One evaluation."""

    rank: tuple[float, float]
    """Success rate, then minus the error, or the mean reward where no error is looked at."""
    passed: bool
    """Whether it has passed."""
    scalars: dict[str, float]
    """Curves, ``Evaluation/...``."""
    note: str
    """The result in words."""


class TrainingEvaluation:
    """Decides when the policy is evaluated, evaluates it, and says when the task is solved.

    Attributes:
        passes: evaluations in a row that have passed.
        solved: whether enough of them have.
        steps: environment steps of all evaluations so far.
    """

    def __init__(self, cfg: dict[str, Any], alg: Any, env: Any, env_cfg: Any, most_steps: int):
        """Evaluate nothing yet.

        Args:
            cfg: entries of :class:`~lift_lab_rl.rsl_rl.evaluation_cfg.RslRlEvaluationCfg`.
            alg: the algorithm, whose policy is evaluated.
            env: wrapped environment of the training.
            env_cfg: what :func:`evaluation_env_cfg` returns.
            most_steps: environment steps of the whole training, if it does not end early.
        """
        self._cfg, self._alg, self._training_env, self._env_cfg = cfg, alg, env, env_cfg
        self._policy = copy.deepcopy(alg.get_policy()).eval()  # now: later the copy would hold what graphs refer to
        self._env: Any = None
        self._cost = -(-cfg["episodes"] // num_eval_envs(cfg)) * num_eval_envs(cfg) * int(env.max_episode_length)
        self._allowed_failures = int((1.0 - cfg["min_success"]) * cfg["episodes"] + 1e-6)
        self._most_steps = most_steps
        self._open_since: int | None = None
        self._last: int | None = None
        self.passes, self.steps = 0, 0

    @property
    def solved(self) -> bool:
        """Whether as many evaluations in a row have passed as the task needs to count as solved."""
        return self.passes >= self._cfg["consecutive"]

    def after_iteration(self, iteration: int, total_steps: int, success: float | None) -> EvaluationResult | None:
        """Evaluate the policy if it is time.

        Args:
            iteration: iterations finished.
            total_steps: environment steps of the training so far.
            success: smoothed success rate of the training's episodes; None while it is not known.

        Returns:
            The result; None if it is not time.

        Raises:
            NonFiniteError: an observation or a reward of an evaluation is infinite or NaN.
        """
        if not self._is_due(iteration, total_steps, success):
            return None
        self._last = iteration
        start = time.perf_counter()
        state = rng_state()
        try:
            found = self._evaluate()
        finally:
            load_rng_state(state)
        result = self._judge(found, iteration)
        result.scalars["Evaluation/time"] = time.perf_counter() - start
        return result

    def too_short(self) -> str | None:
        """Say why a training of this length cannot end early; None if it can."""
        cfg, needed, steps = self._cfg, self._cfg["consecutive"] * self._cost, self._most_steps
        if needed <= cfg["max_share"] * steps:
            return None
        share = math.ceil(1e3 * needed / steps) / 1e3
        remedy = f"max_share={share:g} is enough" if share <= 1.0 else "train for longer, or evaluate fewer episodes"
        return (
            f"agent.evaluation: this training cannot end early: {cfg['consecutive']} evaluations of {cfg['episodes']} "
            f"episodes need up to {needed:,} environment steps, and max_share={cfg['max_share']:g} of {steps:,} is "
            f"less; {remedy}"
        )

    def _is_due(self, iteration: int, total_steps: int, success: float | None) -> bool:
        cfg = self._cfg
        if self._open_since is None:
            if cfg["from_success"] is not None and (success is None or success < cfg["from_success"]):
                return False
            self._open_since = iteration
        return (
            iteration >= self._open_since + cfg["start_after"]
            and (self._last is None or iteration >= self._last + cfg["interval"])
            and self.steps + self._cost <= cfg["max_share"] * total_steps
        )

    def _evaluate(self) -> Evaluation:
        if self._env is None:
            inner, clip = self._training_env.unwrapped, self._training_env.clip_actions
            self._env = RslRlVecEnvWrapper(type(inner)(cfg=self._env_cfg.copy()), clip_actions=clip)
        env, alg = self._env, self._alg
        average = getattr(alg, "ema", None)
        self._policy.load_state_dict(alg.get_policy().state_dict() if average is None else average.state_dict())
        self._policy.to(env.device).reset()
        with torch.inference_mode():
            env.seed(self._cfg["seed"] + self.passes)
            env.reset()
            load_counters(env.unwrapped, counters(manager_env(self._training_env)))
            before = env.unwrapped.common_step_counter
            found = evaluate(env, self._policy, self._cfg["episodes"], self._can_pass)
        self.steps += (env.unwrapped.common_step_counter - before) * env.num_envs
        return found

    def _failures(self, found: Evaluation) -> int:
        return sum(episode.success_step == 0 for episode in found.episodes)

    def _error(self, found: Evaluation) -> float | None:
        return found.logs.get(self._cfg["error_metric"])

    def _is_exact(self, found: Evaluation) -> bool:
        most, error = self._cfg["max_error"], self._error(found)
        return most is None or (error is not None and error <= most)

    def _can_pass(self, found: Evaluation) -> bool:
        """Whether these episodes pass: an evaluation of which they are the first rounds is worth to be continued."""
        return self._failures(found) <= self._allowed_failures and self._is_exact(found)

    def _judge(self, found: Evaluation, iteration: int) -> EvaluationResult:
        cfg, count, failures, error = self._cfg, len(found.episodes), self._failures(found), self._error(found)
        passed = self._can_pass(found)
        self.passes = self.passes + 1 if passed else 0
        summary = found.summary()
        scalars = {
            "Evaluation/success_rate": found.success_rate(),
            "Evaluation/episodes": float(count),
            "Evaluation/mean_reward": summary["mean_reward"],
            "Evaluation/mean_episode_length": summary["mean_episode_length"],
        }
        for key, value in found.logs.items():
            if key.startswith("Metrics/") and key != SUCCESS_RATE and not key.startswith(FAILURES):
                scalars[f"Evaluation/{key.removeprefix('Metrics/')}"] = value
        end = f"passed ({self.passes} of {cfg['consecutive']})" if passed else "not passed"
        of_error = "" if error is None else f", {cfg['error_metric']} {error:.4g}"
        note = f"evaluation at iteration {iteration}: success {count - failures} of {count}{of_error}: {end}"
        score = summary["mean_reward"] if error is None else -error
        return EvaluationResult((found.success_rate(), score), passed, scalars, note)

    def close(self) -> None:
        """Close the environments of the evaluations; the next evaluation makes new ones."""
        if self._env is not None:
            self._env.close()
            self._env = None

    # -- continuing a run

    def criteria(self) -> dict[str, Any]:
        """Return the settings that say when the task is solved, as plain values."""
        return criteria(self._cfg)

    def state_dict(self) -> dict[str, Any]:
        """State on which later evaluations depend, as plain values."""
        return {
            "criteria": self.criteria(),
            "open_since": self._open_since,
            "last": self._last,
            "passes": self.passes,
            "steps": self.steps,
        }

    def check_state_dict(self, state: Any) -> None:
        """Check that a state can be loaded.

        Raises:
            StateMismatchError: it is none of :meth:`state_dict`.
        """
        if not isinstance(state, dict) or state.keys() != self.state_dict().keys():
            raise StateMismatchError("'evaluation' has other entries")
        counts = {name: value for name, value in state.items() if name != "criteria"}
        for name, value in counts.items():
            optional = name in ("open_since", "last") and value is None
            if not optional and (type(value) is not int or value < 0):
                raise StateMismatchError(f"'evaluation.{name}' holds {value!r}, which is no count")

    def load_state_dict(self, state: dict[str, Any]) -> None:
        """Continue from a state of :meth:`state_dict`; passes count only where they were of the same criteria."""
        self._open_since, self._last, self.steps = state["open_since"], state["last"], state["steps"]
        self.passes = state["passes"] if state["criteria"] == self.criteria() else 0
