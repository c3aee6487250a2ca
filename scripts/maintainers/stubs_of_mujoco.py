"""Type stubs of MuJoCo's compiled modules, from the signatures that its bindings carry."""

from __future__ import annotations

import ast
import importlib
import inspect
import keyword
import re
import types
from types import ModuleType

import mujoco

MODULES = ("_callbacks", "_constants", "_enums", "_errors", "_functions", "_render", "_specs", "_structs")
_HEADER = """# Made by scripts/maintainers/make_stubs.py from mujoco {version}. Do not edit.
import collections.abc
import typing
from typing import Any, ClassVar

import numpy
import numpy.typing
from numpy.typing import NDArray
{imports}
from ._types import *

"""
_TYPES = '''# Made by scripts/maintainers/make_stubs.py. Do not edit.
from collections.abc import Sequence
from typing import Any, Generic, SupportsFloat, SupportsIndex, SupportsInt, TypeAlias, TypeVar

from numpy.typing import ArrayLike, NDArray

Real: TypeAlias = SupportsFloat | SupportsIndex
Whole: TypeAlias = SupportsInt | SupportsIndex
Reals: TypeAlias = Sequence[Real] | NDArray[Any]
Wholes: TypeAlias = Sequence[Whole] | NDArray[Any]

G = TypeVar("G")
S = TypeVar("S")

class Fixed(Generic[G]):
    """An attribute that is only read."""
    def __get__(self, instance: Any, owner: Any = None) -> G: ...

class Field(Generic[G, S]):
    """An attribute that reads as one type and takes another."""
    def __get__(self, instance: Any, owner: Any = None) -> G: ...
    def __set__(self, instance: Any, value: S) -> None: ...

class Enum:
    """An enumeration of the bindings: an object that counts as its number."""
    @property
    def name(self) -> str: ...
    @property
    def value(self) -> int: ...
    def __init__(self, value: Whole) -> None: ...
    def __index__(self) -> int: ...
    def __int__(self) -> int: ...
    def __hash__(self) -> int: ...
    def __lt__(self, other: Any) -> bool: ...
    def __and__(self, other: Any) -> int: ...
    def __or__(self, other: Any) -> int: ...
    def __ror__(self, other: Any) -> int: ...
    def __invert__(self) -> int: ...
    def __lshift__(self, other: Any) -> int: ...
    def __add__(self, other: Any) -> int: ...
    def __sub__(self, other: Any) -> int: ...
'''
# what the signatures call an object
_RESULTS = {
    "MjSpec.compile": "mujoco._structs.MjModel",
    "MjSpec.copy": "MjSpec",
    "MjsMesh.name": "str",
}
_ARRAY = re.compile(r"^(numpy\.typing\.)?NDArray\[")


def stubs(used: set[str]) -> dict[str, str]:
    """Text of each stub file by its path below the folder of stubs.

    Args:
        used: names of ``mujoco`` that the code uses; those of its modules in Python are left out.
    """
    modules = {name: importlib.import_module(f"mujoco.{name}") for name in MODULES}
    due = [(name, key) for key in sorted(used) for name, module in modules.items() if key in vars(module)]
    due += [("_errors", key) for key in dir(modules["_errors"]) if not key.startswith("_")]
    lines: dict[tuple[str, str], str] = {}
    while due:
        name, key = due.pop()
        if (name, key) not in lines:
            lines[name, key] = text = _stub_of(key, vars(modules[name])[key])
            due += [
                (m, k) for m, k in re.findall(r"mujoco\.(_\w+)\.(\w+)", text) if m in modules and k in vars(modules[m])
            ]
    files = {"mujoco-stubs/_types.pyi": _TYPES, "mujoco-stubs/py.typed": "partial\n"}
    for name, module in modules.items():
        body = "".join(text for (owner, _), text in sorted(lines.items()) if owner == name)
        if body:
            files[f"mujoco-stubs/{name}.pyi"] = _file(name, module, body)
    return files


def _file(name: str, module: ModuleType, body: str) -> str:
    body = body.replace(f"mujoco.{name}.", "")
    others = sorted(set(re.findall(r"mujoco\.(_\w+)\.", body)))
    imports = "".join(f"import mujoco.{other}\n" for other in others)
    return _HEADER.format(version=mujoco.__version__, imports=imports) + body


def _stub_of(name: str, value: object) -> str:
    if isinstance(value, type):
        if hasattr(value, "__members__"):
            members = "".join(f"    {key}: ClassVar[{name}]\n" for key in value.__members__)
            return f"class {name}(Enum):\n{members}"
        return _class(name, value)
    if callable(value):
        return "".join(_functions(name, value.__doc__ or "", ""))
    return f"{name}: {type(value).__name__}\n" if type(value) in (int, float, str) else f"{name}: Any\n"


