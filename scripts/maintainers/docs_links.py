"""Find links of Markdown pages to files and headings that do not exist."""

from __future__ import annotations

import re
import unicodedata
from functools import cache
from pathlib import Path

from docs_prose import blocks_of

_LINK = re.compile(r"!?\[(?:[^\[\]]|!?\[[^\]]*\]\([^)]*\))*\]\(\s*<?([^()\s>]+)>?(?:\s+\"[^\"]*\")?\s*\)")
_HTML = re.compile(r"<(?:a|img|video|source|link)\b[^>]*?\b(?:href|src|poster)=\"([^\"]+)\"")


def broken_links(page: Path, generated: frozenset[str] = frozenset()) -> list[tuple[int, str, str]]:
    """Return line, target and reason of each link of a page that leads nowhere.

    Args:
        page: A Markdown file.
        generated: Pages that the site's build makes, as paths below ``docs/``; their anchors are not looked at.
    """
    found = []
    for block in blocks_of(page.read_text()):
        if block.kind == "code":
            continue
        text = re.sub(r"(`+).*?\1", lambda code: re.sub(r"[^\n]", "x", code[0]), block.text, flags=re.DOTALL)
        for match in [*_LINK.finditer(text), *_HTML.finditer(text)]:
            reason = _broken(page, match[1], generated)
            if reason:
                found.append((block.line + text[: match.start()].count("\n"), match[1], reason))
    return found


def _broken(page: Path, target: str, generated: frozenset[str]) -> str:
    """Return why a link leads nowhere; an empty text if it is right or leaves the repository."""
    if re.match(r"[a-z][a-z+.-]*:", target):
        return ""
    file, _, anchor = target.partition("#")
    if target.startswith("/"):
        return "give a path relative to the page"
    other = (page.parent / file).resolve() if file else page
    docs = next((parent for parent in page.resolve().parents if parent.name == "docs"), None)
    if docs and other.is_relative_to(docs) and str(other.relative_to(docs)) in generated:
        return ""
    if not other.exists():
        return "no such file"
    if anchor and other.suffix == ".md" and anchor not in anchors(other):
        return f"no such heading; the page has {', '.join(sorted(anchors(other))) or 'none'}"
    return ""


@cache
def anchors(page: Path) -> frozenset[str]:
    """Return the anchors of a page: slugs of its headings, ids that are given, names documented by ``:::``."""
    text = page.read_text()
    names: list[str] = []
    for block in blocks_of(text):
        if block.kind == "heading":
            given = re.search(r"\{[^}]*#([\w-]+)[^}]*\}", block.text)
            slug = given[1] if given else slugify(block.text)
            names.append(slug if slug not in names else f"{slug}_{sum(name.startswith(slug) for name in names)}")
    ids = re.findall(r"(?:<a\s+(?:id|name)=\"|\*\*\{ ?:? ?#)([\w.-]+)", text) + re.findall(
        r"^::: ([\w.]+)", text, flags=re.MULTILINE
    )
    return frozenset([*names, *ids])


def slugify(heading: str) -> str:
    """Return the anchor of a heading, as mkdocs makes it."""
    plain = re.sub(r"!?\[([^\]]*)\]\([^)]*\)", r"\1", heading).replace("`", "")
    plain = unicodedata.normalize("NFKD", plain).encode("ascii", "ignore").decode()
    return re.sub(r"[-\s]+", "-", re.sub(r"[^\w\s-]", "", plain).strip().lower())
