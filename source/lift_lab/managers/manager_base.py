"""Base classes of managers and terms: they read a config's terms, check them and bind them to the scene.

A manager deep-copies its config, so a curriculum that edits ``manager.get_term_cfg(name)`` never reaches
``env.cfg``. All mistakes of a config are found here at construction, and errors name the term.
"""

from __future__ import annotations

import copy
import dataclasses
import inspect
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Sequence
from typing import TYPE_CHECKING, Any, ClassVar

import torch

from lift_lab.sim.physics.base import ids_tensor
from lift_lab.utils.dict import class_to_dict
from lift_lab.utils.errors import ConfigError, ConfigTypeError, NoCallError, NotCallableError, suggest
from lift_lab.utils.indexing import EnvIds
from lift_lab.utils.saved_state import Stateful
from lift_lab.utils.string import resolve_matching_names, string_to_callable

from .manager_term_cfg import ManagerTermBaseCfg
from .scene_entity_cfg import SceneEntityCfg

if TYPE_CHECKING:
    from lift_lab.envs import ManagerBasedEnv


def as_env_id_tensor(env_ids: EnvIds, num_envs: int, device: str | torch.device) -> torch.Tensor:
    """Environment ids in any form as a LongTensor of shape (num_ids,)."""
    if isinstance(env_ids, torch.Tensor):
        return env_ids
    if env_ids is None or isinstance(env_ids, slice):
        return torch.arange(num_envs, device=device)[env_ids or slice(None)]
    return ids_tensor(env_ids, torch.device(device))


def check_arguments(owner: str, func: Callable, params: dict[str, Any], fixed: Sequence[str]) -> None:
    """Check that ``func(*fixed, **params)`` can be called.

    Args:
        owner: What to call the function in the message, such as "reward term 'lift'".
        func: The function; an unbound ``__call__`` lists ``"self"`` in ``fixed``.
        params: The keyword arguments.
        fixed: Names of the positional arguments that the manager passes.

    Raises:
        ConfigError: arguments are missing or unexpected.
    """
    try:
        arguments = list(inspect.signature(func).parameters.values())
    except ValueError:  # built-in functions have no signature to check
        return
    kinds = {argument.kind for argument in arguments}
    positional = [a for a in arguments if a.kind in (a.POSITIONAL_ONLY, a.POSITIONAL_OR_KEYWORD)]
    if len(positional) < len(fixed) and inspect.Parameter.VAR_POSITIONAL not in kinds:
        raise ConfigError(f"{owner}: the function must take ({', '.join(fixed)}) as its first arguments")
    taken = {argument.name for argument in positional[: len(fixed)]}
    named = [a for a in arguments if a.kind in (a.POSITIONAL_OR_KEYWORD, a.KEYWORD_ONLY) and a.name not in taken]
    choices = [a.name for a in named]
    missing = [a.name for a in named if a.default is a.empty and a.name not in params]
    unexpected = [key for key in params if key not in choices]
    if inspect.Parameter.VAR_KEYWORD in kinds:
        unexpected = [key for key in unexpected if key in taken]
    if not missing and not unexpected:
        return
    problems = []
    if missing:
        problems.append(f"missing {', '.join(repr(name) for name in missing)}")
    for key in unexpected:
        problems.append(f"unexpected '{key}' ({suggest(key, choices)})")
    raise ConfigError(f"{owner}: its params do not fit the function's arguments: {'; '.join(problems)}")


def named_reward(cfg: Any) -> list[str] | None:
    """The reward term that a term's params name; None where they name none."""
    name = cfg.params.get("term_name")
    return None if name is None else [name]


