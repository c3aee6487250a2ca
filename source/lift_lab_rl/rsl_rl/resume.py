"""Continue a run with the same episodes that ran when its checkpoint was written.

The state beside a checkpoint (``resume_state_N.pt``) holds what the model does not: environments, observations, random
numbers, the memory of recurrent networks, the running sums of the curves. All of it is checked before any of it is
loaded. If it does not fit, training continues from the checkpoint with new episodes.
"""

from __future__ import annotations

import logging
import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

import torch

from lift_lab.utils.errors import ConfigError, FileError, LiftLabError, StateMismatchError
from lift_lab_rl import distributed
from lift_lab_rl.counters import manager_env
from lift_lab_rl.files import load_torch, write_atomically
from lift_lab_rl.fingerprint import Fingerprint
from lift_lab_rl.random_state import check_rng_state, load_rng_state, rng_state
from lift_lab_rl.wrapper_state import plan_wrapper_states, wrapper_states

from .best_policy import BEST
from .run_files import checkpoint_iteration, state_name

if TYPE_CHECKING:
    from .runner import LiftLabRunner

_LOG = logging.getLogger(__name__)

VERSION = 3
"""Version of the form of a resume state."""


def resume_state(runner: LiftLabRunner) -> dict[str, Any]:
    """Return all data except the model on which the next iteration depends, as tensors and plain values."""
    env, returns = manager_env(runner.env), _curious_returns(runner)
    of_env = None if env is None else env.state_dict()
    wrappers, unsaved = wrapper_states(runner.env)
    if of_env is not None:
        unsaved = [*of_env["unsaved"], *unsaved]
    _note_unsaved(runner, unsaved)
    return {
        "version": VERSION,
        "iteration": runner.current_learning_iteration,
        "fingerprint": _saved_form(runner.fingerprint),
        "env": of_env,
        "wrappers": wrappers,
        "unsaved": unsaved,
        "obs": {key: value.detach().cpu().clone() for key, value in runner.env.get_observations().items()},
        "total_steps": runner.total_steps,
        "logger": runner.logger.state_dict(),
        "rng": rng_state(),
        "memory": [_copied_to(network.get_hidden_state(), "cpu") for network in _networks(runner)],
        **({} if returns is None else {"curious_returns": _copied_to(returns.avg, "cpu")}),
        **runner.best.state_dict(),
        **({} if runner.evaluation is None else {"evaluation": runner.evaluation.state_dict()}),
    }


def load_resume_state(runner: LiftLabRunner, checkpoint: str | Path) -> str:
    """Continue the episodes that ran when ``checkpoint`` was written; see :meth:`LiftLabRunner.load_resume_state`."""
    runner.continues_exactly = False
    path = Path(checkpoint).with_name(state_name(runner.place, runner.current_learning_iteration))
    state, problem = _read_state(runner, path)
    runner.total_steps = state.get("total_steps")
    # All processes continue, or none does.
    problem = distributed.first_problem(problem)
    if problem is not None:
        return _start_fresh(runner, problem)
    env = manager_env(runner.env)
    try:
        wrappers = plan_wrapper_states(runner.env, state["wrappers"])
        if env is not None:
            env.load_state_dict(state["env"])
        wrappers.apply()
    except LiftLabError as error:
        problem = str(error)
    problem = distributed.first_problem(problem)
    if problem is not None:
        return _start_fresh(runner, problem, reset=True)
    restore = getattr(runner.env, "restore_observations", None)
    if restore is not None:
        restore({key: value.to(runner.env.device) for key, value in state["obs"].items()})
    _forget_rollout(runner)
    runner.logger.load_state_dict(state["logger"])
    for network, memory in zip(_networks(runner), state["memory"], strict=True):
        if memory is not None or network.get_hidden_state() is not None:
            network.reset(hidden_state=_copied_to(memory, runner.device))
    returns = _curious_returns(runner)
    if returns is not None:
        returns.avg = _copied_to(state.get("curious_returns"), runner.device)
    runner.best.load_state_dict(state)
    if runner.evaluation is not None and "evaluation" in state:
        runner.evaluation.load_state_dict(state["evaluation"])
    _adopt_best(runner, Path(checkpoint).with_name(BEST))
    load_rng_state(state["rng"])
    runner.continues_exactly = True
    unsaved = ", ".join(state["unsaved"])
    but = f", except for {unsaved}, which could not be saved" if unsaved else ""
    return f"continuing the episodes of iteration {runner.current_learning_iteration}{but}"


