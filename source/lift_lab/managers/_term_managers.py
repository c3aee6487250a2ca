"""Two kinds of manager: terms that are functions in one flat list, and terms that are objects of their own."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, ClassVar

from lift_lab.utils.debug_vis import DebugVis
from lift_lab.utils.errors import ConfigError, ConfigTypeError, NotFoundError, suggest

from .manager_base import EnvIds, ManagerBase, ManagerTermBase


class FunctionTermManager(ManagerBase):
    """A manager whose terms are one flat list of functions, in declaration order."""

    term_cfg_type: ClassVar[type]
    """Type of the terms' configs."""

    min_argc: ClassVar[int] = 1
    """Positional arguments that a term is called with."""

    unsaved_attributes: ClassVar[frozenset[str]] = frozenset(
        {"_term_names", "_term_cfgs", "_class_term_cfgs", "_log_names"}
    )

    def _prepare_terms(self) -> None:
        self._term_names: list[str] = []
        self._term_cfgs: list[Any] = []
        for name, term_cfg in self._term_items(self.term_cfg_type, self.cfg):
            self._accept_term(name, term_cfg)
            self._term_names.append(name)
            self._term_cfgs.append(term_cfg)
        self._list_class_terms()

    def _accept_term(self, term_name: str, term_cfg: Any) -> None:
        """Check and resolve one config; sub-classes add the checks of their own fields."""
        self._resolve_common_term_cfg(term_name, term_cfg, self.min_argc)

    def term_objects(self) -> dict[str, Any]:
        cfgs = zip(self._term_names, self._term_cfgs, strict=True)
        return {name: cfg.func for name, cfg in cfgs if isinstance(cfg.func, ManagerTermBase)}

    def _list_class_terms(self) -> None:
        self._class_term_cfgs = [cfg for cfg in self._term_cfgs if isinstance(cfg.func, ManagerTermBase)]

    @property
    def active_terms(self) -> list[str]:
        """Names of the terms."""
        return self._term_names

    def get_term_cfg(self, term_name: str) -> Any:
        """The live config of a term: edits take effect at the next call.

        Raises:
            ConfigError: no term has this name.
        """
        return self._term_cfgs[self._index(term_name)]

    def set_term_cfg(self, term_name: str, cfg: Any) -> None:
        """Replace a term's config, resolving it if it is a new one.

        Raises:
            ConfigError: no term has this name, or the config cannot be resolved.
            TypeError: the config is of another manager.
        """
        index = self._index(term_name)
        self._check_type(term_name, cfg, self.term_cfg_type)
        if cfg is not self._term_cfgs[index]:
            self._accept_term(term_name, cfg)
            self._term_cfgs[index] = cfg
            self._put_term_cfg(term_name, cfg)
            self._list_class_terms()

    def _index(self, term_name: str) -> int:
        if term_name not in self._term_names:
            raise ConfigError(f"{self._owner(term_name)} not found: {suggest(term_name, self._term_names)}")
        return self._term_names.index(term_name)

    def _reset_class_terms(self, env_ids: EnvIds) -> None:
        for term_cfg in self._class_term_cfgs:
            term_cfg.func.reset(env_ids=env_ids)


class ObjectTermManager(ManagerBase):
    """A manager whose terms are objects, built as ``cfg.class_type(cfg, env)``."""

    term_cfg_type: ClassVar[type]
    """Type of the terms' configs."""

    term_type: ClassVar[type]
    """Type of the terms."""

    settings: ClassVar[Sequence[str]] = ()
    """Fields of the config that are no terms."""

    unsaved_attributes: ClassVar[frozenset[str]] = frozenset({"_terms"})

    def term_objects(self) -> dict[str, Any]:
        return dict(self._terms)

    def _prepare_terms(self) -> None:
        self._terms: dict[str, Any] = {}
        for name, term_cfg in self._term_items(self.term_cfg_type, self.cfg, self.settings):
            term = term_cfg.class_type(term_cfg, self._env)
            if not isinstance(term, self.term_type):
                raise ConfigTypeError(
                    f"{self._owner(name)}: class_type must be a sub-class of {self.term_type.__name__},"
                    f" not '{type(term).__name__}'"
                )
            self._terms[name] = term

    @property
    def active_terms(self) -> list[str]:
        """Names of the terms."""
        return list(self._terms)

    def get_term(self, name: str) -> Any:
        """The term of this name.

        Raises:
            NotFoundError: no term has this name.
        """
        if name not in self._terms:
            raise NotFoundError(f"{self._owner(name)} not found: {suggest(name, self._terms)}")
        return self._terms[name]

    @property
    def has_debug_vis_implementation(self) -> bool:
        """Whether any term draws markers."""
        return any(term.has_debug_vis_implementation for term in self._debug_vis_terms())

    def set_debug_vis(self, debug_vis: bool) -> None:
        """Show or hide the markers of every term that has some."""
        for term in self._debug_vis_terms():
            term.set_debug_vis(debug_vis)

    def update_debug_vis(self) -> None:
        """Move the markers of every term; a viewer calls this once for each frame."""
        for term in self._debug_vis_terms():
            term.update_debug_vis()

    def _debug_vis_terms(self) -> list[DebugVisTerm]:
        return [term for term in self._terms.values() if isinstance(term, DebugVisTerm)]


class DebugVisTerm(DebugVis, ManagerTermBase):
    """A term that can draw markers of its state into a viewer."""
