"""Rename Isaac Lab's packages in the text of a Python file: imports, names and strings, and nothing else.

The file is parsed, not run. Every edit replaces the bytes of one dotted name; comments and layout stay as they are.
"""

from __future__ import annotations

import ast
import dataclasses
import io
import re
import tokenize

RENAMES = {
    "isaaclab": "lift_lab",
    "isaaclab_assets": "lift_lab_assets",
    "isaaclab_rl": "lift_lab_rl",
    "isaaclab_tasks": "lift_lab_tasks",
    # before Isaac Lab 2.0
    "omni.isaac.lab": "lift_lab",
    "omni.isaac.lab_assets": "lift_lab_assets",
    "omni.isaac.lab_assets.cartpole": "lift_lab_assets.robots.cartpole",
    "omni.isaac.lab_assets.franka": "lift_lab_assets.robots.franka",
    "omni.isaac.lab_tasks": "lift_lab_tasks",
    "omni.isaac.lab_tasks.utils.wrappers.rsl_rl": "lift_lab_rl.rsl_rl",
    "omni.isaac.lab_tasks.utils.wrappers.sb3": "lift_lab_rl.sb3",
    "omni.isaac.lab_tasks.utils.wrappers.skrl": "lift_lab_rl.skrl",
}
"""Packages and modules of Isaac Lab 1 and 2, and their names here."""

PACKAGES = ("lift_lab", "lift_lab_assets", "lift_lab_rl", "lift_lab_tasks")
"""Packages that names are renamed to."""

_ROOT = r"(?:omni\.isaac\.lab(?:_assets|_tasks)?|isaaclab(?:_assets|_rl|_tasks)?)"
_IN_STRING = re.compile(
    rf"(?<![\w./\\@-]){_ROOT}(?=[.:][A-Za-z_{{])(?:\.\w+)*"  # a dotted name, possibly with :Name behind it
    rf"|(?<=['\"]){_ROOT}(?=['\"])"  # the whole string
)
_SPACE = rb"(?:\s|\\)+"


@dataclasses.dataclass(frozen=True)
class Use:
    """A name that a file takes from another module."""

    line: int
    module: str
    """Module after the renaming; a relative one begins with dots."""
    name: str
    """Name in it; ``*`` for all, empty for the module itself."""
    is_import: bool = True
    """Whether it is an import; False for a name that is taken from an imported module."""


@dataclasses.dataclass
class Source:
    """A Python file, parsed and renamed."""

    data: bytes
    """Content after the renaming."""
    renamed: int = 0
    """Names that were replaced."""
    problem: str | None = None
    """Reason why the file could not be parsed; then nothing is replaced: ``line 3: invalid syntax``."""
    uses: list[Use] = dataclasses.field(default_factory=list)
    """Names that are imported, and names that are taken from imported modules (``sim_utils.UsdFileCfg``)."""
    definitions: set[str] = dataclasses.field(default_factory=set)
    """Names that the module defines or imports by name."""


def new_name(dotted: str) -> str | None:
    """The name here of a dotted name of Isaac Lab; None if it does not change."""
    parts = dotted.split(".")
    for count in range(len(parts), 0, -1):
        if (new := RENAMES.get(".".join(parts[:count]))) is not None:
            return ".".join([new, *parts[count:]])
    return None


def port(data: bytes) -> Source:
    """Rename what a file takes from Isaac Lab.

    Args:
        data: content of a Python file, in any encoding that Python reads.
    """
    try:
        encoding, _ = tokenize.detect_encoding(io.BytesIO(data).readline)
        text = data.decode(encoding)
        tree = ast.parse(text)
    except (SyntaxError, UnicodeDecodeError, ValueError) as error:
        line = getattr(error, "lineno", None)
        message = getattr(error, "msg", None) or str(error)
        return Source(data, problem=message if line is None else f"line {line}: {message}")
    except (RecursionError, MemoryError):
        return Source(data, problem="its expressions are nested too deeply")
    file = _File(text, tree)
    changed = file.apply().decode("utf-8")
    return Source(changed.encode(encoding), len(file.edits), None, file.uses, file.definitions)


