"""Observations: groups of terms, each term processed in a fixed order.

func -> modifiers -> noise -> clip -> scale -> history. A value that the simulation may overwrite is copied before it is
changed in place. Every returned tensor is new, so callers may keep it.
"""

from __future__ import annotations

import copy
import dataclasses
import inspect
import math
from typing import TYPE_CHECKING, Any, ClassVar

import torch

from lift_lab.utils.dict import class_to_dict
from lift_lab.utils.errors import ConfigError, ConfigTypeError, NotCallableError, ShapeError, suggest
from lift_lab.utils.io_descriptors import describe_observation, formatted
from lift_lab.utils.modifiers import ModifierBase, ModifierCfg
from lift_lab.utils.noise import NoiseModel, NoiseModelCfg

from ._history import ObservationHistory
from ._table import render_table
from .manager_base import EnvIds, ManagerBase, ManagerTermBase, check_arguments
from .manager_term_cfg import ObservationGroupCfg, ObservationTermCfg

if TYPE_CHECKING:
    from lift_lab.envs import ManagerBasedEnv

_GROUP_SETTINGS = tuple(field.name for field in dataclasses.fields(ObservationGroupCfg))

_OVERLOADS = ("clip", "scale", "history_length", "flatten_history_dim")

Observation = torch.Tensor | dict[str, torch.Tensor]
"""Observations of a group: one tensor, or one for each term."""


