"""Strings: matching names by regular expression, naming callables, changing case."""

from __future__ import annotations

import ast
import importlib
import inspect
import re
import sys
import types
from collections.abc import Callable, Sequence
from typing import Any

from .errors import ConfigError, quote, suggest

##
# Case and slices
##


def to_camel_case(snake_str: str, to: str = "cC") -> str:
    """Turn ``snake_case`` into ``camelCase`` (``to="cC"``) or ``CamelCase`` (``to="CC"``).

    Raises:
        ValueError: ``to`` is neither "cC" nor "CC".
    """
    if to not in ("cC", "CC"):
        raise ValueError(f"to_camel_case: 'to' is 'cC' or 'CC', not {to!r}")
    words = [word.title() for word in snake_str.lower().split("_")]
    if to == "cC":
        words[0] = words[0].lower()
    return "".join(words)


def to_snake_case(camel_str: str) -> str:
    """Turn ``CamelCase`` or ``camelCase`` into ``snake_case``; ``RLEnv`` becomes ``rl_env``."""
    return re.sub(r"(?<=[a-z0-9])(?=[A-Z])|(?<=[^_])(?=[A-Z][a-z])", "_", camel_str).lower()


def string_to_slice(s: str) -> slice:
    """Read a slice written as ``"slice(start,stop,step)"``, each an integer or ``None``.

    Raises:
        ValueError: the string is not of that form.
    """
    match = re.fullmatch(r"slice\(([^,]*),([^,]*),([^,]*)\)", s.strip())
    if match is None:
        raise ValueError(f"not a slice: {s!r} (expected 'slice(start,stop,step)')")
    try:
        parts = [None if part.strip() == "None" else int(part) for part in match.groups()]
    except ValueError:
        raise ValueError(f"not a slice: {s!r} (start, stop and step are integers or None)") from None
    return slice(*parts)


##
# Callables
##


def is_lambda_expression(name: str) -> bool:
    """Whether the string is a lambda expression and nothing else."""
    try:
        return isinstance(ast.parse(name.strip(), mode="eval").body, ast.Lambda)
    except (SyntaxError, ValueError):
        return False


def callable_to_string(value: Callable) -> str:
    """Name a callable as ``"module:name"``; a lambda becomes its source text.

    Args:
        value: a function, method, class or lambda.

    Raises:
        ValueError: ``value`` is not callable, has no name, or is a lambda without source.
    """
    if not callable(value):
        raise ValueError(f"not callable: {value!r}")
    name = getattr(value, "__name__", None)
    if name == "<lambda>":
        return _lambda_source(value)
    module = getattr(value, "__module__", None)
    if name is None or module is None:
        raise ValueError(f"callable without a module and a name: {value!r}")
    qualname = getattr(value, "__qualname__", name)
    return f"{module}:{qualname if _find(sys.modules.get(module), qualname) is value else name}"


def string_to_callable(name: str) -> Callable:
    """Find the callable that ``"module:name"`` names, or build the lambda that the string spells.

    Args:
        name: ``"module:function"``, ``"module:Class.method"`` or ``"lambda x: ..."``.

    Raises:
        ValueError: malformed, or the module, the attribute or its callability is missing.
    """
    if not isinstance(name, str):
        raise ConfigError(f"expected a string 'module:name', got {type(name).__name__} {name!r}")
    if is_lambda_expression(name):
        return eval(name.strip())
    module_name, colon, path = name.partition(":")
    if not colon or not module_name or not path:
        raise ConfigError(f"cannot resolve {name!r}: expected 'module:name' or a lambda expression")
    try:
        module = importlib.import_module(module_name)
    except ImportError as error:
        raise ConfigError(f"cannot resolve {name!r}: {error}") from error
    found = _find(module, path)
    if found is None:
        public = [attribute for attribute in dir(module) if not attribute.startswith("_")]
        raise ConfigError(f"cannot resolve {name!r}: '{module_name}' has no '{path}'; {suggest(path, public)}")
    if not callable(found):
        raise ConfigError(f"{name!r} is not callable but a {type(found).__name__}")
    return found


def _find(module: types.ModuleType | None, path: str) -> Any | None:
    """What a dotted path leads to inside a module; None if it leads nowhere."""
    found: Any = module
    for part in path.split("."):
        found = getattr(found, part, None)
    return found


def is_function_like(value: Any) -> bool:
    """Whether ``value`` is code rather than data: a function, method, builtin or class."""
    return isinstance(value, (type, types.FunctionType, types.BuiltinFunctionType, types.MethodType)) or (
        callable(value) and hasattr(value, "__qualname__") and hasattr(value, "__name__")
    )


