"""Write reStructuredText in docstrings as Markdown, and cached properties as such: a griffe extension of mkdocstrings.

Docstrings have ``.. code-block::``, paragraphs that end with ``::`` and ``:math:``. The reference's pages are Markdown.
"""

from __future__ import annotations

import re
from typing import Any

import griffe

_BLOCK = re.compile(r"^( *)\.\. code-block:: *(\w*)\n\n?((?:\1    .*\n|\n)+)", re.MULTILINE)


def to_markdown(text: str) -> str:
    """Return a docstring with its blocks of code and formulas written as Markdown."""
    text = _BLOCK.sub(_fenced, text + "\n").rstrip("\n")
    text = re.sub(r":math:(`[^`]+`)", r"\1", text)
    return re.sub(r"(?<=[^:\s])::$", ":", text, flags=re.MULTILINE)


def _fenced(block: re.Match[str]) -> str:
    """Return a block of code between fences, at the indent of its directive."""
    indent, language = block[1], block[2]
    lines = [line.removeprefix(f"{indent}    ") for line in block[3].rstrip("\n").split("\n")]
    return "\n".join([f"{indent}```{language}", *(f"{indent}{line}".rstrip() for line in lines), f"{indent}```", "\n"])


class Rst(griffe.Extension):
    """Changes the docstrings of everything that mkdocstrings loads."""

    def on_instance(self, *, obj: griffe.Object, **kwargs: Any) -> None:
        """Rewrite the docstring of an object."""
        if obj.docstring is not None:
            obj.docstring.value = to_markdown(obj.docstring.value)

    def on_class_members(self, *, cls: griffe.Class, **kwargs: Any) -> None:
        """Show what the decorator ``cached`` makes as properties: it is a sub-class of ``property``."""
        for name, member in list(cls.members.items()):
            if isinstance(member, griffe.Function) and any(str(made.value) == "cached" for made in member.decorators):
                attribute = griffe.Attribute(
                    name, lineno=member.lineno, endlineno=member.endlineno, annotation=member.returns, parent=cls
                )
                attribute.docstring = member.docstring
                attribute.labels = {"property"}
                cls.set_member(name, attribute)
