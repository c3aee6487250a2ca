"""Agents that need no policy: zero and random actions, for ``play --agent zero`` and ``play --agent random``."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from lift_lab.app import cli

from .library import Player

SCRIPTED = ("zero", "random")
"""Values of --agent that need no policy."""
MOST_ENVS = 50
"""Default number of environments shown without a policy."""
_POLICY_FLAGS = (
    *("checkpoint", "load_run", "experiment_name", "use_last_checkpoint"),
    *("use_pretrained_checkpoint", "trust"),
)


def check_scripted_flags(parser: cli.Parser, args: argparse.Namespace) -> None:
    """End with one line where a flag that says which policy acts goes with an agent that needs none."""
    for name in _POLICY_FLAGS:
        if args.agent in SCRIPTED and getattr(args, name, None):
            parser.error(f"--agent {args.agent} needs no --{name}")


def scripted_settings(args: argparse.Namespace, overrides: list[str]) -> Any:
    """Return the settings of a task without an agent, with a seed, and with at most :data:`MOST_ENVS` environments by
    default.

    Raises:
        LiftLabError: there is no such task, or a setting is wrong.
    """
    from lift_lab_tasks.settings import Settings

    settings = Settings(args.task, None, overrides, args.flag_settings)
    settings.resolve(num_envs=min(settings.env.scene.num_envs, MOST_ENVS))
    settings.env.seed = 42 if settings.env.seed is None else settings.env.seed
    return settings


def video_file(task: str, agent: str) -> Path:
    """Return the file of a film that belongs to no run."""
    return Path("videos", f"{task.rpartition(':')[2]}_{agent}.mp4")


class ScriptedPlayer(Player):
    """Takes zero actions, or actions drawn uniformly from [-1, 1]."""

    def __init__(self, env: Any, agent: str):
        """Draw nothing yet.

        Args:
            env: a manager-based environment.
            agent: one of :data:`SCRIPTED`.
        """
        import torch

        inner = env.unwrapped
        self._env, self._is_random = env, agent == "random"
        self._actions = torch.zeros(inner.num_envs, inner.action_manager.total_action_dim, device=inner.device)
        # a generator of its own: the actions do not depend on what the environment draws
        self._random = torch.Generator(device=inner.device)
        self._random.manual_seed(inner.cfg.seed)

    def begin(self, say: Any) -> None:
        self._env.reset()

    def step(self) -> tuple[float, int]:
        import torch

        with torch.inference_mode():
            if self._is_random:
                self._actions.uniform_(-1.0, 1.0, generator=self._random)
            _, rewards, terminated, truncated, _ = self._env.step(self._actions.clone())
        return float(rewards.mean()), int((terminated | truncated).sum())
