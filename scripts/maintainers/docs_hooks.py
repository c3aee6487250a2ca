"""Hooks of the documentation's build: the pages of the reference, and Sphinx's roles in docstrings shown as code."""

from __future__ import annotations

import re
import sys
from pathlib import Path
from typing import Any

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files

sys.path.insert(0, str(Path(__file__).parent))

import docs_reference

_ROLE = re.compile(r":(?:class|func|meth|attr|mod|data|exc|obj):<code>(~?)([\w.]+)</code>")


def on_config(config: MkDocsConfig) -> MkDocsConfig:
    """Write the reference's pages into the navigation, as the section "Reference"."""
    config.nav = [*(config.nav or []), {"Reference": docs_reference.nav()}]
    return config


def on_files(files: Files, *, config: MkDocsConfig) -> Files:
    """Add the reference's pages."""
    for file, text in docs_reference.files().items():
        files.append(File.generated(config, file, content=text))
    return files


def on_page_content(html: str, **_: Any) -> str:
    """Show ``:class:`~package.Name``` as ``Name``, and without the tilde in full."""
    return _ROLE.sub(_shown, html)


def _shown(found: re.Match[str]) -> str:
    name = found[2].rpartition(".")[2] if found[1] else found[2]
    return f"<code>{name}</code>"
