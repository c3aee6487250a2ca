"""YAML files that hold configurations.

Tuples are tagged ``!!python/tuple`` and read back as tuples; slices are written as ``slice(a,b,c)``. Nothing else
needs a tag, so a file is read without running code.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import torch
import yaml

from ..dict import class_to_dict, replace_slices_with_strings
from ..errors import FileError
from .atomic import write_atomically

_TUPLE = "tag:yaml.org,2002:python/tuple"


def load_yaml(filename: str | Path) -> Any:
    """Read a YAML file.

    Raises:
        FileError: no such file.
    """
    if not Path(filename).is_file():
        raise FileError(f"no file '{filename}'")
    with open(filename, encoding="utf-8") as file:
        return yaml.load(file, Loader=_Loader)


def dump_yaml(filename: str | Path, data: dict | object, sort_keys: bool = False) -> None:
    """Write a dictionary or configuration to a YAML file, atomically, making its folder.

    Args:
        filename: path; ``.yaml`` is appended if it does not end in "yaml".
        data: dictionary or configuration.
        sort_keys: whether keys are sorted rather than kept in order.

    Raises:
        FileError: it cannot be written.
    """
    path = Path(filename)
    if not path.name.endswith("yaml"):
        path = path.with_name(path.name + ".yaml")
    plain = replace_slices_with_strings(class_to_dict(data))
    text = yaml.dump(plain, Dumper=_Dumper, default_flow_style=False, sort_keys=sort_keys)
    write_atomically(path, text.encode())


class _Loader(yaml.SafeLoader):
    """Safe YAML, with tuples, and with numbers such as 1e-3 read as numbers."""


def _construct_tuple(loader: _Loader, node: Any) -> tuple:
    return tuple(loader.construct_sequence(node, deep=True))


_Loader.add_constructor(_TUPLE, _construct_tuple)
_Loader.add_implicit_resolver(
    "tag:yaml.org,2002:float", re.compile(r"[-+]?(?:[0-9]+\.?|\.[0-9])[0-9]*[eE][-+]?[0-9]+$"), list("-+.0123456789")
)


class _Dumper(yaml.SafeDumper):
    """Safe YAML, with tuples and arrays, without anchors; what has no YAML form is written as text."""

    def ignore_aliases(self, data: Any) -> bool:
        return True


_Dumper.add_representer(tuple, lambda dumper, data: dumper.represent_sequence(_TUPLE, data))
_Dumper.add_representer(np.ndarray, lambda dumper, data: dumper.represent_data(data.tolist()))
_Dumper.add_representer(torch.Tensor, lambda dumper, data: dumper.represent_data(data.tolist()))
_Dumper.add_multi_representer(np.generic, lambda dumper, data: dumper.represent_data(data.item()))
_Dumper.add_multi_representer(object, lambda dumper, data: dumper.represent_str(str(data)))
