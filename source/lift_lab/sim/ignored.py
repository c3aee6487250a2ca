"""Settings that are accepted for Isaac Lab's sake and have no meaning in MuJoCo.

Code that finds such a setting calls :func:`note_ignored`. The environment shows the collected list once, as one table,
through :func:`report_ignored`. Nothing is dropped in silence.
"""

from __future__ import annotations

import logging
from dataclasses import MISSING

from rich.console import Console
from rich.table import Table

__all__ = ["note_ignored"]

logger = logging.getLogger(__name__)

_pending: dict[str, str] = {}
_reported: dict[str, str] = {}


def note_ignored(path: str, reason: str) -> None:
    """Remember that the setting at ``path`` has no effect, and why.

    Args:
        path: where the user wrote it, e.g. ``"scene.robot.spawn.rigid_props.sleep_threshold"``.
        reason: why it has no effect here, as a short phrase.
    """
    if path not in _reported:
        _pending[path] = reason


def note_ignored_fields(path: str, cfg: object, reasons: dict[str, str]) -> None:
    """Note every field of ``cfg`` that is named in ``reasons`` and was set (not None)."""
    for name, reason in reasons.items():
        if getattr(cfg, name, None) not in (None, MISSING):
            note_ignored(f"{path}.{name}", reason)


def note_changed_fields(path: str, cfg: object, reasons: dict[str, str]) -> None:
    """Note every field of ``cfg`` that is named in ``reasons`` and differs from its default."""
    default = type(cfg)()
    for name, reason in reasons.items():
        if getattr(cfg, name) != getattr(default, name, None):
            note_ignored(f"{path}.{name}", reason)


def pending_ignored() -> dict[str, str]:
    """Settings noted since the last report: path -> reason."""
    return dict(_pending)


def ignored_settings() -> dict[str, str]:
    """All settings noted in this process, reported or not: path -> reason."""
    return {**_reported, **_pending}


def report_ignored() -> str | None:
    """Log the settings noted since the last report as one table, each only once in a process.

    Returns:
        The table as text, or None when there was nothing new.
    """
    if not _pending:
        return None
    table = Table("setting", "why it has no effect", title="Ignored settings", title_justify="left")
    for path, reason in sorted(_pending.items()):
        table.add_row(path, reason)
    _reported.update(_pending)
    _pending.clear()
    console = Console(width=120, record=False)
    with console.capture() as capture:
        console.print(table)
    text = capture.get()
    logger.info("\n%s", text)
    return text
