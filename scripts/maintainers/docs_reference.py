"""Write the reference's pages from the table in ``docs_pages.py``. Names come from the modules, none is listed by hand.

A module's public names are its ``__all__``. Without one they are the classes, functions and documented constants that
it defines, apart from those with a leading underscore. A name that several modules export is documented once, where it
comes first below. The source is read, not run.
"""

from __future__ import annotations

import functools
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import griffe
from docs_pages import PAGES, Page
from docs_rst import to_markdown

SOURCE = Path(__file__).resolve().parents[2] / "source"
PACKAGES = ("lift_lab", "lift_lab_assets", "lift_lab_rl", "lift_lab_tasks", "lift_lab_cli")


@dataclass
class Section:
    """A module's part of a page: public name -> the object that is documented."""

    title: str
    module: str
    names: dict[str, griffe.Object] = field(default_factory=dict)


@functools.cache
def _modules() -> griffe.ModulesCollection:
    """Read the packages."""
    loader = griffe.GriffeLoader(search_paths=[SOURCE], docstring_parser="google")
    for package in PACKAGES:
        loader.load(package)
    loader.resolve_aliases(implicit=False, external=False)
    return loader.modules_collection


def public(module: str) -> dict[str, griffe.Object]:
    """Return the public names of a module, each with the object behind it."""
    owner = _modules()[module]
    exports = None if owner.exports is None else [str(name) for name in owner.exports]
    found = {}
    for name, member in owner.members.items():
        if name.startswith("_") or (exports is not None and name not in exports):
            continue
        try:
            target = member.final_target if isinstance(member, griffe.Alias) else member
        except griffe.AliasResolutionError:  # of another package
            continue
        if isinstance(target, griffe.Module) or target.path.startswith("lift_lab.isaac."):
            continue
        if exports is None:
            own = target.parent is owner
            if not (_documented(target) if own else owner.is_init_module):
                continue
        found[name] = target
    return dict(sorted(found.items()))


def _documented(target: griffe.Object) -> bool:
    """Whether something that a module defines is for its users: all but constants without a docstring."""
    return not isinstance(target, griffe.Attribute) or target.docstring is not None


def _below(package: str) -> list[str]:
    """Return a package's public modules, at any depth, in order."""
    owner, found = _modules()[package], []
    for name, member in sorted(owner.modules.items()):
        if not name.startswith("_") and not isinstance(member, griffe.Alias):
            found += [member.path, *_below(member.path)]
    return found


def _depth(module: str) -> tuple[int, str]:
    """Order a task's modules: the environment's configuration, then robots, then agents."""
    return module.count("."), module


@functools.cache
def sections() -> dict[str, list[Section]]:
    """Return the sections of every page, by its file. Each object is in one section only."""
    seen: set[str] = set()
    pages: dict[str, list[Section]] = {}
    for page in (page for group in PAGES.values() for page in group):
        pages[page.file] = []
        for title, module in page.sections.items():
            whole = module.endswith(".*")
            for each in [module[:-2], *sorted(_below(module[:-2]), key=_depth)] if whole else [module]:
                heading = each.removeprefix(module[:-2]).strip(".") or each.rpartition(".")[2] if whole else title
                section = Section(heading, each)
                for name, target in public(each).items():
                    if target.path not in seen:
                        seen.add(target.path)
                        section.names[name] = target
                if section.names:
                    pages[page.file].append(section)
    return pages


def _first_sentence(target: griffe.Object) -> str:
    """Return the first line of a docstring, for a table."""
    text = to_markdown(target.docstring.value).strip().split("\n\n")[0] if target.docstring else ""
    return " ".join(text.split()).replace("|", "\\|")


def _is_config(target: griffe.Object) -> bool:
    """Whether a class is a configuration: its fields are shown with those that it inherits."""
    return isinstance(target, griffe.Class) and any(str(d.value) == "configclass" for d in target.decorators)


_INHERITS = ("lift_lab.assets.", "lift_lab.sensors.", "lift_lab.envs.manager_based")
"""Modules whose classes, besides configurations, are shown with the members that they inherit."""


def _shows_inherited(target: griffe.Class) -> bool:
    """Whether an entry has inherited members: not in tasks, whose configurations would repeat the environment's."""
    return target.path.startswith(_INHERITS) or (_is_config(target) and not target.path.startswith("lift_lab_tasks"))


def _entry(target: griffe.Object) -> str:
    """Return the Markdown of an object's entry."""
    options = ["heading_level: 3"]
    if isinstance(target, griffe.Class) and _shows_inherited(target):
        options.append("inherited_members: true")
    if _is_config(target):
        options.append("show_if_no_docstring: true")
    return "\n".join([f"::: {target.path}", "    options:", *(f"      {option}" for option in options), ""])


def markdown(page: Page) -> str:
    """Return the Markdown of a page of the reference."""
    parts = [f"# {page.title}\n\n{page.text}\n"]
    for section in sections()[page.file]:
        module = _modules()[section.module]
        parts.append(f"## {section.title}\n\nModule `{section.module}`.")
        if module.docstring:
            parts.append(to_markdown(module.docstring.value))
        parts.append("| name | purpose |\n|---|---|")
        parts[-1] += "".join(f"\n| [`{n}`][{t.path}] | {_first_sentence(t)} |" for n, t in section.names.items())
        parts += [_entry(target) for target in section.names.values()]
    return "\n\n".join(parts)


def overview() -> str:
    """Return the Markdown of the first page of the reference: every page with its names."""
    parts = ["# Reference\n\nEvery public class and function, by the page that documents it.\n"]
    for group, pages in PAGES.items():
        parts.append(f"## {group}\n\n| page | names |\n|---|---|")
        for page in pages:
            links = [f"[`{n}`][{t.path}]" for section in sections()[page.file] for n, t in section.names.items()]
            parts[-1] += f"\n| [{page.title}]({page.file.removeprefix('api/')}) | {', '.join(links)} |"
    return "\n\n".join(parts)


def files() -> dict[str, str]:
    """Return the Markdown of every page of the reference, by its file below ``docs/``."""
    texts = {"api/index.md": overview()} | {page.file: markdown(page) for group in PAGES.values() for page in group}
    return {file: f"---\nsearch: {{boost: 0.5}}\n---\n\n{text}" for file, text in texts.items()}  # guides come first


def nav() -> list[Any]:
    """Return the reference's part of the navigation."""
    groups = [{group: [{page.title: page.file} for page in pages]} for group, pages in PAGES.items()]
    return [{"Overview": "api/index.md"}, *groups]
