# Made by scripts/maintainers/make_stubs.py from mujoco 4.0.0. Do not edit.
import collections.abc
import typing
from typing import Any, ClassVar

import numpy
import numpy.typing
from numpy.typing import NDArray

from ._types import *

def get_mju_user_warning() -> Any: ...
def set_mju_user_warning(arg0: Any) -> None: ...
