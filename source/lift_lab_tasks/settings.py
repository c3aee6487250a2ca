"""The settings of a program: a task's configurations with the flags and overrides of a command line.

A flag such as ``--num_envs 8`` is an override, too: of ``env.scene.num_envs``. Flags are set before hydra composes the
overrides, so an override may refer to a flag's value. A flag and an override that give one entry different values are
an error.
"""

from __future__ import annotations

import random
from collections.abc import Sequence
from typing import Any

from lift_lab.app.cli import FlagSetting
from lift_lab.sim.simulation_context import resolve_device
from lift_lab.utils.configclass import validate
from lift_lab.utils.errors import ConfigError

from .utils.hydra import compose, find_entry, given_paths, set_entry
from .utils.parse_cfg import num_envs_for_device
from .utils.runs import check_run_names


class Settings:
    """Configurations of a task and of an agent, and what of them was given on the command line.

    Attributes:
        task: id of the task.
        env: environment configuration.
        agent: agent configuration: an object, a dictionary, or None.
        overrides: overrides as they were written, without flags.
    """

    def __init__(
        self,
        task: str,
        agent_cfg_entry_point: str | None = None,
        overrides: Sequence[str] = (),
        flags: Sequence[FlagSetting] = (),
    ):
        """Compose the configurations.

        Args:
            task: id of the task.
            agent_cfg_entry_point: key of the agent's configuration; None for none.
            overrides: in hydra's grammar, see :mod:`lift_lab_tasks.utils.hydra`.
            flags: entries that flags set. An entry that the configurations do not have is passed over.

        Raises:
            NotFoundError: no such task or agent.
            ConfigError: an override is wrong, or an override and a flag give an entry different values.
        """
        self.task, self.overrides = task, list(overrides)
        self.env, self.agent = compose(task, agent_cfg_entry_point, overrides, flags)
        self._given = set(given_paths(overrides))
        for flag, path, value in flags:
            self._check_flag(flag, path, value)

    def given(self, path: str, below: bool = False) -> bool:
        """Whether a flag or an override sets an entry, alone or within a dictionary.

        Args:
            path: of the entry, such as ``env.scene.num_envs``.
            below: whether an entry below it counts, too.
        """
        return path in self._given or (below and any(name.startswith(f"{path}.") for name in self._given))

    def set(self, flag: str, path: str, value: Any) -> None:
        """Set an entry for a flag whose value or path depends on other settings.

        Args:
            flag: for the user.
            path: of the entry.
            value: its value.

        Raises:
            ConfigError: an override gives the entry another value.
        """
        if not self.given(path):
            set_entry(self._configs, path, value)
        self._check_flag(flag, path, value)

    def resolve(self, training: bool = False, num_envs: int | None = None) -> None:
        """Fill in what depends on the machine and on other settings, and check all numbers.

        Args:
            training: whether a policy is trained, not shown or judged. Otherwise curriculum terms that only help
                exploration are removed, unless they are given.
            num_envs: environments unless their number is given; None for what suits the device.

        Raises:
            ConfigError: no such device, a setting is outside of its range, or a name cannot be a run's.
        """
        if not training:
            from lift_lab.managers.manager_term_cfg import leave_out_training_only

            leave_out_training_only(self.env, lambda name: self.given(f"env.curriculum.{name}", below=True))
        self.env.sim.device = resolve_device(self.env.sim.device)
        if not self.given("env.scene.num_envs"):
            self.env.scene.num_envs = num_envs or num_envs_for_device(self.task, self.env)
        self._share_seed()
        validate(self.env, "env")
        if self.agent is not None and not isinstance(self.agent, dict):
            if self.agent.device == "auto":
                self.agent.device = self.env.sim.device
            self.agent.device = resolve_device(self.agent.device)
            validate(self.agent, "agent")
            check_run_names(self.agent)

    @property
    def seed(self) -> int | None:
        """Seed of the environment and the agent."""
        return self.env.seed

    @seed.setter
    def seed(self, seed: int | None) -> None:
        self.env.seed = seed
        if isinstance(self.agent, dict):
            self.agent["seed"] = seed
        elif self.agent is not None:
            self.agent.seed = seed

    @property
    def _configs(self) -> dict[str, Any]:
        return {"env": self.env} if self.agent is None else {"env": self.env, "agent": self.agent}

    def _check_flag(self, flag: str, path: str, value: Any) -> None:
        exists, found = find_entry(self._configs, path)
        if not exists:
            return
        if found != value:
            raise ConfigError(f"{flag} {value} and {path}={found}: give one of them")
        self._given.add(path)

    def _share_seed(self) -> None:
        """Give environment and agent one seed: the one that is given, else the agent's. -1 draws one."""
        given = {path: find_entry(self._configs, path)[1] for path in ("env.seed", "agent.seed") if self.given(path)}
        if len(set(given.values())) > 1:
            text = " and ".join(f"{path}={seed}" for path, seed in given.items())
            raise ConfigError(f"{text}: environment and agent share their random numbers; give one seed")
        agents = find_entry(self._configs, "agent.seed")[1]
        seed = next(iter(given.values())) if given else self.env.seed if agents is None else agents
        if seed == -1:
            seed = random.randint(0, 10_000)
        if given or agents is not None:
            self.seed = seed
        else:
            self.env.seed = seed
