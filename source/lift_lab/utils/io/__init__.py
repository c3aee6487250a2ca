"""Reading and writing files."""

from .torchscript import load_torchscript_model
from .yaml import dump_yaml, load_yaml
