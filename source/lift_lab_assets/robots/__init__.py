"""One module a robot."""

from .cartpole import *  # noqa: F403
from .franka import *  # noqa: F403
