"""Settings of a run as text by path, to compare them with those of another run."""

from __future__ import annotations

import dataclasses
import json
import re
from collections.abc import Iterable, Mapping
from typing import Any

from lift_lab.utils import class_to_dict


@dataclasses.dataclass(frozen=True)
class Fingerprint:
    """Everything in configurations that a result depends on."""

    values: dict[str, str]
    """Path, such as ``env.scene.num_envs``, to the value as JSON."""
    at_default: frozenset[str]
    """Paths of the values that are the default of their field."""
    left_out: frozenset[str] = frozenset()
    """Paths of settings that do not matter, also where another run has saved them."""

    @classmethod
    def of(cls, configs: Mapping[str, Any], leave_out: Iterable[str] = ()) -> Fingerprint:
        """Collect the settings of configurations.

        Args:
            configs: name, the first part of a path, to configuration (dataclass or dictionary).
            leave_out: paths of settings, or of groups of them, that do not matter.
        """
        values: dict[str, str] = {}
        at_default: set[str] = set()
        left_out = frozenset(leave_out)
        for name, config in configs.items():
            _collect(name, config, False, values, at_default, left_out)
        return cls(values, frozenset(at_default), left_out)

    def with_value(self, path: str, value: Any) -> Fingerprint:
        """These settings and one more."""
        return Fingerprint({**self.values, path: _text(value)}, self.at_default, self.left_out)

    def difference(self, saved: Mapping[str, str]) -> str | None:
        """Say in which setting another run was different.

        A setting that the other run does not have may have its default value here.

        Args:
            saved: :attr:`values` of the other run.

        Returns:
            The first setting that differs, in words, and how many more do; None if none does.
        """
        different = [
            path
            for path in sorted((self.values.keys() | saved.keys()) - self.left_out)
            if self.values.get(path) != saved.get(path) and (path in saved or path not in self.at_default)
        ]
        if not different:
            return None
        first, more = different[0], len(different) - 1
        now, then = (_shown(values.get(first)) for values in (self.values, saved))
        return f"{first} is {now}, it was {then}" + (f", and {more} more differ" if more else "")


def _collect(
    path: str, value: Any, is_default: bool, values: dict[str, str], at_default: set[str], left_out: frozenset[str]
) -> None:
    if path in left_out:
        return
    entries = _entries(value)
    if not entries:
        values[path] = _text(value)
        if is_default:
            at_default.add(path)
        return
    defaults = _defaults(value)
    for name, entry in entries.items():
        known = is_default or (name in defaults and _text(defaults[name]()) == _text(entry))
        _collect(f"{path}.{name}", entry, known, values, at_default, left_out)


def _entries(value: Any) -> dict[str, Any]:
    """What a configuration, dictionary or list of these holds; empty for a value."""
    if isinstance(value, dict):
        return {str(key): entry for key, entry in value.items()}
    if isinstance(value, (list, tuple)):
        groups = any(isinstance(entry, dict) or _is_config(entry) for entry in value)
        return {str(k): entry for k, entry in enumerate(value)} if groups else {}
    return {name: entry for name, entry in vars(value).items() if name[:2] != "__"} if _is_config(value) else {}


def _is_config(value: Any) -> bool:
    return dataclasses.is_dataclass(value) and not isinstance(value, type)


def _defaults(value: Any) -> dict[str, Any]:
    """Field -> function that makes its default value, of those that have one."""
    found = {}
    for field in dataclasses.fields(value) if _is_config(value) else ():
        if field.default_factory is not dataclasses.MISSING:
            found[field.name] = field.default_factory
        elif field.default is not dataclasses.MISSING:
            found[field.name] = lambda field=field: field.default
    return found


def _text(value: Any) -> str:
    return json.dumps(class_to_dict(value), sort_keys=True, default=_plain)


def _plain(value: Any) -> Any:
    if hasattr(value, "tolist"):
        return value.tolist()
    return re.sub(r" at 0x[0-9a-fA-F]+", "", str(value))  # an address says nothing


def _shown(text: str | None) -> str:
    if text is None:
        return "not there"
    return text if len(text) <= 60 else f"{text[:57]}..."
