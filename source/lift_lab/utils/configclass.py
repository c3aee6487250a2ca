"""The ``@configclass`` decorator: a dataclass that takes plain defaults.

Every annotated name and every unannotated value of the class body is a field, in the order of the body. A mutable
default is deep-copied for each instance. So is every value that is passed in or that ``__post_init__`` assigns.
``MISSING`` marks fields that a user has to set; ``validate`` finds them.
"""

from __future__ import annotations

import copy as copy_module
import copyreg
import dataclasses
import functools
import inspect
import types
from collections.abc import Callable
from dataclasses import Field, field
from typing import Any, ClassVar, TypeVar, dataclass_transform, overload

from .config_update import resolve_hint, update_class_from_dict
from .dict import class_to_dict
from .errors import ConfigError, MissingFieldError, quote, suggest
from .ranges import first_problem
from .string import is_function_like

MISSING: Any = dataclasses.MISSING
"""Mark of a field that a user has to set: the object of :mod:`dataclasses`, with any type for a type checker."""

_T = TypeVar("_T")
_IMMUTABLE = (int, float, complex, bool, str, bytes, type(None), type)
_NOT_FIELDS = (
    staticmethod,
    classmethod,
    property,
    functools.cached_property,
    types.ModuleType,
    types.MemberDescriptorType,
    types.GetSetDescriptorType,
)

# MISSING is compared by identity; without this a deep copy or a pickle would make another one.
copyreg.pickle(type(MISSING), lambda _: "MISSING")


@overload
def configclass(cls: type[_T], /, **kwargs: Any) -> type[_T]: ...
@overload
def configclass(cls: None = None, /, **kwargs: Any) -> Callable[[type[_T]], type[_T]]: ...
@dataclass_transform(field_specifiers=(field,))
def configclass(cls: type | None = None, /, **kwargs: Any) -> Any:
    """Make a class a configuration (Isaac Lab's ``configclass``).

    .. code-block:: python

        @configclass
        class EnvCfg:
            num_envs: int = MISSING          # must be set, reported by validate()
            episode_length_s = 5.0           # a field, typed from its value
            eye: list = [7.5, 7.5, 7.5]      # every instance has its own list
            viewer: ViewerCfg = ViewerCfg()
            func = my_module.my_function     # a field; a function defined in the body is a method

    A class defined in the body is not a field. A class assigned to another name (``class_type = Foo``) is one. The
    class gets ``to_dict``, ``from_dict``, ``copy``, ``replace`` and ``validate`` where it does not define them. It also
    gets a ``__post_init__`` that a sub-class may always call through ``super()``.

    Args:
        cls: the class.
        **kwargs: passed to :func:`dataclasses.dataclass`.

    Raises:
        TypeError: a field is ``MISSING`` without an annotation.
        ValueError: a field has an annotation but neither a default nor ``MISSING``.
    """
    if cls is None:
        return functools.partial(configclass, **kwargs)
    _declare_fields(cls)
    if not hasattr(cls, "__post_init__"):
        setattr(cls, "__post_init__", _cooperative_post_init(cls))  # noqa: B010
    for name, function in _METHODS.items():
        if not hasattr(cls, name):
            setattr(cls, name, function)
    own_init = "__init__" in vars(cls)
    cls = dataclasses.dataclass(cls, **kwargs)
    if kwargs.get("init", True) and not own_init:
        cls.__init__ = _isolating(cls.__init__)
    return cls


##
# Methods that every configuration has
##


def to_dict(self: Any) -> dict[str, Any]:
    """Nested dictionary of the values; callables as ``"module:name"``, ``MISSING`` as ``"???"``."""
    return class_to_dict(self)


def from_dict(self: Any, data: dict[str, Any]) -> None:
    """Set values in place from a nested dictionary. See :func:`lift_lab.utils.dict.update_class_from_dict`."""
    update_class_from_dict(self, data)


def copy(self: _T) -> _T:
    """An independent copy. Values are kept as they are: ``__post_init__`` does not run again."""
    return copy_module.deepcopy(self)


def replace(self: _T, **changes: Any) -> _T:
    """An independent copy with some fields changed. As for a dataclass, ``__post_init__`` runs on the result.

    Raises:
        TypeError: a name is not a field.
    """
    names = [f.name for f in dataclasses.fields(self) if f.init]  # type: ignore[arg-type]
    for name in changes:
        if name not in names:
            raise TypeError(f"{type(self).__name__} has no field '{name}'; {suggest(name, names)}")
    new = dataclasses.replace(self, **changes)  # type: ignore[type-var]
    for name, value in vars(self).items():
        if name not in vars(new):
            object.__setattr__(new, name, _fresh(value))
    return new