def _class(name: str, cls: type) -> str:
    bases = [base.__name__ for base in cls.__bases__ if base.__name__ not in ("object", "pybind11_object")]
    lines = []
    for key in dir(cls):
        value = inspect.getattr_static(cls, key)
        if (
            key not in vars(cls)
            or keyword.iskeyword(key)
            or (key.startswith("__") and not _is_operator(key))
            or key.startswith("_pybind11")
        ):
            continue
        if isinstance(value, property):
            lines.append(_property(name, key, value))
        elif isinstance(value, staticmethod):
            lines += [f"    @staticmethod\n{line}" for line in _functions(key, value.__func__.__doc__ or "", "    ")]
        elif isinstance(value, type):
            lines += [f"    {line}\n" for line in _class(key, value).splitlines()]
        elif isinstance(value, types.WrapperDescriptorType):
            continue
        elif callable(value):
            lines += _functions(key, value.__doc__ or "", "    ", name)
        else:
            lines.append(f"    {key}: ClassVar[{type(value).__name__}]\n")
    head = f"class {name}({', '.join(bases)}):" if bases else f"class {name}:"
    return f"{head}\n{''.join(lines) or '    ...'}\n"


def _is_operator(name: str) -> bool:
    return name in (
        "__init__",
        "__getitem__",
        "__setitem__",
        "__len__",
        "__iter__",
        "__call__",
        "__contains__",
        "__copy__",
        "__deepcopy__",
    )


def _property(owner: str, name: str, value: property) -> str:
    signature = re.match(r"\(.*?\) -> (.*)", (value.fget.__doc__ if value.fget else "") or "")
    result = _RESULTS.get(f"{owner}.{name}") or _type(signature[1] if signature else "Any")
    if result == "list":
        element = _element(name)
        result = f"list[mujoco._specs.{element}]" if element else "list[Any]"
    if value.fset is None:
        return f"    {name}: Fixed[{result}]\n"
    if _ARRAY.match(result):
        taken = "numpy.typing.ArrayLike"
    else:
        signature = re.match(r"\(.*?, arg1: (.*)\) -> None", value.fset.__doc__ or "")
        taken = _type(signature[1] if signature else "Any")
    if result in ("str", "bool", "Any") or result == taken:
        return f"    {name}: {result}\n"
    return f"    {name}: Field[{result}, {taken}]\n"


def _element(plural: str) -> str | None:
    """The element's class behind a list of a spec: ``bodies`` holds MjsBody."""
    irregular = {"bodies": "Body", "meshes": "Mesh", "equalities": "Equality", "flexes": "Flex", "hfields": "HField"}
    name = "Mjs" + irregular.get(plural, plural[:-1].capitalize())
    return name if hasattr(mujoco, name) else None


def _functions(name: str, doc: str, indent: str, owner: str = "") -> list[str]:
    """Stub lines of a function: one for each of its signatures."""
    signatures = re.findall(rf"^(?:\d+\. )?{re.escape(name)}(\(.*\)) -> (.*)$", doc, re.MULTILINE)
    signatures = [pair for pair in signatures if pair[0] != "(*args, **kwargs)"]
    lines = [line for pair in signatures if (line := _function(name, *pair, owner)) is not None]
    if not lines:
        arguments = "self, *args: Any, **kwargs: Any" if owner else "*args: Any, **kwargs: Any"
        lines = [f"def {name}({arguments}) -> Any: ..."]
    overload = f"{indent}@typing.overload\n" if len(lines) > 1 else ""
    return [f"{overload}{indent}{line}\n" for line in lines]


def _function(name: str, arguments: str, result: str, owner: str) -> str | None:
    arguments = re.sub(r"= <[^>]*>", "= ...", arguments)
    arguments = re.sub(r"mujoco::python::Mj(\w+)", r"mujoco._specs.Mj\1", arguments)
    try:
        node = ast.parse(f"def {name}{arguments} -> {result}: ...").body[0]
    except SyntaxError:
        return None
    assert isinstance(node, ast.FunctionDef)
    args = node.args.args
    if owner and args and args[0].arg == "self":
        args[0].annotation = None
    optional = [None] * (len(args) - len(node.args.defaults)) + list(node.args.defaults)
    for arg, default in zip(args, optional, strict=True):
        if arg.annotation is not None:
            text = _type(ast.unparse(arg.annotation))
            if isinstance(default, ast.Constant) and default.value is None and "None" not in text:
                text += " | None"
            arg.annotation = ast.parse(text, mode="eval").body
    node.args.defaults = [ast.Constant(...) for _ in node.args.defaults]
    returned = _RESULTS.get(f"{owner}.{name}") or ("None" if name == "__init__" else _type(result))
    if returned == "list":
        returned = "list[Any]"
    node.returns = ast.parse(returned, mode="eval").body
    return ast.unparse(node).replace(":\n    ...", ": ...")


class _Plain(ast.NodeTransformer):
    """An annotation without ``Annotated`` and without a module's path for arrays."""

    def visit_Subscript(self, node: ast.Subscript) -> ast.AST:
        if ast.unparse(node.value) == "typing.Annotated" and isinstance(node.slice, ast.Tuple):
            return self.visit(node.slice.elts[0])
        return self.generic_visit(node)


def _type(annotation: str) -> str:
    try:
        text = ast.unparse(_Plain().visit(ast.parse(annotation, mode="eval")))
    except SyntaxError:
        return "Any"
    text = text.replace("typing.SupportsFloat | typing.SupportsIndex", "Real")
    text = text.replace("typing.SupportsInt | typing.SupportsIndex", "Whole")
    text = text.replace("collections.abc.Sequence[Real]", "Reals").replace("collections.abc.Sequence[Whole]", "Wholes")
    text = text.replace("numpy.typing.NDArray", "NDArray").replace("collections.abc.Callable", "typing.Callable")
    return re.sub(r"\bobject\b", "Any", text).replace("Any | None", "Any")