def _lambda_source(function: Any) -> str:
    """Source text of a lambda; several on one line are told apart by their compiled code."""
    code = function.__code__
    try:
        lines, _ = inspect.findsource(function)
        tree = ast.parse("".join(lines))
    except (OSError, SyntaxError) as error:
        raise ValueError(f"no source for the lambda at {code.co_filename}:{code.co_firstlineno}") from error
    source = "".join(lines)
    candidates = [
        ast.get_source_segment(source, node) or ast.unparse(node)
        for node in ast.walk(tree)
        if isinstance(node, ast.Lambda) and node.lineno == code.co_firstlineno
    ]
    for text in candidates:
        outer = compile(f"({text})", "<lambda>", "eval")
        compiled = next(const for const in outer.co_consts if isinstance(const, types.CodeType))
        if _identity(compiled) == _identity(code):
            return text
    if not candidates:
        raise ValueError(f"no source for the lambda at {code.co_filename}:{code.co_firstlineno}")
    return candidates[0]


def _identity(code: types.CodeType) -> tuple:
    """What a piece of code does, without where it stands."""
    constants = tuple(const for const in code.co_consts if not isinstance(const, types.CodeType))
    return code.co_code, code.co_names, code.co_varnames, constants


##
# Names by regular expression
##


def resolve_matching_names(
    keys: str | Sequence[str], list_of_strings: Sequence[str], preserve_order: bool = False
) -> tuple[list[int], list[str]]:
    """Find the names that regular expressions match in full (``re.fullmatch``).

    Args:
        keys: one expression or several. Each must match a name; no name may match two.
        list_of_strings: the names to search.
        preserve_order: order the result by ``keys`` (and by name within a key) instead of by ``list_of_strings``.

    Returns:
        Indices into ``list_of_strings``, and the names at them.

    Raises:
        ValueError: an expression matches nothing or is malformed, or a name matches several.
    """
    keys = [keys] if isinstance(keys, str) else list(keys)
    matches = _match(keys, list_of_strings, preserve_order, strict=True)
    return [index for index, _ in matches], [list_of_strings[index] for index, _ in matches]


def resolve_matching_names_values(
    data: dict[str, Any], list_of_strings: Sequence[str], preserve_order: bool = False, strict: bool = True
) -> tuple[list[int], list[str], list[Any]]:
    """Find the names that a dictionary's expressions match, with the dictionary's values.

    Args:
        data: expression -> value. Each must match a name; no name may match two.
        list_of_strings: the names to search.
        preserve_order: order the result by ``data`` instead of by ``list_of_strings``.
        strict: whether an expression that matches nothing is an error.

    Returns:
        Indices into ``list_of_strings``, the names at them, and their values.

    Raises:
        TypeError: ``data`` is not a dictionary.
        ValueError: an expression matches nothing (if ``strict``) or is malformed, or a name matches several.
    """
    if not isinstance(data, dict):
        raise TypeError(f"Input argument `data` should be a dictionary of expression -> value, got {data!r}")
    keys = list(data)
    matches = _match(keys, list_of_strings, preserve_order, strict)
    return (
        [index for index, _ in matches],
        [list_of_strings[index] for index, _ in matches],
        [data[keys[key]] for _, key in matches],
    )


def _match(keys: list[str], names: Sequence[str], by_key: bool, strict: bool) -> list[tuple[int, int]]:
    """Pairs of (index of the name, index of the key)."""
    patterns = []
    for key in keys:
        try:
            patterns.append(re.compile(key))
        except (re.error, TypeError) as error:
            raise ConfigError(f"{key!r} is not a regular expression: {error}") from None
    matches: list[tuple[int, int]] = []
    for index, name in enumerate(names):
        hits = [k for k, pattern in enumerate(patterns) if pattern.fullmatch(name)]
        if len(hits) > 1:
            raise ConfigError(
                f"Multiple matches for '{name}': {quote(keys[k] for k in hits)}; a name may match only one expression"
            )
        matches += [(index, k) for k in hits]
    if strict:
        matched = {k for _, k in matches}
        unmatched = [key for k, key in enumerate(keys) if k not in matched]
        if unmatched:
            hint = suggest(unmatched[0], names)
            listed = "" if hint.startswith(("choose", "there")) else f" Available: {quote(names, most=40)}."
            raise ConfigError(f"no name matches {quote(unmatched)}; {hint}{listed}")
    return sorted(matches, key=lambda pair: (pair[1], pair[0])) if by_key else matches


def find_unique_string_name(initial_name: str, is_unique_fn: Callable[[str], bool]) -> str:
    """Return ``initial_name``, or the first of ``initial_name_1``, ``_2``, ... that ``is_unique_fn`` accepts."""
    name, number = initial_name, 0
    while not is_unique_fn(name):
        number += 1
        name = f"{initial_name}_{number}"
    return name


def find_root_prim_path_from_regex(prim_path_regex: str) -> tuple[str | None, int | None]:
    """Split a prim path at its first component that is an expression.

    Args:
        prim_path_regex: e.g. ``"/World/envs/env_.*/Robot"``.

    Returns:
        The path above that component (``"/World/envs"``) and the component's level (3); (None, None) without one.
    """
    parts = str(prim_path_regex).split("/")
    for level, part in enumerate(parts):
        if any(char in part for char in "[]*|^"):
            return "/".join(parts[:level]), level
    return None, None
