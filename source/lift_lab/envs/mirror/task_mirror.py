"""Mirror images of the observations and actions of an environment, put together from its terms."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterable, Mapping
from typing import TYPE_CHECKING, Any

import torch

from lift_lab.managers import ManagerTermBase, ObservationTermCfg
from lift_lab.utils.errors import ConfigError, quote, suggest
from lift_lab.utils.mirror import KINDS, MirrorMap, MirrorTermCfg, kind_of, map_of_kind

from .joints import JointMirror
from .known_terms import ACTIONS, COMMANDS, OBSERVATIONS

if TYPE_CHECKING:
    from lift_lab.envs import ManagerBasedEnv


class TaskMirror:
    """Maps observations and actions of an environment to those of its mirror image.

    Attributes:
        env: the environment.
        cfg: the task's declaration.
    """

    def __init__(self, env: ManagerBasedEnv):
        """Read the declaration, ``env.cfg.mirror``.

        Raises:
            ConfigError: there is none, or it names what the environment does not have.
        """
        if env.cfg.mirror is None:
            raise ConfigError(
                "the task does not say how it mirrors: set env.mirror to a MirrorCfg with the robot's joints, or give "
                "agent.algorithm.symmetry_cfg a data_augmentation_func of your own"
            )
        self.env, self.cfg = env, env.cfg.mirror
        self._joints: dict[str, JointMirror] = {}
        self._check_names()

    # -- parts

    def group(self, name: str) -> MirrorMap:
        """Map of an observation group, history included.

        Raises:
            ConfigError: a term has no known mirror image, or the group is not one vector.
        """
        manager = self.env.observation_manager
        shapes = manager.group_obs_term_dim[name]
        if not manager.group_obs_concatenate[name] or any(len(shape) != 1 for shape in shapes):
            raise ConfigError(
                f"env.observations.{name} has no mirror image: it is not one vector; set concatenate_terms=True and "
                "leave out terms of other shapes"
            )
        terms = zip(manager.active_terms[name], manager.group_obs_term_cfgs[name], strict=True)
        return MirrorMap.cat(
            [image for term, cfg in terms for image in [self.observation(name, term)] * max(cfg.history_length, 1)]
        )

    def observation(self, group: str, name: str) -> MirrorMap:
        """Map of one value of an observation term, as it is without history."""
        manager = self.env.observation_manager
        index = manager.active_terms[group].index(name)
        cfg, owner = manager.group_obs_term_cfgs[group][index], f"env.observations.{group}.{name}"
        dim = manager.group_obs_term_dim[group][index][-1]
        if cfg.history_length > 0 and cfg.flatten_history_dim:
            dim //= cfg.history_length
        declared = self.cfg.observations.get(f"{group}/{name}", self.cfg.observations.get(name))
        if declared is not None:
            return self._as_map(declared, dim, owner)
        return self._known_observation(name, cfg, dim, owner)

    def actions(self) -> MirrorMap:
        """Map of the whole action."""
        return MirrorMap.cat([self.action(name) for name in self.env.action_manager.active_terms])

    def action(self, name: str) -> MirrorMap:
        """Map of the raw action of one term."""
        term: Any = self.env.action_manager.get_term(name)
        declared = self.cfg.actions.get(name)
        if declared is None:
            declared = self._known(ACTIONS, type(term), term, f"env.actions.{name}", f"env.mirror.actions.{name}")
        return self._as_map(declared, term.action_dim, f"env.actions.{name}")

    def command(self, name: str) -> MirrorMap:
        """Map of a command."""
        manager: Any = self.env.command_manager  # pyright: ignore[reportAttributeAccessIssue]
        term = manager.get_term(name)
        declared = self.cfg.commands.get(name)
        if declared is None:
            declared = self._known(COMMANDS, type(term), term, f"env.commands.{name}", f"env.mirror.commands.{name}")
        return self._as_map(declared, term.command.shape[1], f"env.commands.{name}")

    def joints(self, asset_name: str) -> JointMirror:
        """Joints of an articulation.

        Raises:
            ConfigError: they are not declared.
        """
        if asset_name not in self.cfg.assets:
            raise ConfigError(
                f"env.mirror.assets does not say how the joints of '{asset_name}' mirror; add an ArticulationMirrorCfg "
                f"with this name. It has {quote(self.cfg.assets) or 'none'}"
            )
        if asset_name not in self._joints:
            path = f"env.mirror.assets.{asset_name}"
            self._joints[asset_name] = JointMirror(self.env.scene[asset_name], self.cfg.assets[asset_name], path)
        return self._joints[asset_name]

    # -- terms

    def _known_observation(self, name: str, cfg: ObservationTermCfg, dim: int, owner: str) -> MirrorMap:
        path = f"env.mirror.observations.{name}"
        if cfg.modifiers:
            raise ConfigError(f"{owner} has modifiers, so its mirror image is not known; {_how(path)}")
        function: Any = type(cfg.func) if isinstance(cfg.func, ManagerTermBase) else cfg.func
        kind = kind_of(function)
        if kind is None:
            if function not in OBSERVATIONS:
                called = getattr(function, "__name__", function)
                raise ConfigError(f"{owner}: '{called}' is not a known term; {_how(path)}")
            kind = OBSERVATIONS[function](self, _arguments(function, cfg.params))
        image = self._as_map(kind, dim, owner)
        _check_clip(cfg, image, owner, path)
        if cfg.scale is None:
            return image
        return image.in_units(1.0 / torch.as_tensor(cfg.scale, dtype=torch.float64))

    def _known(self, table: Mapping[type, Callable], cls: type, term: Any, owner: str, path: str) -> Any:
        """The kind of a term of a known class, or of a sub-class of one."""
        for base in cls.__mro__:
            if base in table:
                return table[base](self, term)
        raise ConfigError(f"{owner}: '{cls.__name__}' is not a known class of terms; {_how(path)}")

    def _as_map(self, kind: str | MirrorTermCfg | MirrorMap, dim: int, owner: str) -> MirrorMap:
        found = kind if isinstance(kind, MirrorMap) else map_of_kind(kind, dim, owner)
        if len(found) != dim:
            raise ConfigError(f"{owner}: it has {dim} numbers, its mirror image {len(found)}")
        return found

    def _check_names(self) -> None:
        """Complain about declarations of what the environment does not have."""
        env: Any = self.env
        terms = env.observation_manager.active_terms
        observations = {name for names in terms.values() for name in names}
        observations |= {f"{group}/{name}" for group, names in terms.items() for name in names}
        commands = env.command_manager.active_terms if hasattr(env, "command_manager") else []
        for field, given, known in (
            ("assets", self.cfg.assets, env.scene.articulations),
            ("observations", self.cfg.observations, observations),
            ("actions", self.cfg.actions, env.action_manager.active_terms),
            ("commands", self.cfg.commands, commands),
        ):
            _check_known(f"env.mirror.{field}", given, known)


def _check_known(path: str, given: Iterable[str], known: Iterable[str]) -> None:
    names = list(known)
    for name in given:
        if name not in names:
            raise ConfigError(f"{path}: the environment has no '{name}'; {suggest(name, names)}")


def _how(path: str) -> str:
    """What to do about a term that is not known."""
    return f"declare its mirror image: {path} = one of {quote(KINDS)}, or a MirrorTermCfg"


def _arguments(function: Callable, params: dict[str, Any]) -> dict[str, Any]:
    """Arguments of a term's call, with those that the function gives itself."""
    own = inspect.signature(function).parameters
    defaults = {name: p.default for name, p in own.items() if p.default is not inspect.Parameter.empty}
    return defaults | params


def _check_clip(cfg: ObservationTermCfg, image: MirrorMap, owner: str, path: str) -> None:
    """Clipping and mirroring have to commute."""
    if cfg.clip is None:
        return
    low, high = (-torch.inf if cfg.clip[0] is None else cfg.clip[0], torch.inf if cfg.clip[1] is None else cfg.clip[1])
    moved = bool((image.offset != 0.0).any()) or (bool((image.factor < 0.0).any()) and low != -high)
    if moved:
        raise ConfigError(f"{owner} is clipped to ({low}, {high}), which is not symmetric; {_how(path)}")
