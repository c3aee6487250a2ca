"""skrl as ``train`` and ``play`` use it."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any

from lift_lab.app.cli import Parser

from .library import Library, Player, Run, Training, until_interrupted

if TYPE_CHECKING:
    from lift_lab_rl.distributed import Place
    from lift_lab_tasks.settings import Settings


class Skrl(Library):
    """skrl's runner.

    ``train`` writes ``logs/skrl/<task>/<time>_ppo_torch[_name]/`` with ``checkpoints/agent_N.pt`` (after N environment
    steps) and ``best_agent.pt``, TensorBoard's event files, and ``params/`` with the configurations. Ctrl-C saves and
    ends. ``--checkpoint`` starts from the weights of an earlier agent. ``play`` takes ``best_agent.pt`` of the newest
    run of the task, without ``-Play``.
    """

    name, package = "skrl", "skrl"
    training_help = "Train a policy with skrl."
    playing_help = "Run a policy that skrl trained."
    final_model, numbered_model = (r"best_agent\.pt", "best_agent.pt"), (r"agent_\d+\.pt", "agent_N.pt")
    models_folder = "checkpoints"
    flag_settings = {
        "experiment_name": ("agent.agent.experiment.directory",),
        "run_name": ("agent.agent.experiment.experiment_name",),
    }

    def add_training_flags(self, parser: Parser) -> None:
        super().add_training_flags(parser)
        _add_isaac_flags(parser)

    def check_training_flags(self, parser: Parser, args: argparse.Namespace) -> None:
        super().check_training_flags(parser, args)
        _check_isaac_flags(parser, args)

    def add_playing_flags(self, parser: Parser) -> None:
        super().add_playing_flags(parser)
        _add_isaac_flags(parser)

    def check_playing_flags(self, parser: Parser, args: argparse.Namespace) -> None:
        super().check_playing_flags(parser, args)
        _check_isaac_flags(parser, args)

    def make_settings(self, args: argparse.Namespace, overrides: list[str], training: bool, place: Place) -> Settings:
        settings = super().make_settings(args, overrides, training, place)
        settings.agent["trainer"]["close_environment_at_exit"] = False
        if not training:
            settings.agent["agent"]["experiment"] |= {"write_interval": 0, "checkpoint_interval": 0}
        return settings

    def check_numbers(self, cfg: dict[str, Any]) -> None:
        from lift_lab_rl.library_ranges import SKRL_NEEDED, SKRL_RANGES, check_library_cfg

        check_library_cfg(cfg, SKRL_RANGES, SKRL_NEEDED)

    def length(self, settings: Settings, iterations: int) -> tuple[str, Any]:
        return "agent.trainer.timesteps", iterations * settings.agent["agent"]["rollouts"]

    def experiment(self, settings: Settings, args: argparse.Namespace) -> Path:
        from lift_lab_tasks.utils.runs import LOGS

        directory = settings.agent["agent"]["experiment"]["directory"]
        return LOGS / self.name / directory if directory else super().experiment(settings, args)

    def new_folder(self, settings: Settings, args: argparse.Namespace) -> Path:
        from lift_lab_tasks.utils.runs import check_run_names, make_run_dir

        agent = settings.agent["agent"]
        experiment = agent["experiment"]
        check_run_names(
            argparse.Namespace(experiment_name=experiment["directory"] or None, run_name=experiment["experiment_name"])
        )
        parent = self.experiment(settings, args)
        folder = make_run_dir(parent, agent["class"].lower(), "torch", experiment["experiment_name"])
        experiment["directory"], experiment["experiment_name"] = str(folder.parent), folder.name
        return folder

    def check_model(self, path: Path, trust: bool) -> None:
        from lift_lab_rl.library_files import read_skrl

        read_skrl(path, trust)

    def training(self, env: Any, run: Run) -> Training:
        return _Training(env, run)

    def player(self, env: Any, settings: Settings, args: argparse.Namespace, checkpoint: Path) -> Player:
        return _Player(env, settings, args, checkpoint)


def _add_isaac_flags(parser: Parser) -> None:
    """Add the flags of Isaac Lab's skrl scripts: their defaults are what there is."""
    parser.add_argument("--ml_framework", default="torch", help=argparse.SUPPRESS)
    parser.add_argument("--algorithm", default="PPO", help=argparse.SUPPRESS)


def _check_isaac_flags(parser: Parser, args: argparse.Namespace) -> None:
    if args.ml_framework != "torch":
        parser.error(f"--ml_framework {args.ml_framework}: skrl runs on torch here")
    if args.algorithm.upper() != "PPO":
        parser.error(f"--algorithm {args.algorithm}: the tasks have configurations of PPO; give another with --agent")


class _Training(Training):
    def __init__(self, env: Any, run: Run):
        from lift_lab_rl.library_ranges import check_skrl_mini_batches
        from lift_lab_rl.skrl import SkrlVecEnvWrapper
        from lift_lab_rl.skrl_runs import load_agent, make_runner

        check_skrl_mini_batches(run.settings.agent, run.settings.env.scene.num_envs)
        self.env, self.folder = env.unwrapped, run.folder
        self.runner = make_runner(SkrlVecEnvWrapper(env), run.settings.agent)
        if run.checkpoint is not None:
            load_agent(self.runner.agent, run.checkpoint, run.args.trust)

    def learn(self) -> int | None:
        return until_interrupted(self.runner.run)

    def finish(self) -> str:
        steps = self.env.common_step_counter
        path = self.folder / Skrl.models_folder / f"agent_{steps}.pt"
        path.parent.mkdir(exist_ok=True)
        self.runner.agent.save(str(path))
        return f"after {steps} environment steps: {path}"


class _Player(Player):
    def __init__(self, env: Any, settings: Settings, args: argparse.Namespace, checkpoint: Path):
        from lift_lab_rl.skrl import SkrlVecEnvWrapper
        from lift_lab_rl.skrl_runs import load_agent, make_runner

        self.env = SkrlVecEnvWrapper(env)
        self.agent: Any = make_runner(self.env, settings.agent).agent
        load_agent(self.agent, checkpoint, args.trust)
        self.agent.enable_training_mode(False, apply_to_models=True)
        self.timestep, self.timesteps = 0, args.steps or env.unwrapped.max_episode_length

    def begin(self, say: Any) -> None:
        self.obs, _ = self.env.reset()

    def step(self) -> tuple[float, int]:
        import torch

        with torch.inference_mode():
            time = {"timestep": self.timestep, "timesteps": self.timesteps}
            actions, outputs = self.agent.act(self.obs, self.env.state(), **time)
            actions = outputs.get("mean_actions", actions)
            self.obs, rewards, terminated, truncated, _ = self.env.step(actions)
        self.timestep += 1
        return float(rewards.mean()), int((terminated | truncated).sum())