def validate(self: Any, prefix: str = "") -> list[str]:
    """Check the configuration and all that it holds: nothing is ``MISSING``, every number within its field's range.

    Args:
        prefix: path of this object, put before the paths found.

    Returns:
        An empty list.

    Raises:
        TypeError: lists the path of every ``MISSING`` entry, one a line.
        ConfigError: a number is NaN or outside of its field's range (:mod:`lift_lab.utils.ranges`), or a field that
            needs a value is None. The error names the path and the allowed values.
    """
    missing = _missing_paths(self, prefix)
    if missing:
        lines = "".join(f"  - {path}\n" for path in missing)
        raise MissingFieldError(f"{type(self).__name__} has no value for:\n{lines}")
    problem = first_problem(self, prefix)
    if problem is not None:
        raise ConfigError(problem)
    return missing


class ConfigBase:
    """Base of this library's configurations. It shows their methods to editors and type checkers.

    :func:`configclass` gives the methods to every class, with or without this base.
    """

    to_dict = to_dict
    from_dict = from_dict
    copy = copy
    replace = replace
    validate = validate

    def __post_init__(self) -> None:
        """Continue with the next class's."""
        following = getattr(super(), "__post_init__", None)
        if following is not None:
            following()


_METHODS = {"to_dict": to_dict, "from_dict": from_dict, "copy": copy, "replace": replace, "validate": validate}


def _missing_paths(value: Any, path: str) -> list[str]:
    if value is MISSING:
        return [path]
    if isinstance(value, (list, tuple)):
        entries = [(f"{path}[{index}]", entry) for index, entry in enumerate(value)]
    elif isinstance(value, dict):
        entries = [(f"{path}.{key}" if path else str(key), entry) for key, entry in value.items()]
    elif dataclasses.is_dataclass(value) and not isinstance(value, type):
        entries = [(f"{path}.{key}" if path else key, entry) for key, entry in vars(value).items()]
    else:
        return []
    return [found for entry_path, entry in entries for found in _missing_paths(entry, entry_path)]


##
# Building the dataclass
##


def _declare_fields(cls: type) -> None:
    """Give every field an annotation and a default that :mod:`dataclasses` accepts, in declaration order."""
    inherited: dict[str, Field] = {}  # as Python inherits: from the first class in the MRO that declares the name
    taken: dict[str, Field] = {}  # as dataclass inherits: from the first class in the MRO that has the name
    declared: dict[str, tuple[Any, Any]] = {}  # name -> (annotation, default)
    for base in reversed(cls.__mro__):
        if base is object or base.__module__ in ("typing", "abc"):
            continue
        if base is not cls and "__dataclass_fields__" in vars(base):
            for known in dataclasses.fields(base):
                name = known.name
                taken[name] = known
                if name in vars(base).get("__annotations__", {}) or name not in inherited:
                    inherited[name] = known
                    declared.pop(name, None)
            continue
        for name, (annotation, default) in _body_fields(base).items():
            known = declared.get(name) or _as_pair(inherited.get(name), cls)
            if annotation is None and known is not None:
                annotation = known[0]
            if default is _UNSET:
                if known is None:
                    raise ConfigError(
                        f"{cls.__qualname__}.{name} has an annotation but no default; write '{name}: ... = MISSING' "
                        "if it must be set"
                    )
                default = known[1]
            declared[name] = (_annotation_of(cls, name, default) if annotation is None else annotation, default)
    for name, known in inherited.items():
        if known is not taken[name] and name not in declared:
            declared[name] = (known.type, known)
    annotations = dict(vars(cls).get("__annotations__", {}))
    special = {name: ann for name, ann in annotations.items() if name not in declared}
    cls.__annotations__ = {name: annotation for name, (annotation, _) in declared.items()} | special
    for name, (_, default) in declared.items():
        setattr(cls, name, _as_field(default))


_UNSET = object()


