"""Keys of the page. viser also lists them in its command palette (Ctrl+K)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from html import escape
from typing import Any


@dataclass
class Key:
    """A key and what it does."""

    key: str
    """viser's name of the key. W, A, S, D, Q, E and the arrows move the camera, so they are not free."""
    label: str
    """Short name, an imperative."""
    act: Callable[[], None]
    """Called on a thread of viser's."""


def add_keys(gui: Any, keys: list[Key]) -> None:
    """Make keys work in every page. They are ignored while a text or number field has the focus."""
    for key in keys:
        command = gui.add_command(key.label, hotkey=key.key)
        command.on_trigger(lambda _, act=key.act: act())


MOUSE = (
    ("Drag", "Turn the camera"),
    ("Right drag", "Move the camera"),
    ("Wheel", "Move closer or away"),
    ("W A S D Q E", "Move the camera"),
    ("Ctrl or Cmd + drag a body", "Pull it with a spring while the simulation runs"),
    ("Ctrl or Cmd + K", "Search all commands"),
)
"""Functions of the mouse and of viser's own keys."""


def key_table(keys: list[Key]) -> str:
    """The keys and the mouse as an HTML table."""
    rows = [(key.key.capitalize(), key.label) for key in keys] + list(MOUSE)
    cells = "".join(f"<tr><td><b>{escape(key)}</b></td><td>{escape(what)}</td></tr>" for key, what in rows)
    return f'<table style="font-size:11px;width:100%;padding:0 1em">{cells}</table>'