class ObservationManager(ManagerBase):
    """Computes groups of observations.

    Source: Isaac Lab's ``ObservationManager``.
    """

    unsaved_attributes: ClassVar[frozenset[str]] = frozenset(
        {"_group_obs_term_names", "_group_obs_dim", "_group_obs_term_dim", "_group_obs_term_cfgs"}
        | {"_group_obs_concatenate", "_group_obs_concatenate_dim", "_raw_values"}
    )

    def __init__(self, cfg: object, env: ManagerBasedEnv):
        """Prepare the terms and call each once to learn its shape.

        Raises:
            ConfigError: the config is None, or a term's fields are wrong.
            RuntimeError: terms of a group to concatenate have shapes that do not fit.
        """
        if cfg is None:
            raise ConfigError("the environment's config has no observations: set `observations` to a config of groups")
        super().__init__(cfg, env)
        self._group_obs_dim = {name: self._group_dim(name) for name in self._group_obs_term_names}
        self._obs_buffer: dict[str, Observation] | None = None

    def __str__(self) -> str:
        tables = []
        for group, names in self._group_obs_term_names.items():
            shape = f" (shape: {self._group_obs_dim[group]})" if self._group_obs_concatenate[group] else ""
            rows = [(i, *row) for i, row in enumerate(zip(names, self._group_obs_term_dim[group], strict=True))]
            title = f"Active Observation Terms in Group: '{group}'{shape}"
            tables.append(render_table(title, ["Index", "Name", "Shape"], rows))
        return f"<ObservationManager> contains {len(self._group_obs_term_names)} groups.\n{''.join(tables)}"

    @property
    def active_terms(self) -> dict[str, list[str]]:
        """Names of the terms by group."""
        return self._group_obs_term_names

    def term_objects(self) -> dict[str, Any]:
        return {
            f"{group}/{name}": cfg.func
            for group, names in self._group_obs_term_names.items()
            for name, cfg in zip(names, self._group_obs_term_cfgs[group], strict=True)
            if isinstance(cfg.func, ManagerTermBase)
        }

    @property
    def group_obs_dim(self) -> dict[str, tuple[int, ...] | list[tuple[int, ...]]]:
        """Shape of each group for one environment; of a group that is a dict, the list of its terms'
        shapes."""
        return self._group_obs_dim

    @property
    def group_obs_term_dim(self) -> dict[str, list[tuple[int, ...]]]:
        """Shapes of the terms of each group for one environment, history included."""
        return self._group_obs_term_dim

    @property
    def group_obs_concatenate(self) -> dict[str, bool]:
        """Whether each group is one tensor."""
        return self._group_obs_concatenate

    @property
    def group_obs_concatenate_dim(self) -> dict[str, int]:
        """Dimension along which the terms of each group are concatenated, counting that of the environments."""
        return self._group_obs_concatenate_dim

    @property
    def group_obs_term_cfgs(self) -> dict[str, list[ObservationTermCfg]]:
        """Live configs of each group's terms, in the order of :attr:`active_terms`."""
        return self._group_obs_term_cfgs

    def compute(self, update_history: bool = False) -> dict[str, Observation]:
        """Compute all groups.

        Args:
            update_history: Whether the values enter the histories; otherwise the histories stay as they are.

        Returns:
            By group name: a tensor of shape (num_envs, ...), or a dict of them by term name.
        """
        self._obs_buffer = {name: self.compute_group(name, update_history) for name in self._group_obs_term_names}
        return self._obs_buffer

    def preview(self) -> dict[str, Observation]:
        """Return what ``compute(update_history=True)`` would return, and leave histories, modifiers and noise models
        unchanged.

        Terms are called and noise is drawn. A term that is a class with a state gets one call more.
        """
        return {name: self.compute_group(name, preview=True) for name in self._group_obs_term_names}

    def compute_group(self, group_name: str, update_history: bool = False, preview: bool = False) -> Observation:
        """Compute one group; see :meth:`compute` and, for ``preview``, :meth:`preview`.

        Raises:
            ConfigError: no group has this name.
        """
        if group_name not in self._group_obs_term_names:
            hint = suggest(group_name, self._group_obs_term_names)
            raise ConfigError(f"there is no observation group '{group_name}': {hint}")
        concatenate = self._group_obs_concatenate[group_name]
        histories = self._group_obs_term_history_buffer[group_name]
        observations: dict[str, torch.Tensor] = {}
        for name, cfg in zip(
            self._group_obs_term_names[group_name], self._group_obs_term_cfgs[group_name], strict=True
        ):
            value = self._process(cfg, preview)
            if name in histories:
                history = copy.copy(histories[name]) if preview else histories[name]
                value = history.push(value) if update_history or preview else history.peek(value)
                if cfg.flatten_history_dim:
                    value = value.reshape(self.num_envs, -1)
            elif not concatenate:
                value = value.clone()
            observations[name] = value
        if not concatenate:
            return observations
        return torch.cat(list(observations.values()), dim=self._group_obs_concatenate_dim[group_name])

    def clean_value(self, group_name: str, term_name: str) -> torch.Tensor:
        """Return a term's value without noise and history, shape (num_envs, ...). Modifiers keep their states."""
        index = self._group_obs_term_names[group_name].index(term_name)
        return self._process(self._group_obs_term_cfgs[group_name][index].replace(noise=None), preview=True)

    def _process(self, cfg: ObservationTermCfg, preview: bool = False) -> torch.Tensor:
        """A term's value up to the scale; a view of the simulation where nothing is configured."""
        value: torch.Tensor = cfg.func(self._env, **cfg.params)  # type: ignore[operator]
        noise: Any = cfg.noise
        if cfg.modifiers or noise is not None:
            value = value.clone()
            for modifier in cfg.modifiers or ():
                func = copy.deepcopy(modifier.func) if preview else modifier.func
                value = func(value, **modifier.params)
            if isinstance(noise, NoiseModelCfg):
                model = copy.deepcopy(noise.func) if preview else noise.func
                value = model(value)  # type: ignore[misc]
            elif noise is not None:
                value = noise.func(value, noise)
        if cfg.clip is not None:
            value = value.clamp(cfg.clip[0], cfg.clip[1])
        if cfg.scale is not None:
            scale: Any = cfg.scale  # a tensor once the manager is built
            value = value * scale
        return value

    def reset(self, env_ids: EnvIds = None) -> dict[str, Any]:
        """Reset class terms, histories, modifiers and noise models; logs nothing."""
        for item in self._resettable:
            item.reset(env_ids)
        return {}

    def get_active_iterable_terms(self, env_idx: int) -> list[tuple[str, list[float]]]:
        groups = self._obs_buffer if self._obs_buffer is not None else self.compute()
        terms = []
        for group, names in self._group_obs_term_names.items():
            value = groups[group]
            if isinstance(value, torch.Tensor):
                dim = self._group_obs_concatenate_dim[group]
                axis = dim - 1 if dim >= 0 else dim
                lengths = [shape[axis] for shape in self._group_obs_term_dim[group]]
                parts = value[env_idx].split(lengths, dim=axis)
            else:
                parts = [value[name][env_idx] for name in names]
            terms += [(f"{group}-{name}", part.tolist()) for name, part in zip(names, parts, strict=True)]
        return terms

    def serialize(self) -> dict[str, dict[str, dict]]:
        """The terms' configs as plain data, by group and term."""
        return {
            group: {
                name: cfg.func.serialize() if isinstance(cfg.func, ManagerTermBase) else {"cfg": class_to_dict(cfg)}
                for name, cfg in zip(names, self._group_obs_term_cfgs[group], strict=True)
            }
            for group, names in self._group_obs_term_names.items()
        }

    @property
    def get_IO_descriptors(self) -> dict[str, list[dict[str, Any]]]:
        """Descriptions of the terms of the group "policy" as plain data, in order. A property, as in Isaac Lab."""
        names = self._group_obs_term_names.get("policy")
        return {} if names is None else {"policy": [self.describe_term("policy", name) for name in names]}

    def describe_term(self, group_name: str, term_name: str) -> dict[str, Any]:
        """Description of a term as plain data, with Isaac Lab's keys.

        ``overloads`` holds the clip, the scale and the history of its config. ``shape`` is that of its function's
        value in one environment, before history.
        """
        index = self._group_obs_term_names[group_name].index(term_name)
        cfg = self._group_obs_term_cfgs[group_name][index]
        function: Any = cfg.func
        if isinstance(function, ManagerTermBase):  # a call may change its state
            value = self._raw_values[f"{group_name}/{term_name}"]
        else:
            value = function(self._env, **cfg.params)
        descriptor = describe_observation(function, self._env, cfg.params, value)
        overloads: dict[str, Any] = {name: getattr(cfg, name) for name in _OVERLOADS}
        overloads["modifiers"] = cfg.modifiers and [
            {"func": m.func if inspect.isroutine(m.func) else type(m.func), "params": m.params} for m in cfg.modifiers
        ]
        return formatted(descriptor, overloads)

    def _prepare_terms(self) -> None:
        self._raw_values: dict[str, torch.Tensor] = {}  # without data: shapes and types of what the functions return
        self._group_obs_term_names: dict[str, list[str]] = {}
        self._group_obs_term_dim: dict[str, list[tuple[int, ...]]] = {}
        self._group_obs_term_cfgs: dict[str, list[ObservationTermCfg]] = {}
        self._group_obs_concatenate: dict[str, bool] = {}
        self._group_obs_concatenate_dim: dict[str, int] = {}
        self._group_obs_term_history_buffer: dict[str, dict[str, ObservationHistory]] = {}
        self._resettable: list[Any] = []
        for group, group_cfg in self._term_items(ObservationGroupCfg, self.cfg):
            dim = group_cfg.concatenate_dim
            self._group_obs_concatenate[group] = group_cfg.concatenate_terms
            self._group_obs_concatenate_dim[group] = dim + 1 if dim >= 0 else dim
            self._group_obs_term_names[group] = []
            self._group_obs_term_dim[group] = []
            self._group_obs_term_cfgs[group] = []
            self._group_obs_term_history_buffer[group] = {}
            for name, cfg in self._term_items(ObservationTermCfg, group_cfg, _GROUP_SETTINGS):
                self._prepare_term(group, name, cfg, group_cfg)
            if not self._group_obs_term_names[group]:
                raise ConfigError(f"env.observations.{group} has no term: set the group to None to leave it out")

    def _prepare_term(self, group: str, name: str, cfg: ObservationTermCfg, group_cfg: ObservationGroupCfg) -> None:
        path = f"{group}/{name}"
        self._resolve_common_term_cfg(path, cfg)
        if not group_cfg.enable_corruption:
            cfg.noise = None
        if group_cfg.history_length is not None:
            cfg.history_length = group_cfg.history_length
            cfg.flatten_history_dim = group_cfg.flatten_history_dim
        value: torch.Tensor = cfg.func(self._env, **cfg.params)  # type: ignore[operator]
        self._raw_values[path] = torch.empty_like(value, device="meta")
        shape = tuple(value.shape)
        if isinstance(cfg.func, ManagerTermBase):
            cfg.func.reset()  # the call above may have changed its state
            self._resettable.append(cfg.func)
        self._prepare_scale(path, cfg, shape)
        self._prepare_modifiers(path, cfg, shape)
        self._prepare_noise(path, cfg)
        if cfg.history_length > 0:
            history = ObservationHistory(cfg.history_length, self.num_envs, self.device)
            self._group_obs_term_history_buffer[group][name] = history
            self._resettable.append(history)
            shape = (shape[0], cfg.history_length, *shape[1:])
            if cfg.flatten_history_dim:
                shape = (shape[0], math.prod(shape[1:]))
        self._group_obs_term_names[group].append(name)
        self._group_obs_term_dim[group].append(shape[1:])
        self._group_obs_term_cfgs[group].append(cfg)

    def _prepare_scale(self, path: str, cfg: ObservationTermCfg, shape: tuple[int, ...]) -> None:
        """Check the scale and turn a tuple into a tensor; a number stays one."""
        if cfg.scale is None or isinstance(cfg.scale, (int, float)):
            return
        if not isinstance(cfg.scale, tuple):
            raise ConfigTypeError(f"{self._owner(path)}: scale must be a number or a tuple, not {cfg.scale!r}")
        if len(cfg.scale) != shape[-1]:
            raise ConfigError(f"{self._owner(path)}: scale has {len(cfg.scale)} entries, the observation {shape[-1]}")
        cfg.scale = torch.tensor(cfg.scale, dtype=torch.float, device=self.device)  # type: ignore[assignment]

    def _prepare_modifiers(self, path: str, cfg: ObservationTermCfg, shape: tuple[int, ...]) -> None:
        """Check the modifiers and build those that are classes."""
        for modifier in cfg.modifiers or ():
            if not isinstance(modifier, ModifierCfg):
                raise ConfigTypeError(f"{self._owner(path)}: a modifier must be a ModifierCfg, not {modifier!r}")
            if inspect.isclass(modifier.func):
                if not issubclass(modifier.func, ModifierBase):
                    name = modifier.func.__name__
                    raise ConfigTypeError(f"{self._owner(path)}: the modifier class '{name}' is not a ModifierBase")
                modifier.func = modifier.func(cfg=modifier, data_dim=shape, device=self.device)
                self._resettable.append(modifier.func)
            if not callable(modifier.func):
                raise NotCallableError(f"{self._owner(path)}: a modifier is not callable: {modifier.func!r}")
            check_arguments(f"{self._owner(path)}, a modifier", modifier.func, modifier.params, ["data"])

    def _prepare_noise(self, path: str, cfg: ObservationTermCfg) -> None:
        """Build the noise model, if the noise is one."""
        noise: Any = cfg.noise
        if not isinstance(noise, NoiseModelCfg):
            return
        if not issubclass(noise.class_type, NoiseModel):
            name = noise.class_type.__name__
            raise ConfigTypeError(f"{self._owner(path)}: the noise model class '{name}' is not a NoiseModel")
        noise.func = noise.class_type(noise, num_envs=self.num_envs, device=self.device)
        self._resettable.append(noise.func)

    def _group_dim(self, group: str) -> tuple[int, ...] | list[tuple[int, ...]]:
        """Shape of a group for one environment.

        Raises:
            RuntimeError: the terms cannot be concatenated.
        """
        shapes = self._group_obs_term_dim[group]
        if not self._group_obs_concatenate[group]:
            return shapes
        dim = self._group_obs_concatenate_dim[group]
        axis = dim - 1 if dim >= 0 else dim
        rank = len(shapes[0]) if shapes else 0
        fits = -rank <= axis < rank and all(len(shape) == rank for shape in shapes)
        if fits:
            others = {shape[: axis % rank] + shape[axis % rank + 1 :] for shape in shapes}
            fits = len(others) == 1
        if not fits:
            listed = dict(zip(self._group_obs_term_names[group], shapes, strict=True))
            raise ShapeError(
                f"the terms of observation group '{group}' cannot be concatenated along dimension {axis}:"
                f" their shapes are {listed}; set concatenate_terms=False to get them as a dict"
            )
        combined = list(shapes[0])
        combined[axis] = sum(shape[axis] for shape in shapes)
        return tuple(combined)