def _body_fields(cls: type) -> dict[str, tuple[Any, Any]]:
    """Fields of one class body in the order of the body: name -> (annotation or None, default or _UNSET)."""
    annotations = vars(cls).get("__annotations__", {})
    found = {}
    for name, value in vars(cls).items():
        if name in annotations:
            if not _is_special(annotations[name]):
                found[name] = (annotations[name], value)
        elif _is_plain_field(cls, name, value):
            found[name] = (None, value)
    for name, annotation in annotations.items():
        if name not in vars(cls) and not _is_special(annotation):
            found[name] = (annotation, _UNSET)
    reserved = [name for name in found if name in _METHODS]
    if reserved:
        raise ConfigError(f"{cls.__qualname__}: {quote(reserved)} cannot be a field, as every configclass has it")
    return found


def _is_special(annotation: Any) -> bool:
    """Whether an annotation makes something other than an ordinary field (class variable, init-only, marker)."""
    if isinstance(annotation, str):
        return annotation.split("[")[0].rsplit(".")[-1].strip() in ("ClassVar", "InitVar", "KW_ONLY")
    return (
        annotation is ClassVar
        or getattr(annotation, "__origin__", None) is ClassVar
        or annotation in (dataclasses.KW_ONLY, dataclasses.InitVar)
        or isinstance(annotation, dataclasses.InitVar)
    )


def _is_plain_field(cls: type, name: str, value: Any) -> bool:
    """Whether an unannotated name of a class body is a field."""
    if name.startswith("__") or name == "_abc_impl" or isinstance(value, _NOT_FIELDS):
        return False
    if isinstance(value, type):
        return value.__name__ != name
    if isinstance(value, types.FunctionType):
        first = next(iter(value.__code__.co_varnames[: value.__code__.co_argcount]), None)
        defined_here = value.__qualname__ == f"{cls.__qualname__}.{value.__name__}" and value.__name__ != "<lambda>"
        return not defined_here and first != "self"
    return True


def _annotation_of(cls: type, name: str, default: Any) -> Any:
    """Annotation of a field that has none."""
    if default is MISSING:
        raise TypeError(f"{cls.__qualname__}.{name} is MISSING and has no annotation; write '{name}: <type> = MISSING'")
    if isinstance(default, type):
        return type[default]
    return Any if default is None or isinstance(default, Field) else type(default)


def _as_pair(inherited: Field | None, cls: type) -> tuple[Any, Any] | None:
    """Annotation and default of an inherited field, the annotation evaluated where it was written."""
    if inherited is None:
        return None
    for base in cls.__mro__[1:]:
        if inherited.name in vars(base).get("__annotations__", {}):
            hint = resolve_hint(inherited.type, base)
            return (inherited.type if hint is None else hint), inherited
    return inherited.type, inherited


def _as_field(default: Any) -> Any:
    """A dataclass field for a default that is a value, ``MISSING``, or already a field."""
    if isinstance(default, Field):
        if default.default_factory is not MISSING:
            return _copy_field(default, default_factory=default.default_factory)
        if default.default is not MISSING and isinstance(default.default, _IMMUTABLE):
            return _copy_field(default, default=default.default)
        return _copy_field(default, default_factory=functools.partial(_fresh, default.default))
    if isinstance(default, _IMMUTABLE):
        return field(default=default)
    return field(default_factory=functools.partial(_fresh, default))


def _copy_field(source: Field, **default: Any) -> Field:
    names = ("init", "repr", "hash", "compare", "metadata", "kw_only")
    return field(**default, **{name: getattr(source, name) for name in names})


def _fresh(value: Any) -> Any:
    """A deep copy of data; code (functions, bound methods, classes) is shared."""
    return value if is_function_like(value) else copy_module.deepcopy(value)


def _isolating(init: Callable[..., None]) -> Callable[..., None]:
    """Wrap ``__init__`` so that the finished instance shares no mutable value with anything else."""
    accepted = list(inspect.signature(init).parameters)[1:]

    @functools.wraps(init)
    def __init__(self, *args: Any, **kwargs: Any) -> None:
        for name in kwargs:
            if name not in accepted:
                raise TypeError(f"{type(self).__name__} has no field '{name}'; {suggest(name, accepted)}")
        init(self, *args, **kwargs)
        for name, value in list(vars(self).items()):
            own = _fresh(value)
            if own is not value:
                object.__setattr__(self, name, own)

    return __init__


def _cooperative_post_init(cls: type) -> Callable[[Any], None]:
    def __post_init__(self) -> None:
        following = getattr(super(cls, self), "__post_init__", None)
        if following is not None:
            following()

    return __post_init__