class _File:
    """Finds the edits of one file. Places are offsets into the text in UTF-8, as those of a syntax tree are."""

    def __init__(self, text: str, tree: ast.Module):
        self.data = text.encode("utf-8")
        self.edits: dict[int, tuple[int, bytes]] = {}
        """Start -> end and new text."""
        self.uses: list[Use] = []
        self.definitions: set[str] = set()
        self._starts = [0, *(match.end() for match in re.finditer(rb"\r\n|\r|\n", self.data))]
        self._modules: dict[str, str] = {}  # name in this file -> module after the renaming
        self._is_bound = False  # whether a plain ``import isaaclab.x`` binds the root's own name
        for node in ast.walk(tree):
            if isinstance(node, ast.Import):
                self._import(node)
            elif isinstance(node, ast.ImportFrom):
                self._import_from(node)
        self._definitions(tree)
        self._visit(tree)

    def apply(self) -> bytes:
        """The text with all edits."""
        parts, place = [], 0
        for start, (end, new) in sorted(self.edits.items()):
            parts += [self.data[place:start], new]
            place = end
        return b"".join([*parts, self.data[place:]])

    def _at(self, line: int, column: int) -> int:
        return self._starts[line - 1] + column

    def _replace(self, start: int, dotted: str) -> None:
        """Replace a dotted name that begins at a place, if it is one of Isaac Lab's and written without spaces."""
        new, old = new_name(dotted), dotted.encode("utf-8")
        if new is not None and self.data.startswith(old, start):
            self.edits[start] = (start + len(old), new.encode("utf-8"))

    def _import(self, node: ast.Import) -> None:
        for alias in node.names:
            module = new_name(alias.name) or alias.name
            self.uses.append(Use(alias.lineno, module, ""))
            self._replace(self._at(alias.lineno, alias.col_offset), alias.name)
            if alias.asname is not None:
                self._modules[alias.asname] = module
            elif new_name(alias.name) is not None:
                self._is_bound = True

    def _import_from(self, node: ast.ImportFrom) -> None:
        old = node.module or ""
        module = "." * node.level + (new_name(old) or old if not node.level else old)
        if not node.level:
            start = self._at(node.lineno, node.col_offset)
            if match := re.compile(rb"from" + _SPACE).match(self.data, start):
                self._replace(match.end(), old)
        for alias in node.names:
            self.uses.append(Use(alias.lineno, module, alias.name))
            below = f"{module}{alias.name}" if module.endswith(".") else f"{module}.{alias.name}"
            self._modules[alias.asname or alias.name] = below

    def _definitions(self, node: ast.AST) -> None:
        for child in ast.iter_child_nodes(node):
            if isinstance(child, ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef):
                self.definitions.add(child.name)  # what is defined in it is not the module's
                continue
            if isinstance(child, ast.Name) and isinstance(child.ctx, ast.Store):
                self.definitions.add(child.id)
            elif isinstance(child, ast.alias):
                self.definitions.add(child.asname or child.name.partition(".")[0])
            self._definitions(child)

    def _visit(self, node: ast.AST) -> None:
        if isinstance(node, ast.Constant | ast.JoinedStr):
            if isinstance(node, ast.JoinedStr) or isinstance(node.value, str):
                self._string(node)
            return
        if isinstance(node, ast.Attribute) and self._attribute(node):
            return
        for child in ast.iter_child_nodes(node):
            self._visit(child)

    def _string(self, node: ast.expr) -> None:
        start = self._at(node.lineno, node.col_offset)
        end = self._at(node.end_lineno or node.lineno, node.end_col_offset or 0)
        segment = self.data[start:end].decode("utf-8")
        for match in _IN_STRING.finditer(segment):
            self._replace(start + len(segment[: match.start()].encode("utf-8")), match[0])

    def _attribute(self, node: ast.Attribute) -> bool:
        """Note what an attribute takes from a module; False if it is no chain of names."""
        names: list[str] = []
        inner: ast.expr = node
        while isinstance(inner, ast.Attribute):
            names.append(inner.attr)
            inner = inner.value
        if not isinstance(inner, ast.Name):
            return False
        names.append(inner.id)
        names.reverse()
        if (module := self._modules.get(names[0])) is not None:
            self.uses.append(Use(node.lineno, module, ".".join(names[1:]), False))
        elif self._is_bound and (new := new_name(".".join(names))) is not None:
            self._replace(self._at(inner.lineno, inner.col_offset), _root_of(names))
            package, _, rest = new.partition(".")
            self.uses.append(Use(node.lineno, package, rest, False))
        return True


def _root_of(names: list[str]) -> str:
    """The part of a chain of names that the renaming replaces."""
    whole = ".".join(names)
    return max((old for old in RENAMES if whole == old or whole.startswith(f"{old}.")), key=len)
