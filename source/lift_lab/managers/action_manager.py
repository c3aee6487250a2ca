"""Actions: the policy's vector cut into slices, one for each term that drives an asset."""

from __future__ import annotations

import re
from abc import ABC, abstractmethod
from typing import TYPE_CHECKING, Any, ClassVar

import torch

from lift_lab.utils.errors import ConfigError
from lift_lab.utils.indexing import fill_rows
from lift_lab.utils.io_descriptors import GenericActionIODescriptor, formatted

from ._table import render_table
from ._term_managers import DebugVisTerm, ObjectTermManager
from .manager_base import EnvIds
from .manager_term_cfg import ActionTermCfg

if TYPE_CHECKING:
    from lift_lab.envs import ManagerBasedEnv


class ActionTerm(DebugVisTerm, ABC):
    """Turns its slice of the action into targets of one asset.

    Source: Isaac Lab's ``ActionTerm``.
    """

    unsaved_attributes: ClassVar[frozenset[str]] = frozenset({"_asset", "_IO_descriptor"})

    cfg: Any
    """The term's config."""

    constant_over_substeps: ClassVar[bool] = False
    """Whether :meth:`apply_actions` writes the same values at every physics step of an environment step. Then it is
    called once for all of them. The value counts for the class that defines :meth:`apply_actions`: a class that
    overrides the method sets it again."""

    _asset: Any
    """The scene entity that the actions drive."""

    _IO_descriptor: GenericActionIODescriptor
    """What :attr:`IO_descriptor` returned last."""

    export_IO_descriptor: ClassVar[bool] = True
    """Whether :attr:`ActionManager.get_IO_descriptors` holds the term."""

    def __init_subclass__(cls, **kwargs: Any):
        super().__init_subclass__(**kwargs)
        applies, says = (
            next(i for i, base in enumerate(cls.__mro__) if name in vars(base))
            for name in ("apply_actions", "constant_over_substeps")
        )
        if applies < says:
            cls.constant_over_substeps = False

    def __init__(self, cfg: ActionTermCfg, env: ManagerBasedEnv):
        """Look up the asset in the scene."""
        super().__init__(cfg, env)
        self._asset = env.scene[cfg.asset_name]

    @property
    @abstractmethod
    def action_dim(self) -> int:
        """Length of the term's slice."""

    @property
    @abstractmethod
    def raw_actions(self) -> torch.Tensor:
        """The slice as the policy gave it. Shape is (num_envs, action_dim)."""

    @property
    @abstractmethod
    def processed_actions(self) -> torch.Tensor:
        """The targets made from it, in the asset's units. Shape is (num_envs, number of targets)."""

    @property
    def IO_descriptor(self) -> GenericActionIODescriptor:
        """Description of the term. Sub-classes add the data that a program needs to apply the actions."""
        cls = type(self)
        self._IO_descriptor = GenericActionIODescriptor(
            name=re.sub(r"([a-z])([A-Z])", r"\1_\2", cls.__name__).lower(),
            full_path=f"{cls.__module__}.{cls.__name__}",
            description=" ".join((cls.__doc__ or "").split()),
            shape=(self.action_dim,),
            dtype=str(self.raw_actions.dtype),
            export=self.export_IO_descriptor,
        )
        return self._IO_descriptor

    @abstractmethod
    def process_actions(self, actions: torch.Tensor) -> None:
        """Take a new slice; called once each environment step.

        Args:
            actions: Shape is (num_envs, action_dim). A view that later steps overwrite: make a copy to keep it.
        """

    @abstractmethod
    def apply_actions(self) -> None:
        """Write the targets to the asset; called before each physics step."""


class ActionManager(ObjectTermManager):
    """Cuts the action into slices and hands them to the terms.

    Source: Isaac Lab's ``ActionManager``.
    """

    term_cfg_type = ActionTermCfg
    term_type = ActionTerm

    unsaved_attributes: ClassVar[frozenset[str]] = frozenset({"_action_term_dim", "_total_action_dim", "_slices"})

    def __init__(self, cfg: object, env: ManagerBasedEnv):
        """Build the terms.

        Raises:
            ConfigError: the config is None.
        """
        if cfg is None:
            raise ConfigError("the environment's config has no actions: set `actions` to a config of action terms")
        super().__init__(cfg, env)
        self._action_term_dim = [term.action_dim for term in self._terms.values()]
        self._total_action_dim = sum(self._action_term_dim)
        starts = [sum(self._action_term_dim[:i]) for i in range(len(self._action_term_dim))]
        self._slices = [slice(i, i + n) for i, n in zip(starts, self._action_term_dim, strict=True)]
        self._both_actions = torch.zeros(2, self.num_envs, self._total_action_dim, device=self.device)
        self._action, self._prev_action = self._both_actions.unbind()

    def __str__(self) -> str:
        rows = [(i, *row) for i, row in enumerate(zip(self._terms, self._action_term_dim, strict=True))]
        title = f"Active Action Terms (shape: {self._total_action_dim})"
        return (
            f"<ActionManager> contains {len(self._terms)} active terms.\n"
            f"{render_table(title, ['Index', 'Name', 'Dimension'], rows)}"
        )

    @property
    def total_action_dim(self) -> int:
        """Length of the action vector."""
        return self._total_action_dim

    @property
    def action_term_dim(self) -> list[int]:
        """Length of each term's slice."""
        return self._action_term_dim

    @property
    def action(self) -> torch.Tensor:
        """The latest action, raw and unclipped. Shape is (num_envs, total_action_dim)."""
        return self._action

    @property
    def prev_action(self) -> torch.Tensor:
        """The action before it. Shape is (num_envs, total_action_dim)."""
        return self._prev_action

    @property
    def get_IO_descriptors(self) -> list[dict[str, Any]]:
        """Descriptions of the terms as plain data, in the order of the action vector. A property, as in Isaac Lab."""
        found = (formatted(term.IO_descriptor) for term in self._terms.values())
        return [description for description in found if description]

    def process_action(self, action: torch.Tensor) -> None:
        """Store an action and hand each term its slice; called once each environment step.

        Args:
            action: Shape is (num_envs, total_action_dim).

        Raises:
            ValueError: the action has another shape.
        """
        if action.shape != self._action.shape:
            raise ConfigError(
                f"the action has shape {tuple(action.shape)}, expected {tuple(self._action.shape)}: a row for"
                f" each environment, {self._total_action_dim} columns for the terms {list(self._terms)}"
            )
        self._action, self._prev_action = self._prev_action, self._action
        self._action.copy_(action)
        for term, columns in zip(self._terms.values(), self._slices, strict=True):
            term.process_actions(self._action[:, columns])

    def apply_action(self) -> None:
        """Have every term write its targets; called before each physics step."""
        for term in self._terms.values():
            term.apply_actions()

    def reset(self, env_ids: EnvIds = None) -> dict[str, Any]:
        """Zero both actions of some environments and reset the terms; logs nothing."""
        ids = slice(None) if env_ids is None else env_ids
        fill_rows(self._both_actions, ids, 0.0, dim=1)
        for term in self._terms.values():
            term.reset(env_ids=ids)
        return {}

    def get_active_iterable_terms(self, env_idx: int) -> list[tuple[str, list[float]]]:
        row = self._action[env_idx].tolist()
        return [(name, row[columns]) for name, columns in zip(self._terms, self._slices, strict=True)]

    def serialize(self) -> dict[str, dict]:
        """The terms' configs as plain data."""
        return {name: term.serialize() for name, term in self._terms.items()}
