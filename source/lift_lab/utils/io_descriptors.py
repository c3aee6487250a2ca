"""Descriptions of a policy's inputs and outputs, with Isaac Lab's names and keys.

:func:`generic_io_descriptor` notes units, axes and kind of an observation term. The managers fill in the rest:
shape, data type, joint names, scales. :attr:`lift_lab.envs.ManagerBasedEnv.get_IO_descriptors` collects everything.
"""

from __future__ import annotations

import copy
import dataclasses
import enum
import inspect
from collections.abc import Callable, Mapping
from pathlib import PurePath
from typing import Any, TypeVar, overload
from weakref import WeakKeyDictionary

import numpy as np
import torch

from .dict import class_to_dict

__all__ = [
    "GenericActionIODescriptor",
    "GenericObservationIODescriptor",
    "describe_observation",
    "formatted",
    "generic_io_descriptor",
    "plain",
    "record_body_names",
    "record_dtype",
    "record_joint_names",
    "record_joint_pos_offsets",
    "record_joint_vel_offsets",
    "record_shape",
]

Term = TypeVar("Term", bound=Callable[..., Any])
Hook = Callable[..., Any]
_Hooks = Hook | list[Hook] | tuple[Hook, ...] | None


class GenericActionIODescriptor:
    """Description of an action term. A sub-class of an action term may add attributes of its own."""

    joint_names: list[str]
    body_name: str
    scale: Any
    offset: Any
    clip: Any
    alpha: Any
    x_joint_name: str
    y_joint_name: str
    yaw_joint_name: str
    position_scale: float
    orientation_scale: float
    wrench_scale: float
    stiffness_scale: float
    damping_ratio_scale: float
    nullspace_joint_pos_target: str

    def __init__(
        self,
        mdp_type: str = "Action",
        name: str | None = None,
        full_path: str | None = None,
        description: str | None = None,
        shape: tuple[int, ...] | None = None,
        dtype: str | None = None,
        action_type: str | None = None,
        extras: dict[str, Any] | None = None,
        export: bool = True,
    ):
        """Make a description.

        Args:
            mdp_type: "Action".
            name: name of the term's class in lower case, such as ``joint_position_action``.
            full_path: module and name of the class.
            description: what the term does.
            shape: shape of the term's part of the action of one environment.
            dtype: data type, such as ``torch.float32``.
            action_type: kind of the term, such as ``JointAction``.
            extras: anything else.
            export: whether the description is exported.
        """
        self.mdp_type, self.name, self.full_path, self.description = mdp_type, name, full_path, description
        self.shape, self.dtype, self.action_type = shape, dtype, action_type
        self.extras: dict[str, Any] = {} if extras is None else extras
        self.export = export


class GenericObservationIODescriptor:
    """Description of an observation term. Hooks may add attributes of their own."""

    joint_names: list[str]
    body_names: list[str]
    joint_pos_offsets: Any
    joint_vel_offsets: Any

    def __init__(
        self,
        mdp_type: str = "Observation",
        name: str | None = None,
        full_path: str | None = None,
        description: str | None = None,
        shape: tuple[int, ...] | None = None,
        dtype: str | None = None,
        observation_type: str | None = None,
        extras: dict[str, Any] | None = None,
    ):
        """Make a description.

        Args:
            mdp_type: "Observation".
            name: name of the term's function.
            full_path: module and name of the function.
            description: what the term observes.
            shape: shape of the term's value in one environment, before history.
            dtype: data type, such as ``torch.float32``.
            observation_type: kind of the term, such as ``JointState``.
            extras: anything else, such as ``axes``.
        """
        self.mdp_type, self.name, self.full_path, self.description = mdp_type, name, full_path, description
        self.shape, self.dtype, self.observation_type = shape, dtype, observation_type
        self.extras: dict[str, Any] = {} if extras is None else extras


@dataclasses.dataclass(frozen=True)
class _Noted:
    """What the decorator was told."""

    descriptor: GenericObservationIODescriptor
    hooks: tuple[Hook, ...]


_NOTED: WeakKeyDictionary[Callable[..., Any], _Noted] = WeakKeyDictionary()
_FIELDS = tuple(vars(GenericObservationIODescriptor()))


@overload
def generic_io_descriptor(_func: Term, /) -> Term: ...
@overload
def generic_io_descriptor(
    _func: GenericObservationIODescriptor | None = None,
    /,
    *,
    on_inspect: _Hooks = None,
    **description: Any,
) -> Callable[[Term], Term]: ...


def generic_io_descriptor(_func: Any = None, /, *, on_inspect: _Hooks = None, **description: Any) -> Any:
    """Describe an observation term. The term itself stays as it is.

    Isaac Lab's decorator also lets the term be called with ``inspect=True``; here the observation manager calls the
    hooks by itself.

    Args:
        _func: the term, where the decorator is used without arguments; or a whole descriptor.
        on_inspect: hooks, such as :func:`record_shape`. Each is called with ``output`` (the term's value),
            ``descriptor``, and the term's arguments by name.
        **description: fields of :class:`GenericObservationIODescriptor`; others go into its ``extras``.
    """
    if isinstance(_func, GenericObservationIODescriptor):
        descriptor, _func = _func, None
    else:
        extras = {key: value for key, value in description.items() if key not in _FIELDS}
        fields = {key: value for key, value in description.items() if key in _FIELDS}
        descriptor = GenericObservationIODescriptor(**fields)
        descriptor.extras = descriptor.extras | extras
    hooks = tuple(on_inspect or ()) if isinstance(on_inspect, (list, tuple)) else (on_inspect,) if on_inspect else ()

    def note(function: Term) -> Term:
        _NOTED[function] = _Noted(descriptor, hooks)
        return function

    return note if _func is None else note(_func)


