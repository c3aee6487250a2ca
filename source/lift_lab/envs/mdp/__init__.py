"""Terms of a Markov decision process, with Isaac Lab's names: import as ``import lift_lab.envs.mdp as mdp``.

A term is a function ``(env, **params)`` (events and curricula: ``(env, env_ids, **params)``) or a class of the same
call. A config names it; a manager calls it.
"""

from .actions import *
from .commands import *
from .curriculums import *
from .events import *
from .observations import *
from .recorders import *
from .rewards import *
from .terminations import *
from .unsupported import (
    body_incoming_wrench,
    height_scan,
    image,
    image_features,
    randomize_fixed_tendon_parameters,
    randomize_rigid_body_scale,
    randomize_visual_color,
    randomize_visual_texture_material,
    reset_root_state_from_terrain,
)
