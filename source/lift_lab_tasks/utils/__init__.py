"""Finding tasks and their configurations. Overrides from a command line are in :mod:`lift_lab_tasks.utils.hydra`."""

from .importer import import_packages
from .parse_cfg import (
    get_checkpoint_path,
    import_user_module,
    load_cfg_from_registry,
    num_envs_for_device,
    parse_env_cfg,
    registered_tasks,
    task_kwargs,
)
from .policies import LoadedPolicy, load_policy

__all__ = [
    "LoadedPolicy",
    "get_checkpoint_path",
    "import_packages",
    "import_user_module",
    "load_cfg_from_registry",
    "load_policy",
    "num_envs_for_device",
    "parse_env_cfg",
    "registered_tasks",
    "task_kwargs",
]
