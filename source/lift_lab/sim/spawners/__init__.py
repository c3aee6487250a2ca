"""Spawners: configs that become a MjSpec, by loading or authoring USD."""

from .from_files import *  # noqa: F403
from .lights import *  # noqa: F403
from .materials import *  # noqa: F403
from .meshes import *  # noqa: F403
from .sensors import *  # noqa: F403
from .shapes import *  # noqa: F403
from .spawner_cfg import DeformableObjectSpawnerCfg, RigidObjectSpawnerCfg, Spawned, SpawnerCfg
from .wrappers import *  # noqa: F403
