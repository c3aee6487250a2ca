"""Curriculum terms: called inside resets, they change the task during training and return their state for the log."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Annotated, Any, ClassVar

from lift_lab.managers import ManagerTermBase
from lift_lab.utils.errors import ConfigError, suggest
from lift_lab.utils.indexing import EnvIds
from lift_lab.utils.ranges import COUNT, COUNT_OR_ZERO, FINITE, FRACTION

from .metric_level import MetricLevel, check_metric, metric_level

if TYPE_CHECKING:
    from lift_lab.envs import ManagerBasedRLEnv
    from lift_lab.managers import CurriculumTermCfg

__all__ = [
    "anneal_reward_weight",
    "anneal_reward_weight_on_success",
    "modify_env_param",
    "modify_reward_weight",
    "modify_term_cfg",
]


class modify_reward_weight(ManagerTermBase):
    """Set the weight of a reward term once more than ``num_steps`` environment steps were taken.

    With ``level``, steps count from the one at which the running mean of ``metric`` first reaches it. So the weight
    follows the progress of the training. The mean is over the last episodes that ended, as many as there are
    environments.

    Params:
        term_name: the reward term.
        weight: its new weight.
        num_steps: the weight changes when the number of steps is greater than this.
        metric: the metrics term that ``level`` is about.
        level: mean of the metric from which on steps count; None counts from the start of the training.
    """

    _level: MetricLevel | None = None

    def __init__(self, cfg: CurriculumTermCfg, env: ManagerBasedRLEnv):
        super().__init__(cfg, env)
        self._term_cfg = env.reward_manager.get_term_cfg(cfg.params["term_name"])
        level = metric_level(self, env)
        if level is not None:
            self._level = level
        elif "metric" in cfg.params:
            raise ConfigError(f"{type(self).__name__}: metric has no effect without level")

    def __call__(
        self,
        env: ManagerBasedRLEnv,
        env_ids: EnvIds,
        term_name: str,
        weight: Annotated[float, FINITE],
        num_steps: Annotated[int, COUNT_OR_ZERO],
        metric: str = "success",
        level: Annotated[float | None, FINITE] = None,
    ) -> float:
        steps = env.common_step_counter if self._level is None else self._level.elapsed(env, env_ids)
        if steps > num_steps:
            self._term_cfg.weight = weight
            env.reward_manager.set_term_cfg(term_name, self._term_cfg)
        return self._term_cfg.weight


class anneal_reward_weight(ManagerTermBase):
    """Move the weight of a reward term linearly from one value to another.

    This is Equation (1) of "Adaptive Robotic Arm Control: Leveraging Curriculum Learning and Deep Reinforcement
    Learning for Efficient Pick-and-Lift Operations Through Simulation".

    With t the number of environment steps since ``start_step``, rounded down to a multiple of ``update_interval``::

        weight(t) = initial_weight + (final_weight - initial_weight) * min(t, num_steps) / num_steps

    An ``update_interval`` of 1 is the equation; one of ``num_steps`` is a single step, as in the paper's text and in
    Isaac Lab. The weight follows from the step counter alone, so a resumed training continues where it stopped.

    Params:
        term_name: the reward term.
        initial_weight: its weight up to ``start_step``.
        final_weight: its weight from ``start_step + num_steps`` on.
        num_steps: length of the ramp in environment steps (t_max).
        update_interval: steps between two changes of the weight.
        start_step: environment step at which the ramp begins.
    """

    def __init__(self, cfg: CurriculumTermCfg, env: ManagerBasedRLEnv):
        super().__init__(cfg, env)
        self._term_cfg = env.reward_manager.get_term_cfg(cfg.params["term_name"])
        for name, least in (("num_steps", 1), ("update_interval", 1), ("start_step", 0)):
            if cfg.params.get(name, least) < least:
                raise ConfigError(f"anneal_reward_weight: {name} must be at least {least}, got {cfg.params[name]}")

    def __call__(
        self,
        env: ManagerBasedRLEnv,
        env_ids: EnvIds,
        term_name: str,
        initial_weight: Annotated[float, FINITE],
        final_weight: Annotated[float, FINITE],
        num_steps: Annotated[int, COUNT],
        update_interval: Annotated[int, COUNT] = 1,
        start_step: Annotated[int, COUNT_OR_ZERO] = 0,
    ) -> float:
        elapsed = max(env.common_step_counter - start_step, 0)
        t = min(elapsed // update_interval * update_interval, num_steps)
        self._term_cfg.weight = initial_weight + (final_weight - initial_weight) * t / num_steps
        env.reward_manager.set_term_cfg(term_name, self._term_cfg)
        return self._term_cfg.weight


class anneal_reward_weight_on_success(ManagerTermBase):
    """Move the weight of a reward term from one value to another, but only while the task is being solved.

    The success rate is a running mean over the episodes that end. An environment step with a rate of at least
    ``raise_at`` moves the weight by ``1 / num_steps`` of its way. A step with a rate below ``lower_at`` moves it back
    by as much. In between the weight stays. With ``geometric`` the way is the weight's logarithm, so each step changes
    the weight by the same factor. Otherwise it is the weight itself.

    A training that continues from a checkpoint continues from the checkpoint's weight, once it has seen ``window``
    episodes.

    Params:
        term_name: the reward term.
        initial_weight: its weight at the start, and the least far it goes back.
        final_weight: its weight at the end.
        num_steps: environment steps from one to the other while the rate allows.
        metric: the metrics term that is 1 for an episode with success, else 0.
        raise_at: success rate from which on the weight moves.
        lower_at: success rate below which it moves back.
        window: episodes that the running mean looks back on; nothing moves before as many have ended.
        geometric: whether the logarithm of the weight moves evenly; both weights then need one sign.

    Returns:
        ``weight`` and ``success_rate``, for the log.
    """

    def __init__(self, cfg: CurriculumTermCfg, env: ManagerBasedRLEnv):
        super().__init__(cfg, env)
        params = cfg.params
        self._term_cfg = env.reward_manager.get_term_cfg(params["term_name"])
        self._rate, self._episodes, self._last_step = 0.0, 0, env.common_step_counter
        name = type(self).__name__
        check_metric(self, env)
        if params["num_steps"] < 1 or params.get("window", 1) < 1:
            raise ConfigError(f"{name}: num_steps and window must be at least 1")
        if not params.get("lower_at", 0.5) <= params.get("raise_at", 0.8):
            raise ConfigError(f"{name}: lower_at must not be above raise_at")
        if params.get("geometric", True) and params["initial_weight"] * params["final_weight"] <= 0:
            raise ConfigError(f"{name}: a geometric way needs two weights of one sign, not zero; or geometric=False")
        if params["initial_weight"] == params["final_weight"]:
            raise ConfigError(f"{name}: initial_weight and final_weight are the same")

    def __call__(
        self,
        env: ManagerBasedRLEnv,
        env_ids: EnvIds,
        term_name: str,
        initial_weight: Annotated[float, FINITE],
        final_weight: Annotated[float, FINITE],
        num_steps: Annotated[int, COUNT],
        metric: str = "success",
        raise_at: Annotated[float, FRACTION] = 0.8,
        lower_at: Annotated[float, FRACTION] = 0.5,
        window: Annotated[int, COUNT] = 2000,
        geometric: bool = True,
    ) -> dict[str, float]:
        metrics = env.metrics_manager
        ended = metrics.episode_value(metric)[metrics.counted_ids(env_ids)]
        elapsed, self._last_step = env.common_step_counter - self._last_step, env.common_step_counter
        if env.common_step_counter > 0 and len(ended) > 0:  # at 0 no episode has ended
            self._episodes = min(self._episodes + len(ended), window)
            self._rate += (float(ended.mean()) - self._rate) * min(1.0, len(ended) / self._episodes)
        if self._episodes < window or lower_at <= self._rate < raise_at:
            return {"weight": self._term_cfg.weight, "success_rate": self._rate}
        weight, whole = self._term_cfg.weight, final_weight - initial_weight
        if geometric:
            way = math.log(weight / initial_weight) / math.log(final_weight / initial_weight)
        else:
            way = (weight - initial_weight) / whole
        way += elapsed / num_steps if self._rate >= raise_at else -elapsed / num_steps
        way = min(max(way, 0.0), 1.0)
        if geometric:
            self._term_cfg.weight = initial_weight * (final_weight / initial_weight) ** way
        else:
            self._term_cfg.weight = initial_weight + whole * way
        env.reward_manager.set_term_cfg(term_name, self._term_cfg)
        return {"weight": self._term_cfg.weight, "success_rate": self._rate}


class modify_env_param(ManagerTermBase):
    """Change anything that a dotted path from the environment leads to.

    ``modify_fn(env, env_ids, old_value, **modify_params)`` returns the new value, or :attr:`NO_CHANGE`.

    Params:
        address: the path: attributes, dictionary keys and list indices, e.g.
            ``"event_manager.cfg.push.params['velocity_range']['x']"`` or ``"scene.env_origins"``. A key may also be
            written with a dot: ``"params.velocity_range.x"``.
        modify_fn: the function.
        modify_params: further arguments of it.
    """

    NO_CHANGE: ClassVar[object] = object()
    """Returned by ``modify_fn`` to keep the value."""

    def __init__(self, cfg: CurriculumTermCfg, env: ManagerBasedRLEnv):
        super().__init__(cfg, env)
        if "address" not in cfg.params:
            raise ConfigError(f"{type(self).__name__}: params must name an 'address'")
        self._path = _parse_address(self._expand(cfg.params["address"]))
        _read(env, self._path)

    def __call__(
        self,
        env: ManagerBasedRLEnv,
        env_ids: EnvIds,
        address: str,
        modify_fn: Callable[..., Any],
        modify_params: dict[str, Any] | None = None,
    ) -> None:
        value = modify_fn(env, env_ids, _read(env, self._path), **(modify_params or {}))
        if value is not self.NO_CHANGE:
            _assign(env, self._path, value)

    def scheduled_rewards(self) -> list[str]:
        is_reward = self._path[:2] == ["reward_manager", "cfg"] and len(self._path) > 2
        return [str(self._path[2])] if is_reward else []

    def _expand(self, address: str) -> str:
        return address


class modify_term_cfg(modify_env_param):
    """Change the config of a manager's term: :class:`modify_env_param` with a shorter address.

    ``"commands.goal.ranges.pos_x"`` stands for ``"command_manager.cfg.goal.ranges.pos_x"``, and so for
    ``observations``, ``actions``, ``events``, ``rewards``, ``terminations`` and ``metrics``.
    """

    def _expand(self, address: str) -> str:
        group, dot, rest = address.partition(".")
        manager = "metrics_manager" if group == "metrics" else f"{group.removesuffix('s')}_manager"
        if not dot or not hasattr(self._env, manager):
            groups = ("observations", "actions", "commands", "events", "rewards", "terminations", "metrics")
            raise ConfigError(
                f"modify_term_cfg: address '{address}' must begin with a manager's name and a term: "
                f"{suggest(group, groups)}"
            )
        return f"{manager}.cfg.{rest}"


_STEP = re.compile(r"(?:^|\.)(\w+)|\[(\d+)\]|\[['\"]([^'\"]+)['\"]\]")


def _parse_address(address: str) -> list[str | int]:
    """``"a.b[2]['c']"`` as ``["a", "b", 2, "c"]``."""
    path: list[str | int] = []
    end = 0
    for match in _STEP.finditer(address):
        if match.start() != end:
            break
        name, index, key = match.groups()
        path.append(int(index) if index is not None else name or key)
        end = match.end()
    if end != len(address) or not path:
        raise ConfigError(f"'{address}' is not a path such as 'command_manager.cfg.goal.ranges.pos_x'")
    return path


def _read(root: Any, path: Sequence[str | int]) -> Any:
    for done, step in enumerate(path):
        if isinstance(root, (dict, list, tuple)) or (isinstance(step, int) and hasattr(root, "__getitem__")):
            known = root.keys() if isinstance(root, dict) else range(len(root))
            if step not in known:
                raise ConfigError(_missing(path, done, known))
            root = root[step]  # type: ignore[index]
        else:
            if not hasattr(root, str(step)):
                raise ConfigError(_missing(path, done, (n for n in dir(root) if not n.startswith("_"))))
            root = getattr(root, str(step))
    return root


def _missing(path: Sequence[str | int], done: int, choices: Any) -> str:
    where = ".".join(map(str, path[:done])) or "the environment"
    return f"{where} has no '{path[done]}': {suggest(str(path[done]), [str(c) for c in choices])}"


def _assign(root: Any, path: Sequence[str | int], value: Any) -> None:
    """Write the value; a tuple on the way is rebuilt, for it cannot be written into."""
    parent, last = _read(root, path[:-1]), path[-1]
    if isinstance(parent, tuple):
        items = list(parent)
        items[last] = value  # type: ignore[index]
        _assign(root, path[:-1], tuple(items))
    elif isinstance(last, int) or isinstance(parent, dict):
        parent[last] = value
    else:
        setattr(parent, last, value)
