"""Utilities that know nothing of simulation: configuration classes, strings, arrays, buffers, files."""

import dataclasses as _dataclasses
from typing import Any as _Any

from .array import TENSOR_TYPE_CONVERSIONS, TENSOR_TYPES, TensorData, convert_to_torch
from .buffers import CircularBuffer, DelayBuffer, TimestampedBuffer
from .configclass import configclass
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

MISSING: _Any = _dataclasses.MISSING
"""What a user has to set; the same object as :data:`dataclasses.MISSING`, fit for an argument of any type."""
