"""One module a robot."""

from .cartpole import *
from .franka import *