class ManagerTermBase(Stateful):
    """A term with a state: built as ``func(cfg=..., env=...)``, then called like a function term.

    Source: Isaac Lab's ``ManagerTermBase``.
    """

    unsaved_attributes: ClassVar[frozenset[str]] = frozenset({"_env"})

    cfg: Any
    """The term's config."""

    _env: Any
    """The environment; set also in a sub-class that never calls this constructor."""

    def __init__(self, cfg: Any, env: ManagerBasedEnv):
        """Keep the config and the environment."""
        self.cfg = cfg
        self._env = env

    @property
    def num_envs(self) -> int:
        """Number of environments."""
        return self._env.num_envs

    @property
    def device(self) -> str:
        """Torch device of the environment."""
        return self._env.device

    @property
    def __name__(self) -> str:
        """Name of the class, as a function has one."""
        return type(self).__name__  # type: ignore[return-value]

    @classmethod
    def prepare_model(cls, env: ManagerBasedEnv, **params: Any) -> None:
        """Change the scene's spec, ``env.scene.spec``, before it is compiled; only called of event terms.

        Called once while the environment is built, for every mode of the term, and before there is an instance.

        Args:
            env: the environment; its simulation has not started.
            params: the term's ``params``, in which scene entities are not resolved yet.
        """

    def reset(self, env_ids: EnvIds = None) -> Any:
        """Forget the state of some environments; the base class has none."""

    def named_objects(self) -> dict[str, Any]:
        return self._env.named_objects()

    def scheduled_rewards(self) -> list[str] | None:
        """Reward terms whose weight a curriculum term changes. None where it may change any."""
        return named_reward(self.cfg)

    def serialize(self) -> dict[str, Any]:
        """The config as plain data."""
        cfg = class_to_dict(self.cfg)
        if cfg.get("func") is self:
            cfg["func"] = f"{type(self).__module__}:{type(self).__qualname__}"
        return {"cfg": cfg}

    def __deepcopy__(self, memo: dict[int, Any]) -> ManagerTermBase:
        """Itself: a copy of a config shares the term, which belongs to one environment."""
        return self

    def __call__(self, *args: Any, **kwargs: Any) -> Any:
        """The term's value."""
        raise NotImplementedError(f"the term class '{type(self).__name__}' has no __call__")


