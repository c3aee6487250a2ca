"""Terms of a Markov decision process, with Isaac Lab's names: import as ``import lift_lab.envs.mdp as mdp``.

A term is a function ``(env, **params)`` (events and curricula: ``(env, env_ids, **params)``) or a class of the same
call. A config names it; a manager calls it.
"""

from typing import TYPE_CHECKING

from lift_lab.isaac.finder import attributes_of

from .actions import *
from .commands import *
from .curriculums import *
from .events import *
from .metrics import *
from .observations import *
from .recorders import *
from .rewards import *
from .terminations import *

if TYPE_CHECKING:
    from ...isaac.mdp import *
else:
    __getattr__, __dir__, __all__ = attributes_of(__name__)
