"""Interface of a learning library for ``train`` and ``play``: a new library is one subclass of :class:`Library`.

The programs do what all libraries share: flags, settings, seed, run folder, films, the files in ``params``, signals and
closing lines.
"""

from __future__ import annotations

import abc
import argparse
import dataclasses
import importlib
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

from lift_lab.app.cli import Parser
from lift_lab.app.endings import number_of

from .arguments import positive

if TYPE_CHECKING:
    from rich.console import Console

    from lift_lab_rl.distributed import Place
    from lift_lab_tasks.settings import Settings

LIBRARIES = {
    "rsl_rl": "lift_lab_cli.rsl_rl_library:RslRl",
    "sb3": "lift_lab_cli.sb3_library:Sb3",
    "skrl": "lift_lab_cli.skrl_library:Skrl",
}
"""Libraries by name."""


@dataclasses.dataclass
class Run:
    """One training, as the program has prepared it."""

    args: argparse.Namespace
    settings: Settings
    folder: Path
    """Folder of the run."""
    checkpoint: Path | None
    """Result of :meth:`Library.find_start`."""
    fingerprint: Any
    """Everything in the settings that a result depends on."""
    place: Place
    """This process's place among those of the training."""
    console: Console


class Training(abc.ABC):
    """A training that is ready to run."""

    def begin(self, say: Callable[[str], None]) -> None:  # noqa: B027 - nothing to do is the rule
        """Load a checkpoint, or do other work before the first step.

        Args:
            say: shows a line to the user.
        """

    @abc.abstractmethod
    def learn(self) -> int | None:
        """Train. Returns the number of the signal that ended the training early; None if it is done."""

    @abc.abstractmethod
    def finish(self) -> str:
        """Save the policy. Returns how far the training came, and the file: ``after 3 iterations: model_3.pt``."""


class Player(abc.ABC):
    """A policy and the environment that it acts in."""

    def begin(self, say: Callable[[str], None]) -> None:  # noqa: B027 - nothing to do is the rule
        """Export the policy, or do other work before the first step.

        Args:
            say: shows a line to the user.
        """

    @abc.abstractmethod
    def step(self) -> tuple[float, int]:
        """Act once. Returns the environments' mean reward, and how many episodes ended."""

    def end(self, say: Callable[[str], None]) -> None:  # noqa: B027 - nothing to do is the rule
        """Print the library's summary of the episodes that ended.

        Args:
            say: shows a line to the user.
        """


