"""rsl_rl's PPO as ``train`` and ``play`` use it."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from lift_lab.app.cli import Parser

from .arguments import add_checkpoint_flags, check_checkpoint_flags, positive
from .library import Library, Player, Run, Training
from .scripted import SCRIPTED

if TYPE_CHECKING:
    from lift_lab_rl.distributed import Place
    from lift_lab_tasks.settings import Settings


class RslRl(Library):
    """rsl_rl's PPO. Its configuration is a class.

    ``train`` writes ``logs/rsl_rl/<experiment>/<time>[_name]/`` with ``model_N.pt`` (after N iterations),
    ``model_best.pt``, TensorBoard's event files, and ``params/`` with the configurations. Ctrl-C, SIGTERM and a lost
    terminal finish the iteration, save and end with status 128 plus the signal's number. ``--resume`` continues a run;
    ``max_iterations`` counts the iterations of both. Several processes:
    ``torchrun --nproc_per_node=2 -m lift_lab_cli train --distributed ...`` (docs/scaling.md).

    By default ``play`` takes the newest checkpoint of the newest run. It writes ``exported/policy.pt`` (TorchScript)
    and ``exported/policy.onnx`` beside it, both checked against the policy.
    """

    name, package = "rsl_rl", "rsl_rl"
    training_help = "Train a policy with rsl_rl's PPO."
    playing_help = "Run a trained policy: film it, show it in a browser, export it."
    continues_runs = True
    flag_settings = {
        name: (f"agent.{name}",) for name in ("experiment_name", "run_name", "max_iterations", "load_run", "logger")
    }

    def add_training_flags(self, parser: Parser) -> None:
        parser.add_argument(
            "--max_iterations", type=positive, default=None, help="iterations of the whole run, at most"
        )
        parser.add_argument(
            "--no_evaluation",
            action="store_true",
            help="train for all iterations: no evaluation during the training, which may end it (agent.evaluation)",
        )
        parser.add_argument("--resume", action="store_true", help="continue an earlier run (default: the newest)")
        parser.add_argument("--load_run", type=str, default=None, help="regular expression of the run to continue")
        parser.add_argument(
            "--checkpoint", type=str, default=None, help="checkpoint to continue: path, latest, best, or a file name"
        )
        loggers = ["tensorboard", "wandb", "neptune"]
        parser.add_argument("--logger", choices=loggers, default=None, help="destination of the curves")
        parser.add_argument("--log_project_name", type=str, default=None, help="project name for wandb")
        parser.add_argument("--distributed", action="store_true", help="train with the other processes of torchrun")

    def check_training_flags(self, parser: Parser, args: argparse.Namespace) -> None:
        pass

    def add_playing_flags(self, parser: Parser) -> None:
        from .watch import add_watching_flags

        add_checkpoint_flags(parser)
        add_watching_flags(parser)

    def check_playing_flags(self, parser: Parser, args: argparse.Namespace) -> None:
        from .watch import check_watching_flags

        check_checkpoint_flags(parser, args)
        check_watching_flags(parser, args)

    # -- settings

    def make_settings(self, args: argparse.Namespace, overrides: list[str], training: bool, place: Place) -> Settings:
        from lift_lab.utils.errors import ConfigError
        from lift_lab_rl.rsl_rl.wandb_writer import require_logger
        from lift_lab_tasks.settings import Settings

        check_agent(args)
        settings = Settings(args.task, args.agent, overrides, args.flag_settings)
        agent = settings.agent
        if training:
            require_logger(agent.logger)
            if args.no_evaluation:
                if settings.given("agent.evaluation", below=True):
                    raise ConfigError("--no_evaluation and agent.evaluation contradict each other: give one of them")
                agent.evaluation = None
            if args.log_project_name is not None:
                if agent.logger == "tensorboard":
                    raise ConfigError("--log_project_name needs --logger wandb")
                settings.set("--log_project_name", f"agent.{agent.logger}_project", args.log_project_name)
        if place.is_distributed:
            for cfg in (settings.env.sim, agent):
                cfg.num_threads = place.num_threads() if cfg.num_threads is None else cfg.num_threads
        settings.resolve(training)
        settings.env.sim.device, agent.device = place.device(settings.env.sim.device), place.device(agent.device)
        return settings

    # -- runs

    def new_folder(self, settings: Settings, args: argparse.Namespace) -> Path:
        from lift_lab_tasks.utils.runs import new_run_dir

        return new_run_dir(settings.agent)

    def find_start(self, settings: Settings, args: argparse.Namespace, place: Place) -> Path | None:
        from lift_lab.utils.errors import ConfigError
        from lift_lab_rl.rsl_rl.run_files import checkpoint_iteration, is_solved
        from lift_lab_tasks.utils.runs import find_checkpoint

        def warn(text: str) -> None:
            if place.is_main:
                print(text, file=sys.stderr)

        agent = settings.agent
        if not (args.resume or agent.resume):
            if args.checkpoint or args.load_run:
                raise ConfigError("--checkpoint and --load_run continue a run: add --resume")
            return None
        wanted = args.checkpoint or agent.load_checkpoint
        checkpoint = find_checkpoint(agent, wanted, agent.load_run, settings.task, True, warn)
        if is_solved(checkpoint, agent.evaluation):
            raise ConfigError(
                f"'{checkpoint}' is of a training that ended because the task is solved; "
                f"train on with --no_evaluation, or with other values of agent.evaluation"
            )
        done = checkpoint_iteration(checkpoint)
        if done >= agent.max_iterations:
            raise ConfigError(
                f"'{checkpoint}' has finished {done} of {agent.max_iterations} iterations; "
                f"ask for more with --max_iterations"
            )
        return checkpoint

    def training(self, env: Any, run: Run) -> Training:
        return _Training(env, run)

    def find_policy(self, settings: Settings, args: argparse.Namespace) -> Path:
        return find_policy(settings, args)

    def output_folder(self, settings: Settings, checkpoint: Path) -> Path:
        from lift_lab_tasks.utils.runs import output_dir

        return output_dir(settings.agent, checkpoint)

    def player(self, env: Any, settings: Settings, args: argparse.Namespace, checkpoint: Path) -> Player:
        return _Player(env, settings, checkpoint, self.output_folder(settings, checkpoint) / "exported")

    def show(self, args: argparse.Namespace, overrides: list[str]) -> int | None:
        if args.viewer or args.replay is not None:
            from .watch import watch

            return watch(args, overrides)
        return None


def check_agent(args: argparse.Namespace) -> None:
    """Check that rsl_rl can use the agent's configuration.

    Args:
        args: flags ``task`` and ``agent``; with ``replay``, which is ``play``'s, scripted agents count, too.

    Raises:
        NotFoundError: no such task, or the agent is none of its agents for rsl_rl.
    """
    from lift_lab.utils.errors import NotFoundError, suggest
    from lift_lab_tasks.utils import task_kwargs
    from lift_lab_tasks.utils.parse_cfg import ENV_CFG

    entries = task_kwargs(args.task)
    other = [key for key, entry in entries.items() if key == ENV_CFG or str(entry).endswith(".yaml")]
    usable = [key for key in entries if key.endswith("_entry_point") and key not in other]
    usable += SCRIPTED if hasattr(args, "replay") else ()
    if args.agent not in usable:
        raise NotFoundError(f"task '{args.task}' has no '{args.agent}' for rsl_rl; {suggest(args.agent, usable)}")


def find_policy(settings: Settings, args: argparse.Namespace) -> Path:
    """Return the checkpoint that a user names; logs a line if it is of another task.

    Raises:
        FileError: there is none.
    """
    from lift_lab_tasks.utils.runs import find_checkpoint, note_other_task

    agent = settings.agent
    checkpoint = find_checkpoint(agent, args.checkpoint or agent.load_checkpoint, agent.load_run, settings.task)
    note_other_task(checkpoint, settings.task)
    return checkpoint


def make_runner(env: Any, agent: Any, *more: Any) -> tuple[Any, Any]:
    """The environment in rsl_rl's wrapper, and a runner of it.

    Args:
        env: the environment.
        agent: the agent's configuration.
        *more: further arguments of :class:`~lift_lab_rl.rsl_rl.LiftLabRunner`: folder, device, ...
    """
    from lift_lab_rl.rsl_rl import LiftLabRunner, RslRlVecEnvWrapper, to_rsl_rl

    wrapped = RslRlVecEnvWrapper(env, clip_actions=agent.clip_actions)
    folder, *others = more or (None,)
    cfg = to_rsl_rl(agent, wrapped.get_observations().keys())
    return wrapped, LiftLabRunner(wrapped, cfg, folder, agent.device, *others)


class _Training(Training):
    def __init__(self, env: Any, run: Run):
        self.run = run
        _, self.runner = make_runner(env, run.settings.agent, run.folder, run.fingerprint, run.place)

    def begin(self, say: Callable[[str], None]) -> None:
        from lift_lab.utils.errors import ConfigError
        from lift_lab_tasks.utils.runs import note_annealing, note_other_task

        checkpoint, settings = self.run.checkpoint, self.run.settings
        note_annealing(settings.agent, settings.given, say)
        too_short = None if self.runner.evaluation is None else self.runner.evaluation.too_short()
        if too_short is not None and settings.given("agent.evaluation", below=True):
            raise ConfigError(too_short)
        if too_short is not None:
            say(too_short)
        if checkpoint is not None:
            note_other_task(checkpoint, settings.task, say)
            self.runner.load(str(checkpoint))
            say(f"resuming {checkpoint}: {self.runner.load_resume_state(checkpoint)}")

    def learn(self) -> int | None:
        from lift_lab_rl.rsl_rl.progress import Progress

        run, runner = self.run, self.runner
        title = f"{run.settings.task} {run.folder.name}"
        progress = Progress(title, run.console) if run.place.is_main else None
        left = run.settings.agent.max_iterations - runner.current_learning_iteration
        runner.learn(left, init_at_random_ep_len=True, progress=progress)
        return runner.stopped_by

    def finish(self) -> str:
        done = self.runner.current_learning_iteration
        solved = ", the task is solved" if self.runner.solved else ""
        return f"after {done} iterations{solved}: {self.run.folder / f'model_{done}.pt'}"


class _Player(Player):
    def __init__(self, env: Any, settings: Settings, checkpoint: Path, exported: Path):
        self.env, self.runner = make_runner(env, settings.agent)
        self.runner.load_policy(str(checkpoint))
        self.policy = self.runner.get_inference_policy(device=settings.agent.device)
        self.exported, self.checkpoint = exported, checkpoint
        self.logs: dict[str, list[tuple[float, int]]] = {}

    def begin(self, say: Callable[[str], None]) -> None:
        from lift_lab.utils.errors import PhysicsError
        from lift_lab_rl.rsl_rl import export_policy_as_jit, export_policy_as_onnx

        network = self.runner.alg.get_policy()
        metadata = self.runner.policy_metadata(self.checkpoint)
        say(f"exported: {export_policy_as_jit(network, None, self.exported, metadata=metadata)}")
        say(f"exported: {export_policy_as_onnx(network, self.exported, metadata=metadata)}")
        try:
            say(f"exported: {self.env.unwrapped.sim.export_mjcf(self.exported / 'scene.xml')[0]}")
        except PhysicsError as error:  # the policy plays all the same
            say(f"not exported: scene.xml: {error}")
        self.obs, _ = self.env.reset()

    def step(self) -> tuple[float, int]:
        import torch

        from lift_lab_rl.nonfinite import check_step

        with torch.inference_mode():
            self.obs, rewards, dones, extras = self.env.step(self.policy(self.obs).to(self.env.device))
            check_step(self.env, self.obs, rewards, extras)
            self.policy.reset(dones)
        ended = int(dones.sum())
        if ended:
            for key, value in extras["log"].items():
                self.logs.setdefault(key, []).append((float(value), ended))
        return float(rewards.mean()), ended

    def end(self, say: Callable[[str], None]) -> None:
        for key, values in self.logs.items():
            mean = sum(value * weight for value, weight in values) / sum(weight for _, weight in values)
            say(f"{key}: {mean:.4f}")
