"""Reading and writing files."""

from .atomic import remove_dead_temporaries, temporary_path, write_atomically
from .torchscript import load_torchscript_model
from .yaml import dump_yaml, load_yaml

__all__ = [
    "dump_yaml",
    "load_torchscript_model",
    "load_yaml",
    "remove_dead_temporaries",
    "temporary_path",
    "write_atomically",
]
