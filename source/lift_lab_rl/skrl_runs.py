"""Making and loading agents of skrl, and its curves under our names. Needs the extra ``skrl``."""

from __future__ import annotations

import contextlib
import copy
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import torch
from skrl.agents.torch import base
from skrl.utils.runner.torch import Runner
from skrl.utils.tensorboard import SummaryWriter
from tensorboard.compat.proto.event_pb2 import (
    Event,  # pyright: ignore[reportAttributeAccessIssue]  # protobuf makes it at import
)

from lift_lab.utils.errors import ConfigError, quote

from .curve_layout import layout_summary
from .episode_logs import EpisodeLogs
from .library_files import read_skrl
from .library_ranges import refusals_of
from .scalar_names import SKRL_NAMES
from .skrl import SkrlVecEnvWrapper


def make_runner(env: SkrlVecEnvWrapper, cfg: dict[str, Any]) -> Runner:
    """skrl's runner of an environment, whose curves have our names.

    Raises:
        ConfigError: skrl refuses a setting.
    """
    with refusals_of("skrl"), _our_writer():
        runner = Runner(env, cfg)
    share_names(runner.agent)
    return runner


def share_names(agent: Any) -> None:
    """Let an agent write its curves under the names that all libraries share; see :mod:`lift_lab_rl.scalar_names`.

    The environment's log is averaged over the episodes that ended between two writes. skrl alone averages over
    environment steps, and counts a log again at every step until the next one.

    Args:
        agent: skrl's agent; call after its trainer was made, and before it trains.
    """
    logs, of_env = EpisodeLogs(), set()
    record, write = agent.record_transition, agent.write_tracking_data

    def record_transition(*, terminated: torch.Tensor, truncated: torch.Tensor, infos: Any, **others: Any) -> None:
        of_env.update(infos.get("log", {}))
        ended = (terminated | truncated).flatten()
        if bool(ended.any()):
            logs.add(infos, ended)
        record(terminated=terminated, truncated=truncated, infos=infos, **others)

    def write_tracking_data(*, timestep: int, timesteps: int) -> None:
        tracked, values = agent.tracking_data, {}
        for tag, numbers in tracked.items():
            if tag.removeprefix("Info / ") in of_env:
                continue
            name, factor = SKRL_NAMES.get(tag, (tag, 1.0))
            reduce = np.min if tag.endswith("(min)") else np.max if tag.endswith("(max)") else np.mean
            values[name] = factor * float(reduce(numbers))
        values |= {key if "/" in key else f"Episode/{key}": value for key, value in logs.means().items()}
        tracked.clear()
        tracked.update({name: [value] for name, value in values.items()})
        write(timestep=timestep, timesteps=timesteps)
        agent.writer.flush()
        logs.clear()

    agent.record_transition, agent.write_tracking_data = record_transition, write_tracking_data


@contextlib.contextmanager
def _our_writer() -> Iterator[None]:
    """Let agents that are made meanwhile write with our writer: skrl has no setting for it."""
    before = base.SummaryWriter
    base.SummaryWriter = _Writer
    try:
        yield
    finally:
        base.SummaryWriter = before


class _Writer(SummaryWriter):
    """skrl's writer, with the layout of TensorBoard's page as its first event."""

    def __init__(self, log_dir: str):
        super().__init__(log_dir)
        self._event_file_writer.add_event(Event(summary=layout_summary()))


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