def _start_fresh(runner: LiftLabRunner, problem: str, reset: bool = False) -> str:
    """Leave the episodes that ran before behind.

    Args:
        runner: the runner.
        problem: why its episodes cannot be those of the checkpoint.
        reset: whether to reset the environment in any case, not only after steps of this runner.
    """
    if reset or runner.has_stepped:
        _forget_rollout(runner)
        runner.logger.forget_episodes()
        for network in _networks(runner):
            if network.get_hidden_state() is not None:
                network.reset(hidden_state=None)
        if manager_env(runner.env) is not None:
            runner.env.reset()  # type: ignore[attr-defined]
    text = " ".join(problem.split())  # a value of a file that is something else can be long
    return f"{text if len(text) <= 400 else text[:397] + '...'}: starting fresh episodes"


def _forget_rollout(runner: LiftLabRunner) -> None:
    """Drop the steps of a rollout that was broken off."""
    alg: Any = runner.alg
    alg.storage.clear()
    alg.transition.clear()


def _saved_form(fingerprint: str | Fingerprint) -> Any:
    return dict(fingerprint.values) if isinstance(fingerprint, Fingerprint) else fingerprint


def _note_unsaved(runner: LiftLabRunner, unsaved: list[str]) -> None:
    """Warn, once a run, of what a continued run will not have."""
    if unsaved and not runner.noted_unsaved:
        runner.noted_unsaved = True
        _LOG.warning("a run that is continued will not have the state of %s: it cannot be saved", ", ".join(unsaved))


# -- checks


def _read_state(runner: LiftLabRunner, path: Path) -> tuple[dict[str, Any], str | None]:
    """A process's state, and why it cannot be continued from (None if it can)."""
    if not path.is_file():
        return {}, f"no {path.name} beside the checkpoint"
    try:
        state = load_torch(path, map_location="cpu")
    except FileError as error:
        return {}, str(error)
    if not isinstance(state, dict) or "fingerprint" not in state:
        return {}, f"'{path}' is no state of a training"
    if not isinstance(state.get("total_steps"), (int, type(None))):
        return {}, f"'{path}' is no valid state of a training: total_steps is no number"
    version = state.get("version", 1)
    if type(version) is not int or version != VERSION:
        return state, f"'{path}' has the form of version {version}, this is version {VERSION}"
    problem = _difference(runner.fingerprint, state["fingerprint"])
    if problem is not None:
        return state, problem
    try:
        _check_state(runner, state)
    except StateMismatchError as error:
        return state, f"'{path}' is no valid state of a training: {error}"
    except Exception as error:  # of a file that is something else, anything can be wrong
        reason = " ".join(str(error).split())[:120]
        return state, f"'{path}' is no valid state of a training: {type(error).__name__}: {reason}"
    return state, None


def _difference(ours: str | Fingerprint, saved: Any) -> str | None:
    """How the configuration of a saved run differs from ours; None if it does not."""
    differs = "the configuration differs from the saved run's"
    if isinstance(ours, Fingerprint) and isinstance(saved, dict):
        if not all(isinstance(text, str) for text in (*saved, *saved.values())):
            return differs
        first = ours.difference(saved)
        return None if first is None else f"{differs} ({first})"
    return None if ours == saved else differs


