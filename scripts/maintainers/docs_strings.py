"""Find the public docstrings of the packages and their sentences, by the same rule as those of pages.

Public is what has no leading underscore in its own name, in its module's or in its class's. Entries of sections
(``Args:``, ``Raises:``, ...) are list items; indented blocks of code count as code.
"""

from __future__ import annotations

import ast
import inspect
import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from docs_prose import Sentence, house_words, sentences_of

BACKWARDS = re.compile(r"(What|Of|Which|How|Who|Whose|Where|When|Why)\b")
"""Beginnings of a first line that is neither an imperative nor a noun phrase."""
_SECTION = re.compile(r"^(Args|Arguments|Params|Parameters|Attributes|Returns|Raises|Yields|Note|Example|Examples):$")


@dataclass
class Docstring:
    """A docstring, the name it belongs to, and the module, file and line where it starts."""

    module: str
    file: Path
    line: int
    name: str
    text: str

    @property
    def sentences(self) -> list[Sentence]:
        """Its sentences; their lines are those of the file."""
        found = sentences_of(_as_markdown(self.text))
        return [Sentence(s.kind, s.line + self.line - 1, s.text, s.words) for s in found]

    @property
    def wrong(self) -> list[tuple[int, str]]:
        """Line and reason of a first line that is written backwards, and of house words."""
        found = [
            (self.line + line - 1, f'house word "{w}": {b}') for line, w, b in house_words(_as_markdown(self.text))
        ]
        if begin := BACKWARDS.match(self.text):
            found.insert(
                0, (self.line, f'the first line begins with "{begin[1]}": name the thing, or say "Return ..."')
            )
        return found


def docstrings(source: Path) -> list[Docstring]:
    """Return the public docstrings of all packages in a folder, by file and line."""
    found = []
    for file in sorted(source.rglob("*.py")):
        module = ".".join(file.relative_to(source).with_suffix("").parts).removesuffix(".__init__")
        if not any(part.startswith("_") for part in module.split(".")):
            found += [
                Docstring(module, file, line, name, text)
                for line, name, text in _of(ast.parse(file.read_text()), module)
            ]
    return found


def _of(
    node: ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef, name: str
) -> Iterator[tuple[int, str, str]]:
    """Yield line, name and docstring of a module, class or function and of what it holds."""
    if text := _text(node.body[0] if node.body else None):
        yield *text[:1], name, text[1]
    if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
        return
    for before, statement in zip([None, *node.body], node.body, strict=False):
        if isinstance(statement, ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef):
            if not statement.name.startswith("_"):
                yield from _of(statement, f"{name}.{statement.name}")
        elif isinstance(before, ast.Assign | ast.AnnAssign) and (text := _text(statement)):
            target = before.target if isinstance(before, ast.AnnAssign) else before.targets[0]
            if not ast.unparse(target).rpartition(".")[2].startswith("_"):
                yield text[0], f"{name}.{ast.unparse(target)}", text[1]


def _text(statement: ast.stmt | None) -> tuple[int, str] | None:
    """Return line and text of a statement that is a docstring."""
    value = statement.value if isinstance(statement, ast.Expr) else None
    if isinstance(value, ast.Constant) and isinstance(value.value, str):
        return value.lineno, inspect.cleandoc(value.value)
    return None


def _as_markdown(text: str) -> str:
    """Write a docstring of Google's style and Sphinx's roles as Markdown, line by line."""
    lines, section = [], False
    for line in text.split("\n"):
        if _SECTION.match(line):
            section = True
            line = ""
        elif line and not line.startswith(" "):
            section = False
        if section and re.match(r"^    \S", line):
            line = "- " + line.strip()
        elif section:
            line = line[4:]
        lines.append(re.sub(r"^\.\. \w.*::.*$|^>>> .*$|^-+$|^=+$", "", line))
    text = re.sub(r":(?:\w+):`~?([^`]*)`", r"`\1`", "\n".join(lines))
    return re.sub(r"::$", ":", text, flags=re.MULTILINE)
