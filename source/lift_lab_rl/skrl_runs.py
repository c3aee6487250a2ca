"""Making and loading agents of skrl. Needs the extra ``skrl``."""

from __future__ import annotations

import copy
from pathlib import Path
from typing import Any

from skrl.utils.runner.torch import Runner

from lift_lab.utils.errors import ConfigError, quote

from .library_files import read_skrl
from .library_ranges import refusals_of
from .skrl import SkrlVecEnvWrapper


def make_runner(env: SkrlVecEnvWrapper, cfg: dict[str, Any]) -> Runner:
    """skrl's runner of an environment.

    Raises:
        ConfigError: skrl refuses a setting.
    """
    with refusals_of("skrl"):
        return Runner(env, cfg)


def load_agent(agent: Any, path: str | Path, trust: bool = False) -> None:
    """Load all modules of an agent: networks, optimiser and statistics.

    skrl's own ``agent.load`` runs code that is in the file, and skips what does not belong to the agent.

    Args:
        agent: skrl's agent.
        path: file that ``agent.save`` wrote.
        trust: whether to read a file that holds more than tensors and plain values, which runs code that is in it.

    Raises:
        FileError: there is no such file, it is damaged, or it is not trusted.
        ConfigError: the file is of another library or of another agent. The agent is as it was.
    """
    states, modules = read_skrl(path, trust, agent.device), agent.checkpoint_modules
    for owner, names in (("the file", modules.keys() - states.keys()), ("this agent", states.keys() - modules.keys())):
        if names:
            raise ConfigError(f"checkpoint '{path}' does not fit this agent: {owner} lacks {quote(sorted(names))}")
    before = {name: copy.deepcopy(module.state_dict()) for name, module in modules.items()}
    try:
        for name, module in modules.items():
            module.load_state_dict(states[name])
    except Exception as error:  # whatever a wrong state makes of it
        for name, state in before.items():
            modules[name].load_state_dict(state)
        reason = " ".join(str(error).split())[:200].rstrip(" .")
        raise ConfigError(f"checkpoint '{path}' does not fit this agent: {reason}") from error
    for module in modules.values():
        if hasattr(module, "eval"):
            module.eval()