class Library(abc.ABC):
    """A learning library. Methods that are not abstract fit a library whose configuration is a dictionary (a YAML
    file)."""

    name: ClassVar[str]
    """Short name: of the extra that installs it, of ``logs/NAME``, and of the key ``NAME_cfg_entry_point``."""
    package: ClassVar[str]
    """Python package that it needs."""
    training_help: ClassVar[str]
    """Description of ``train`` in one sentence."""
    playing_help: ClassVar[str]
    """Description of ``play`` in one sentence."""
    flag_settings: ClassVar[dict[str, tuple[str, ...]]] = {}
    """Entries of the agent's configuration that flags set, by the flag's name without dashes."""
    final_model: ClassVar[tuple[str, str]]
    """Regular expression of the file that ``play`` takes, and its name for users."""
    numbered_model: ClassVar[tuple[str, str]]
    """The same of the files that are saved on the way."""
    continues_runs: ClassVar[bool] = False
    """Whether a training can continue from the checkpoint of another run. ``params/run.yaml`` then names it."""
    models_folder: ClassVar[str] = ""
    """Folder of the models below that of the run."""

    # -- flags

    def add_training_flags(self, parser: Parser) -> None:
        """Add the flags of this library's trainings."""
        parser.add_argument("--max_iterations", type=positive, default=None, help="number of rollouts")
        parser.add_argument("--checkpoint", type=str, default=None, help="path of a model to start from")
        _add_trust(parser)

    def check_training_flags(self, parser: Parser, args: argparse.Namespace) -> None:
        """End with one line where flags do not go together."""
        if args.trust and args.checkpoint is None:
            parser.error("--trust says how a checkpoint is read: add --checkpoint")

    def add_playing_flags(self, parser: Parser) -> None:
        """Add the flags that say which policy is played."""
        numbered, final = self.numbered_model[1], self.final_model[1]
        parser.add_argument("--checkpoint", type=str, default=None, help="path, or regular expression of the file name")
        parser.add_argument(
            "--load_run", type=str, default=None, help="regular expression of the run (default: the newest)"
        )
        parser.add_argument(
            "--use_last_checkpoint", action="store_true", help=f"use the last {numbered} instead of {final}"
        )
        parser.add_argument("--use_pretrained_checkpoint", action="store_true", help=argparse.SUPPRESS)  # Isaac Lab's
        _add_trust(parser)

    def check_playing_flags(self, parser: Parser, args: argparse.Namespace) -> None:
        """End with one line where flags do not go together."""
        if args.use_pretrained_checkpoint:
            parser.error("--use_pretrained_checkpoint: the policies that ship are rsl_rl's; play them with rsl_rl")
        if args.use_last_checkpoint and args.checkpoint is not None:
            parser.error("--use_last_checkpoint and --checkpoint both name the model: give one")

    # -- settings

    def make_settings(self, args: argparse.Namespace, overrides: list[str], training: bool, place: Place) -> Settings:
        """Compose and resolve the settings, with those that only this library has.

        Args:
            args: flags.
            overrides: in hydra's grammar.
            training: whether a policy is trained, not played.
            place: this process's place among those of the training.

        Raises:
            LiftLabError: there is no such task or agent, or a setting is wrong.
        """
        from lift_lab.utils.errors import ConfigError
        from lift_lab_tasks.settings import Settings
        from lift_lab_tasks.utils.runs import check_run_names

        settings = Settings(args.task, args.agent, overrides, args.flag_settings)
        if not isinstance(settings.agent, dict):
            kind = type(settings.agent).__name__
            raise ConfigError(f"--agent {args.agent} is a {kind}: this library reads dictionaries")
        self.check_numbers(settings.agent)
        settings.resolve(training)
        if training and args.max_iterations is not None:
            settings.set("--max_iterations", *self.length(settings, args.max_iterations))
        check_run_names(args)
        return settings

    def check_numbers(self, cfg: dict[str, Any]) -> None:
        """Check the numbers of the agent's configuration; here, that none is NaN.

        Raises:
            ConfigError: a number is NaN or outside of its range; names it.
        """
        from lift_lab_rl.library_ranges import check_library_cfg

        check_library_cfg(cfg, ranges={}, needed="")

    def length(self, settings: Settings, iterations: int) -> tuple[str, Any]:
        """Entry of the configuration that says how long a training is, and its value for some iterations."""
        return "agent.max_iterations", iterations

    # -- runs

    def experiment(self, settings: Settings, args: argparse.Namespace) -> Path:
        """Folder of the runs."""
        from lift_lab_tasks.utils.runs import LOGS, pretrained_name

        return LOGS / self.name / (args.experiment_name or pretrained_name(settings.task))

    def new_folder(self, settings: Settings, args: argparse.Namespace) -> Path:
        """Make the folder of a run that starts now."""
        from lift_lab_tasks.utils.runs import make_run_dir

        return make_run_dir(self.experiment(settings, args), args.run_name)

    def find_start(self, settings: Settings, args: argparse.Namespace, place: Place) -> Path | None:
        """The checkpoint that a training starts from; None without one.

        Raises:
            LiftLabError: there is no such checkpoint, or it cannot be read.
        """
        from lift_lab_tasks.utils.runs import model_file

        if not args.checkpoint:
            return None
        path = model_file(args.checkpoint)
        self.check_model(path, args.trust)
        return path

    def check_model(self, path: Path, trust: bool) -> None:  # noqa: B027 - a library may check it later
        """Check that a model can be read, before anything is written.

        Args:
            path: the file.
            trust: whether code in it may run.
        """

    @abc.abstractmethod
    def training(self, env: Any, run: Run) -> Training:
        """A training in an environment, which this library wraps."""

    def find_policy(self, settings: Settings, args: argparse.Namespace) -> Path:
        """The checkpoint that is played.

        Raises:
            FileError: there is none.
        """
        from lift_lab_tasks.utils.runs import find_model

        models = [self.numbered_model] if args.use_last_checkpoint else [self.final_model, self.numbered_model]
        patterns = [pattern for pattern, _ in models]
        folder = self.experiment(settings, args)
        return find_model(folder, args.checkpoint, args.load_run, *patterns, folder=self.models_folder)

    def output_folder(self, settings: Settings, checkpoint: Path) -> Path:
        """Return the folder for files that belong to a checkpoint: the run's folder."""
        return checkpoint.parents[1] if self.models_folder else checkpoint.parent

    @abc.abstractmethod
    def player(self, env: Any, settings: Settings, args: argparse.Namespace, checkpoint: Path) -> Player:
        """A policy in an environment, which this library wraps."""

    def show(self, args: argparse.Namespace, overrides: list[str]) -> int | None:
        """Show a policy in another way than playing it; the exit status, or None if the flags ask for no other way."""
        return None


def find_library(name: str) -> Library:
    """A library by its name, or by ``module:Class``.

    Raises:
        NotFoundError: there is no such library.
    """
    if name in LIBRARIES:
        module, _, kind = LIBRARIES[name].partition(":")
        return getattr(importlib.import_module(module), kind)()
    from lift_lab.utils.errors import NotFoundError, suggest
    from lift_lab_tasks.utils.parse_cfg import import_user_module, resolve_entry_point

    if ":" not in name:
        raise NotFoundError(f"no library '{name}'; {suggest(name, [*LIBRARIES, 'module:Class'])}")
    import_user_module(name.partition(":")[0])
    return resolve_entry_point(name, f"library '{name}'")


def until_interrupted(train: Callable[[], Any]) -> int | None:
    """Train until it is done, or until Ctrl-C, SIGTERM or a lost terminal ends it; the signal's number, or None."""
    try:
        train()
    except KeyboardInterrupt as interrupt:
        return number_of(interrupt)
    return None


def _add_trust(parser: Parser) -> None:
    parser.add_argument(
        "--trust", action="store_true", help="read a checkpoint with pickled objects; this runs code in the file"
    )
