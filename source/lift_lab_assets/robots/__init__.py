"""One module a robot. Its articulation configs are found by their type; a line below shows them to editors."""

from __future__ import annotations

import functools
import importlib
import pkgutil
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from lift_lab.assets import ArticulationCfg

    from .cartpole import *
    from .franka import *


@functools.cache
def robot_configs() -> dict[str, ArticulationCfg]:
    """Configurations of all modules of this package, by name.

    Raises:
        ConfigError: two modules give one name to different configurations.
    """
    from lift_lab.assets import ArticulationCfg
    from lift_lab.utils.errors import ConfigError

    found: dict[str, tuple[str, ArticulationCfg]] = {}
    for info in pkgutil.iter_modules(__path__):  # noqa: F405
        module = importlib.import_module(f"{__name__}.{info.name}")
        for name, value in vars(module).items():
            if isinstance(value, ArticulationCfg) and not name.startswith("_"):
                owner, known = found.setdefault(name, (info.name, value))
                if known is not value:
                    raise ConfigError(f"'{name}' is a robot in {owner}.py and another one in {info.name}.py")
    return {name: value for name, (_, value) in found.items()}


if not TYPE_CHECKING:  # a type checker would take every name for a robot

    def __getattr__(name: str) -> Any:
        """A configuration.

        Raises:
            AttributeError: no module has it; names the nearest.
        """
        from lift_lab.utils.errors import UnknownAttributeError, suggest

        if name == "__all__":  # a star import asks for it
            return [*robot_configs()]
        if name.startswith("_"):
            raise UnknownAttributeError(f"no robot '{name}'")
        configs = robot_configs()
        if name not in configs and name not in globals():  # the search has loaded the modules
            raise UnknownAttributeError(f"no robot '{name}'; {suggest(name, configs)}")
        return configs.get(name) or globals()[name]


def __dir__() -> list[str]:
    return sorted({*globals(), *robot_configs()})