class ManagerBase(ABC, Stateful):
    """A set of terms read from a config.

    Source: Isaac Lab's ``ManagerBase``.
    """

    unsaved_attributes: ClassVar[frozenset[str]] = frozenset({"_env"})

    def __init__(self, cfg: object, env: ManagerBasedEnv):
        """Copy the config and prepare its terms.

        Args:
            cfg: A configclass, a dict of term configs, or None for no terms.
            env: The environment that the terms are called with.

        Raises:
            TypeError: a field is not a term config of this manager.
            ConfigError: a term's function, arguments or scene entity cannot be resolved.
        """
        self.cfg: Any = _copy_config(cfg)
        self._env: Any = env
        self._prepare_terms()

    @property
    def num_envs(self) -> int:
        """Number of environments."""
        return self._env.num_envs

    @property
    def device(self) -> str:
        """Torch device of the environment."""
        return self._env.device

    @property
    @abstractmethod
    def active_terms(self) -> list[str] | dict[str, list[str]]:
        """Names of the terms, by group or mode where the manager has those."""

    @abstractmethod
    def _prepare_terms(self) -> None:
        """Read the terms from the config."""

    def named_objects(self) -> dict[str, Any]:
        return self._env.named_objects()

    def term_objects(self) -> dict[str, Any]:
        """The terms that are objects, which have a state of their own, by name."""
        return {}

    def reset(self, env_ids: EnvIds = None) -> dict[str, Any]:
        """Reset the terms of some environments; returns log entries."""
        return {}

    def masks(self, dt: float, ended: torch.Tensor) -> dict[Any, torch.Tensor]:
        """Masks whose true rows the manager needs later in the step.

        On a GPU the host should not wait for single values. So the environment reads the masks of all managers at once,
        together with the mask of ended episodes. The results are in ``env.prefetched``. The manager reads masks that
        are not there by itself.

        Args:
            dt: The environment step in seconds.
            ended: Environments that will be reset in this step, shape (num_envs,).

        Returns:
            Bool tensors of shape (num_envs,) by the key of the answer, which is a LongTensor.
        """
        return {}

    def find_terms(self, name_keys: str | Sequence[str]) -> list[str]:
        """Names of the terms that match a regular expression or several.

        Raises:
            ValueError: an expression matches no term.
        """
        names = self.active_terms
        if isinstance(names, dict):
            names = [name for group in names.values() for name in group]
        return resolve_matching_names(name_keys, names)[1]

    def get_active_iterable_terms(self, env_idx: int) -> list[tuple[str, list[float]]]:
        """Name and current values of every term in one environment, for a viewer's plots."""
        raise NotImplementedError(f"{type(self).__name__} keeps no value for each environment")

    def _put_term_cfg(self, term_name: str, term_cfg: Any) -> None:
        """Put a term's new config in the place of the old one in :attr:`cfg`, if it is from there."""
        if isinstance(self.cfg, dict) and term_name in self.cfg:
            self.cfg[term_name] = term_cfg
        elif hasattr(self.cfg, term_name):
            setattr(self.cfg, term_name, term_cfg)

    def _owner(self, term_name: str) -> str:
        """How messages call a term."""
        return f"{type(self).__name__} term '{term_name}'"

    def _term_items(self, term_type: type, cfg: Any, settings: Sequence[str] = ()) -> Iterator[tuple[str, Any]]:
        """Name and config of every term in a config, in declaration order, without terms set to None.

        Raises:
            TypeError: a field is neither a setting nor a ``term_type``.
        """
        if cfg is None:
            return
        for name, term_cfg in (cfg if isinstance(cfg, dict) else vars(cfg)).items():
            if name in settings or term_cfg is None:
                continue
            self._check_type(name, term_cfg, term_type)
            yield name, term_cfg

    def _check_type(self, name: str, term_cfg: Any, term_type: type) -> None:
        if not isinstance(term_cfg, term_type):
            given = type(term_cfg).__name__
            raise ConfigTypeError(f"{self._owner(name)} must be of type {term_type.__name__}, not '{given}'")

    def _resolve_common_term_cfg(self, term_name: str, term_cfg: ManagerTermBaseCfg, min_argc: int = 1) -> None:
        """Find and check the term's function, then bind the term to the scene.

        Args:
            term_name: Name in messages.
            term_cfg: Config, whose ``func`` and ``params`` are resolved in place.
            min_argc: Positional arguments that the manager passes: 1 for (env), 2 for (env, env_ids).
        """
        self._check_term(term_name, term_cfg, min_argc)
        self._bind_term(term_name, term_cfg)

    def _check_term(self, term_name: str, term_cfg: ManagerTermBaseCfg, min_argc: int) -> None:
        """What needs no scene: the function exists and takes the params."""
        owner = self._owner(term_name)
        if isinstance(term_cfg.func, str):
            try:
                term_cfg.func = string_to_callable(term_cfg.func)
            except ValueError as error:
                raise ConfigError(f"{owner}: {error}") from error
        func: Any = term_cfg.func
        if not callable(func):
            raise NotCallableError(f"{owner}: func is not callable: {func!r}")
        fixed = ["env", "env_ids"][:min_argc]
        if inspect.isclass(func):
            if not issubclass(func, ManagerTermBase):
                raise ConfigTypeError(f"{owner}: the class '{func.__name__}' is not a sub-class of ManagerTermBase")
            if func.__call__ is ManagerTermBase.__call__:
                raise NoCallError(f"{owner}: the class '{func.__name__}' has no __call__")
            func, fixed = func.__call__, ["self", *fixed]
        check_arguments(owner, func, term_cfg.params, fixed)
        self._adopt_default_entities(term_cfg, func)

    @staticmethod
    def _adopt_default_entities(term_cfg: ManagerTermBaseCfg, func: Callable) -> None:
        """Take default arguments that select joints or bodies by name into ``params``, where they get resolved."""
        try:
            arguments = inspect.signature(func).parameters.values()
        except ValueError:
            return
        for argument in arguments:
            default = argument.default
            if isinstance(default, SceneEntityCfg) and default.selects_by_name:
                term_cfg.params.setdefault(argument.name, copy.deepcopy(default))

    def _bind_term(self, term_name: str, term_cfg: ManagerTermBaseCfg) -> None:
        """What needs the scene: indices of scene entities, then the instance of a class term."""
        for key, value in term_cfg.params.items():
            for entity in _scene_entities(value):
                try:
                    entity.resolve(self._env.scene)
                except ValueError as error:
                    raise ConfigError(f"{self._owner(term_name)}, param '{key}': {error}") from error
        if inspect.isclass(term_cfg.func):
            self._build_term(term_cfg)

    def _build_term(self, term_cfg: ManagerTermBaseCfg) -> None:
        """Replace a class term by its instance, which gets its environment whatever its constructor does."""
        term = term_cfg.func(cfg=term_cfg, env=self._env)  # type: ignore[operator]
        for name, value in (("cfg", term_cfg), ("_env", self._env)):
            if not hasattr(term, name):
                setattr(term, name, value)
        term_cfg.func = term


def _copy_config(value: Any) -> Any:
    """A deep copy in which nothing appears twice: terms that share an object each get their own."""
    if isinstance(value, dict):
        return {key: _copy_config(item) for key, item in value.items()}
    if type(value) in (list, tuple):
        return type(value)(_copy_config(item) for item in value)
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        duplicate = copy.copy(value)
        vars(duplicate).update({name: _copy_config(item) for name, item in vars(value).items()})
        return duplicate
    return copy.deepcopy(value)


def _scene_entities(value: Any) -> Iterator[SceneEntityCfg]:
    """Scene entities in a parameter, also inside lists, tuples and dicts."""
    if isinstance(value, SceneEntityCfg):
        yield value
    elif isinstance(value, (list, tuple, dict)):
        for item in value.values() if isinstance(value, dict) else value:
            yield from _scene_entities(item)
