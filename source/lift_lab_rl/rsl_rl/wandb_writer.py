"""Curves, configuration, models and videos of a run on Weights & Biases, beside TensorBoard's files.

What W&B needs is looked at before a run starts. If it fails later, one line reports it, and the run continues with
TensorBoard's files only.
"""

from __future__ import annotations

import importlib
import importlib.util
import os
import sys
from pathlib import Path
from types import TracebackType
from typing import Any

import numpy as np
import torch
from rsl_rl.utils.log_writer import LogWriter

from lift_lab.utils.dict import class_to_dict, replace_slices_with_strings
from lift_lab.utils.errors import ConfigError, LiftLabError, MissingPackageError
from lift_lab_rl.scalar_names import SUCCESS_RATE

from .curve_files import CurveWriter

INIT_TIMEOUT_S = 30.0
"""Time in s that the start of a run waits for W&B's server; ``WANDB_INIT_TIMEOUT`` says otherwise."""


class LoggerError(LiftLabError, RuntimeError):
    """The service that curves were to go to cannot be used."""


def require_logger(name: str) -> None:
    """Check that curves can go where a configuration sends them, before anything is built.

    Args:
        name: ``agent.logger``.

    Raises:
        MissingPackageError: its package is not installed.
        ConfigError: the service does not exist any more.
    """
    if name == "neptune":
        raise ConfigError("agent.logger: neptune's service ended in March 2026; choose 'wandb' or 'tensorboard'")
    # a folder named wandb on the path is found too, without an origin
    if name == "wandb" and getattr(importlib.util.find_spec("wandb"), "origin", None) is None:
        raise MissingPackageError("--logger wandb needs a package: pip install 'lift-lab[wandb]'")


class WandbWriter(CurveWriter, LogWriter):
    """TensorBoard's writer that also sends to W&B, in one message per iteration.

    W&B's own files are in the run's folder, unless ``WANDB_DIR`` names another; the other variables that W&B reads
    (``WANDB_MODE``, ``WANDB_API_KEY``, ``WANDB_ENTITY``, ...) mean what W&B says. ``WANDB_USERNAME`` is the entity, as
    in Isaac Lab.
    """

    def __init__(self, log_dir: str, project_name: str):
        """Start a run that has the name of its folder.

        Args:
            log_dir: the run's folder.
            project_name: W&B's project.

        Raises:
            MissingPackageError: wandb is not installed.
            LoggerError: W&B does not start a run: no key, no network, ...
        """
        require_logger("wandb")
        self._wandb: Any = importlib.import_module("wandb")
        self._scalars: dict[str, float] = {}
        self._step: int | None = None
        self._sent: set[str] = set()
        self.problem: str | None = None
        """Why nothing is sent any more."""
        settings: dict[str, Any] = {"console": "off"}  # a live panel would be sent whole, four times a second
        if "WANDB_INIT_TIMEOUT" not in os.environ:
            settings["init_timeout"] = INIT_TIMEOUT_S
        with _Guard(self, starting=True):
            self._run = self._wandb.init(
                project=project_name,
                entity=os.environ.get("WANDB_USERNAME"),
                name=Path(log_dir).name,
                dir=None if "WANDB_DIR" in os.environ else log_dir,
                config={"log_dir": log_dir},
                settings=self._wandb.Settings(**settings),
            )
            # the run's summary has the best and the last success rate, not the last alone
            self._run.define_metric(SUCCESS_RATE, summary="last,max")
        super().__init__(log_dir)

    def add_scalar(
        self,
        tag: str,
        scalar_value: Any,
        global_step: int | None = None,
        walltime: float | None = None,
        new_style: bool = False,
        double_precision: bool = False,
    ) -> None:
        """Add one value; W&B gets it with the others of its step at the next :meth:`flush`."""
        super().add_scalar(tag, scalar_value, global_step, walltime, new_style, double_precision)
        self._scalars[tag] = float(scalar_value)
        self._step = global_step

    def flush(self) -> None:
        """Write TensorBoard's events to the disk, and hand the values since the last call to W&B."""
        super().flush()
        values, self._scalars = self._scalars, {}
        if values and self.problem is None:
            with _Guard(self):
                self._run.log(values, step=self._step, commit=True)

    def store_config(self, env_cfg: dict | object, train_cfg: dict) -> None:
        """Send both configurations."""
        with _Guard(self):
            self._run.config.update({"env_cfg": _plain(env_cfg), "train_cfg": _plain(train_cfg)})

    def save_model(self, model_path: str, it: int) -> None:
        """Send a checkpoint."""
        self.save_file(model_path)

    def save_file(self, path: str) -> None:
        """Send any file."""
        if self.problem is None:
            with _Guard(self):
                self._run.save(path, base_path=os.path.dirname(path), policy="now")

    def save_video(self, video: Path, it: int) -> None:
        """Send a video, once, with the next step's values."""
        if self.problem is None and str(video) not in self._sent:
            self._sent.add(str(video))
            with _Guard(self):
                self._run.log({"video": self._wandb.Video(str(video), format="mp4")}, step=it, commit=False)

    def stop(self) -> None:
        """Send the remaining values and end W&B's run. Ctrl-C does not wait for it."""
        self.flush()
        if self.problem is None:
            with _Guard(self):
                self._run.finish()

    def give_up(self, problem: str) -> None:
        """Send nothing from now on."""
        self.problem = problem
        print(f"warning: wandb: {problem}; curves go on in TensorBoard's files alone", file=sys.stderr)


class _Guard:
    """Errors of W&B and of its connection end W&B's part of the run, not the run."""

    def __init__(self, writer: WandbWriter, starting: bool = False):
        self._writer, self._starting = writer, starting

    def __enter__(self) -> None:
        pass

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, _: TracebackType | None) -> bool:
        if kind is None or error is None:
            return False
        if issubclass(kind, KeyboardInterrupt) and not self._starting:
            self._writer.give_up("interrupted; 'wandb sync' sends the rest")
            return True
        if not (issubclass(kind, OSError) or kind.__module__.partition(".")[0] == "wandb"):
            return False
        reason = next(iter(str(error).strip().splitlines()), kind.__name__).rstrip(".")
        if self._starting:
            raise LoggerError(
                f"--logger wandb: {reason}. WANDB_MODE=offline keeps the curves for 'wandb sync'; "
                "--logger tensorboard needs neither key nor network"
            ) from error
        self._writer.give_up(reason)
        return True


def _plain(cfg: Any) -> Any:
    """A configuration as dictionaries, lists, numbers and text."""
    return _values(replace_slices_with_strings(class_to_dict(cfg)))


def _values(value: Any) -> Any:
    if isinstance(value, dict):
        return {str(key): _values(entry) for key, entry in value.items()}
    if isinstance(value, list | tuple | set):
        return [_values(entry) for entry in value]
    if isinstance(value, torch.Tensor | np.ndarray | np.generic):
        return value.tolist()
    return value if value is None or isinstance(value, str | int | float | bool) else str(value)
