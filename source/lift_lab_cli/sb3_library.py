"""Stable-Baselines3's PPO as ``train`` and ``play`` use it."""

from __future__ import annotations

import argparse
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from lift_lab.app.cli import Parser

from .arguments import positive
from .library import Library, Player, Run, Training, until_interrupted

if TYPE_CHECKING:
    from lift_lab_tasks.settings import Settings


class Sb3(Library):
    """Stable-Baselines3's PPO.

    ``train`` writes ``logs/sb3/<task>/<time>/`` with ``model.zip`` at the end, ``model_N_steps.zip`` on the way,
    TensorBoard's event files, and ``params/`` with the configurations. Ctrl-C saves and ends. ``--checkpoint`` starts
    from the weights of an earlier model. ``play`` takes ``model.zip`` of the newest run of the task, without ``-Play``.
    """

    name, package = "sb3", "stable_baselines3"
    training_help = "Train a policy with Stable-Baselines3's PPO."
    playing_help = "Run a policy that Stable-Baselines3 trained."
    final_model, numbered_model = (r"model\.zip", "model.zip"), (r"model_\d+_steps\.zip", "model_N_steps.zip")

    def add_training_flags(self, parser: Parser) -> None:
        super().add_training_flags(parser)
        parser.add_argument(
            "--log_interval", type=positive, default=1, help="rollouts between two lines of the log (default: 1)"
        )
        parser.add_argument(
            "--save_interval", type=positive, default=1000, help="environment steps between two models (default: 1000)"
        )
        parser.add_argument("--keep_all_info", action="store_true", help="put the environment's log into the infos")

    def check_numbers(self, cfg: dict[str, Any]) -> None:
        from lift_lab_rl.library_ranges import SB3_NEEDED, SB3_RANGES, check_library_cfg

        check_library_cfg(cfg, SB3_RANGES, SB3_NEEDED)

    def length(self, settings: Settings, iterations: int) -> tuple[str, Any]:
        return "agent.n_timesteps", iterations * settings.agent["n_steps"] * settings.env.scene.num_envs

    def check_model(self, path: Path, trust: bool) -> None:
        from lift_lab_rl.library_files import read_sb3

        read_sb3(path, trust)

    def training(self, env: Any, run: Run) -> Training:
        return _Training(env, run)

    def player(self, env: Any, settings: Settings, args: argparse.Namespace, checkpoint: Path) -> Player:
        return _Player(env, settings, args, checkpoint)


class _Training(Training):
    def __init__(self, env: Any, run: Run):
        from lift_lab_rl.sb3 import Sb3VecEnvWrapper
        from lift_lab_rl.sb3_runs import build

        wrapped = Sb3VecEnvWrapper(env, fast_variant=not run.args.keep_all_info)
        self.run = run
        self.agent, self.env, self.timesteps = build(wrapped, run.settings.agent, run.checkpoint, trust=run.args.trust)

    def learn(self) -> int | None:
        from lift_lab_rl.sb3 import LogCallback
        from lift_lab_rl.sb3_runs import SaveCallback, log_to

        args = self.run.args
        log_to(self.agent, self.run.folder)
        callbacks = [SaveCallback(args.save_interval, self.run.folder), LogCallback()]
        return until_interrupted(
            partial(self.agent.learn, self.timesteps, callback=callbacks, log_interval=args.log_interval)
        )

    def finish(self) -> str:
        from lift_lab_rl.sb3_runs import save

        path = self.run.folder / "model.zip"
        save(self.agent, self.env, path)
        return f"after {self.agent.num_timesteps} samples: {path}"


class _Player(Player):
    def __init__(self, env: Any, settings: Settings, args: argparse.Namespace, checkpoint: Path):
        from lift_lab_rl.sb3 import Sb3VecEnvWrapper
        from lift_lab_rl.sb3_runs import build

        wrapped = Sb3VecEnvWrapper(env)
        self.agent, vec_env, _ = build(wrapped, settings.agent, checkpoint, training=False, trust=args.trust)
        self.env: Any = vec_env
        self.returns: list[float] = []

    def begin(self, say: Any) -> None:
        self.obs = self.env.reset()

    def step(self) -> tuple[float, int]:
        actions, _ = self.agent.predict(self.obs, deterministic=True)
        self.obs, rewards, dones, infos = self.env.step(actions)
        self.returns += [infos[idx]["episode"]["r"] for idx in dones.nonzero()[0]]
        return float(rewards.mean()), int(dones.sum())

    def end(self, say: Any) -> None:
        if self.returns:
            say(f"mean return of an episode: {sum(self.returns) / len(self.returns):.3f}")