# -- hooks


def record_shape(output: torch.Tensor, descriptor: GenericObservationIODescriptor, **kwargs: Any) -> None:
    """Note the length of the term's last dimension."""
    descriptor.shape = (output.shape[-1],)


def record_dtype(output: torch.Tensor, descriptor: GenericObservationIODescriptor, **kwargs: Any) -> None:
    """Note the term's data type."""
    descriptor.dtype = str(output.dtype)


def record_joint_names(output: torch.Tensor, descriptor: GenericObservationIODescriptor, **kwargs: Any) -> None:
    """Note the joints of the term's ``asset_cfg``."""
    entity = kwargs["asset_cfg"]
    descriptor.joint_names = _chosen(kwargs["env"].scene[entity.name].joint_names, entity.joint_ids)


def record_body_names(output: torch.Tensor, descriptor: GenericObservationIODescriptor, **kwargs: Any) -> None:
    """Note the bodies of the term's ``asset_cfg``."""
    entity = kwargs["asset_cfg"]
    descriptor.body_names = _chosen(kwargs["env"].scene[entity.name].body_names, entity.body_ids)


def record_joint_pos_offsets(output: torch.Tensor, descriptor: GenericObservationIODescriptor, **kwargs: Any) -> None:
    """Note the default joint positions of the term's ``asset_cfg`` in the first environment."""
    entity = kwargs["asset_cfg"]
    descriptor.joint_pos_offsets = kwargs["env"].scene[entity.name].data.default_joint_pos[0, entity.joint_ids]


def record_joint_vel_offsets(output: torch.Tensor, descriptor: GenericObservationIODescriptor, **kwargs: Any) -> None:
    """Note the default joint velocities of the term's ``asset_cfg`` in the first environment."""
    entity = kwargs["asset_cfg"]
    descriptor.joint_vel_offsets = kwargs["env"].scene[entity.name].data.default_joint_vel[0, entity.joint_ids]


def _chosen(names: list[str], ids: Any) -> list[str]:
    return names[ids] if isinstance(ids, slice) else [names[i] for i in ids]


# -- for the managers


def describe_observation(
    function: Callable[..., Any], env: Any, params: Mapping[str, Any], value: torch.Tensor
) -> GenericObservationIODescriptor:
    """The description of an observation term.

    Args:
        function: the term: a function, or an object of a class of terms.
        env: the environment.
        params: the term's arguments.
        value: the term's value, shape (num_envs, ...).
    """
    subject = function if hasattr(function, "__name__") else type(function)
    noted = _NOTED.get(subject)
    descriptor = GenericObservationIODescriptor() if noted is None else copy.deepcopy(noted.descriptor)
    descriptor.name = subject.__name__
    descriptor.full_path = f"{subject.__module__}.{subject.__name__}"
    if descriptor.description is None:
        descriptor.description = " ".join((subject.__doc__ or "").split())
    descriptor.shape, descriptor.dtype = tuple(value.shape[1:]), str(value.dtype)
    if noted is not None and noted.hooks:
        arguments = inspect.signature(function).bind(env, **params)
        arguments.apply_defaults()
        named = {"env": env, **arguments.arguments}
        for hook in noted.hooks:
            hook(output=value, descriptor=descriptor, **named)
    return descriptor


def formatted(
    descriptor: GenericActionIODescriptor | GenericObservationIODescriptor, overloads: Mapping[str, Any] | None = None
) -> dict[str, Any]:
    """A description as plain data with Isaac Lab's keys.

    Args:
        descriptor: the description.
        overloads: what an observation term's config does to its value; None for an action.
    """
    values = dict(vars(descriptor))
    result: dict[str, Any] = {"name": values.pop("name")}
    if overloads is not None:
        result["overloads"] = {key: value for key, value in overloads.items() if key != "modifiers"}
    result["extras"] = {**values.pop("extras"), "description": values.pop("description")}
    if overloads is not None and "modifiers" in overloads:
        result["extras"]["modifiers"] = overloads["modifiers"]
    if not values.pop("export", True):
        return {}
    return plain(result | values)


def plain(value: Any) -> Any:
    """Numbers, texts, lists and dictionaries instead of tensors, tuples, configurations and functions."""
    if isinstance(value, torch.Tensor):
        return plain(value.detach().cpu().numpy())
    if isinstance(value, np.ndarray):
        return [plain(entry) for entry in value] if value.ndim else plain(value[()])
    if isinstance(value, np.generic):  # in single precision 0.04, not 0.03999999910593033, which is the same number
        return float(str(value)) if value.dtype == np.float32 else value.item()
    if isinstance(value, dict):
        return {str(key): plain(entry) for key, entry in value.items()}
    if isinstance(value, (list, tuple, set, frozenset)):
        return [plain(entry) for entry in value]
    if value is None or isinstance(value, (bool, int, float, str)):
        return value
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return {field: plain(entry) for field, entry in vars(value).items()}
    if isinstance(value, enum.Enum):
        return value.name
    if isinstance(value, (PurePath, slice)):
        return str(value)
    text = class_to_dict(value) if callable(value) else None
    return text if isinstance(text, str) else type(value).__qualname__  # of other objects the class