def _check_state(runner: LiftLabRunner, state: dict[str, Any]) -> None:
    """Raise where a part of the state, other than the environment's, is not what it has to be."""
    if state["iteration"] != runner.current_learning_iteration:
        raise StateMismatchError(f"it is of iteration {state['iteration']}")
    if manager_env(runner.env) is not None and not isinstance(state["env"], dict):
        raise StateMismatchError("it holds no environment")
    live: Any = runner.env.get_observations()
    if state["obs"].keys() != set(live.keys()):
        raise StateMismatchError(f"its observation groups are {', '.join(map(str, state['obs'])) or 'none'}")
    for name, values in live.items():
        _check_tensor(f"obs.{name}", state["obs"][name], values)
    sums = runner.logger.state_dict()
    if state["logger"].keys() != sums.keys():
        raise StateMismatchError("its curves are not those of this version")
    for name, value in sums.items():
        saved = state["logger"][name]
        if isinstance(value, torch.Tensor):
            _check_tensor(f"logger.{name}", saved, value)
        else:
            for number in saved if isinstance(value, list) else [saved]:
                _check_number(f"logger.{name}", number)
    if len(state["memory"]) != len(_networks(runner)):
        raise StateMismatchError("it is of another number of networks")
    for memory in state["memory"]:
        for part in memory if isinstance(memory, tuple) else (memory,):
            if part is not None and (part.dim() != 3 or part.shape[1] != runner.env.num_envs):
                raise StateMismatchError("the memory of its networks has another shape")
    if not all(isinstance(text, str) for text in state["unsaved"]) or not isinstance(state["wrappers"], list):
        raise StateMismatchError("'unsaved' and 'wrappers' have to be lists")
    _check_best(state)
    if runner.evaluation is not None and "evaluation" in state:
        runner.evaluation.check_state_dict(state["evaluation"])
    check_rng_state(state["rng"])


def _check_best(state: dict[str, Any]) -> None:
    for number in state["best"] or (0.0, 0.0):
        _check_number("best", number)
    if state["best"] is not None and len(state["best"]) != 2:
        raise StateMismatchError("'best' has to be two numbers")
    if "best_evaluated" in state:
        if len(state["best_evaluated"]) != 2:
            raise StateMismatchError("'best_evaluated' has to be two numbers")
        for number in state["best_evaluated"]:
            _check_number("best_evaluated", number)
    for name, number in state["smoothed"].items():
        _check_number(f"smoothed.{name}", number)


def _check_tensor(name: str, saved: Any, live: torch.Tensor) -> None:
    if not isinstance(saved, torch.Tensor) or (saved.shape, saved.dtype) != (live.shape, live.dtype):
        raise StateMismatchError(f"'{name}' has to be a tensor of shape {tuple(live.shape)} and type {live.dtype}")


def _check_number(name: str, value: Any) -> None:
    if not isinstance(value, (int, float)) or math.isnan(value):
        raise StateMismatchError(f"'{name}' holds {value!r}, which is no number")


# -- parts


def _networks(runner: LiftLabRunner) -> tuple[Any, Any]:
    return runner.alg.actor, runner.alg.critic


def _curious_returns(runner: LiftLabRunner) -> Any:
    """What holds the discounted rewards by which curiosity is scaled; None without such a scale."""
    rnd: Any = runner.alg.rnd
    return getattr(rnd.reward_normalizer, "disc_avg", None) if rnd else None


def _adopt_best(runner: LiftLabRunner, path: Path) -> None:
    """Copy the best policy of the run that is continued; without that file there is none to beat."""
    best = runner.best
    is_ranked = best.rank is not None or best.evaluated is not None
    if not is_ranked or runner.log_dir is None or not runner.place.is_main:
        return
    try:
        known = checkpoint_iteration(path) <= runner.current_learning_iteration
    except (FileError, ConfigError):
        known = False
    if not known:
        best.rank = best.evaluated = None
    elif path.resolve() != (runner.log_dir / path.name).resolve():
        write_atomically(runner.log_dir / path.name, path.read_bytes())


def _copied_to(memory: Any, device: str) -> Any:
    """A recurrent network's memory (None, a tensor, or a tuple of tensors), copied to a device."""
    if isinstance(memory, (tuple, list)):
        return tuple(_copied_to(part, device) for part in memory)
    return None if memory is None else memory.detach().to(device, copy=True)
