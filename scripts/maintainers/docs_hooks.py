"""Hooks of the documentation's build: docstrings name things with Sphinx's roles, pages show them as code."""

from __future__ import annotations

import re
from typing import Any

_ROLE = re.compile(r":(?:class|func|meth|attr|mod|data|exc|obj):<code>(~?)([\w.]+)</code>")


def on_page_content(html: str, **_: Any) -> str:
    """Show ``:class:`~package.Name``` as ``Name``, and without the tilde in full."""
    return _ROLE.sub(_shown, html)


def _shown(found: re.Match[str]) -> str:
    name = found[2].rpartition(".")[2] if found[1] else found[2]
    return f"<code>{name}</code>"
