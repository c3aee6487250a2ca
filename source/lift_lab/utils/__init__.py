"""Utilities without simulation: configuration classes, strings, arrays, buffers, files."""

from .array import TENSOR_TYPE_CONVERSIONS, TENSOR_TYPES, TensorData, convert_to_torch
from .buffers import CircularBuffer, DelayBuffer, TimestampedBuffer
from .configclass import MISSING, ConfigBase, configclass
from .dict import (
    class_to_dict,
    convert_dict_to_backend,
    dict_to_md5_hash,
    print_dict,
    replace_slices_with_strings,
    replace_strings_with_slices,
    update_class_from_dict,
    update_dict,
)
from .interpolation import LinearInterpolation
from .modifiers import (
    DigitalFilter,
    DigitalFilterCfg,
    Integrator,
    IntegratorCfg,
    ModifierBase,
    ModifierCfg,
    bias,
    clip,
    scale,
)
from .seed import configure_seed
from .string import (
    callable_to_string,
    find_root_prim_path_from_regex,
    find_unique_string_name,
    is_lambda_expression,
    resolve_matching_names,
    resolve_matching_names_values,
    string_to_callable,
    string_to_slice,
    to_camel_case,
    to_snake_case,
)
from .timer import Timer, TimerError
from .types import ArticulationActions

__all__ = [
    "MISSING",
    "TENSOR_TYPES",
    "TENSOR_TYPE_CONVERSIONS",
    "ArticulationActions",
    "CircularBuffer",
    "ConfigBase",
    "DelayBuffer",
    "DigitalFilter",
    "DigitalFilterCfg",
    "Integrator",
    "IntegratorCfg",
    "LinearInterpolation",
    "ModifierBase",
    "ModifierCfg",
    "TensorData",
    "Timer",
    "TimerError",
    "TimestampedBuffer",
    "bias",
    "callable_to_string",
    "class_to_dict",
    "clip",
    "configclass",
    "configure_seed",
    "convert_dict_to_backend",
    "convert_to_torch",
    "dict_to_md5_hash",
    "find_root_prim_path_from_regex",
    "find_unique_string_name",
    "is_lambda_expression",
    "print_dict",
    "replace_slices_with_strings",
    "replace_strings_with_slices",
    "resolve_matching_names",
    "resolve_matching_names_values",
    "scale",
    "string_to_callable",
    "string_to_slice",
    "to_camel_case",
    "to_snake_case",
    "update_class_from_dict",
    "update_dict",
]
