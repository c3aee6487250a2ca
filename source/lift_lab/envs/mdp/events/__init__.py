"""Event terms, with Isaac Lab's names: what happens to the scene at start-up, at a reset or now and then.

Each is called as ``term(env, env_ids, **params)``; ``env_ids`` is None for all environments.
"""

from .disturbances import *
from .randomization import *
from .resets import *
