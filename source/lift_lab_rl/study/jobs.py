"""What a study consists of: variants of a task, each trained with several seeds, and what of it is done already."""

from __future__ import annotations

import json
import re
import shlex
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from lift_lab.utils.errors import ConfigError

_TIME = r"\d{4}-\d\d-\d\d_\d\d-\d\d-\d\d_"
"""Start of the name of a run's folder."""


@dataclass(frozen=True)
class Variant:
    """One way to train."""

    label: str
    task: str
    overrides: tuple[str, ...] = ()

    @classmethod
    def parse(cls, text: str) -> Variant:
        """``"[LABEL=]TASK [override ...]"``, e.g. ``"linear=Lift-Cube-Franka-CL env/curriculum=linear"``.

        Raises:
            ConfigError: no task, or a label that cannot be part of a folder's name.
        """
        words = shlex.split(text)
        label, equals, task = words[0].partition("=") if words else ("", "", "")
        if not equals:
            task = label
        if not task or not re.fullmatch(r"[\w.:+-]+", label):
            raise ConfigError(
                f"'{text}': expected TASK, or 'LABEL=TASK override ...' with a label of letters and digits"
            )
        return cls(label.replace(":", "-"), task, tuple(words[1:]))


@dataclass
class Job:
    """One training of a study, with its evaluations."""

    variant: Variant
    seed: int
    record: dict[str, Any] = field(default_factory=dict)
    """Its entry in the results."""

    @property
    def name(self) -> str:
        """The run's name: reports read label and seed from it."""
        return f"{self.variant.label}-s{self.seed}"


def make_jobs(variants: Sequence[Variant], seeds: Sequence[int]) -> list[Job]:
    """All seeds of all variants, seed by seed, so that an early look compares variants.

    Raises:
        ConfigError: a label or a seed is given twice.
    """
    for what, names in (("label", [variant.label for variant in variants]), ("seed", [str(seed) for seed in seeds])):
        twice = next((name for name in names if names.count(name) > 1), None)
        if twice is not None:
            raise ConfigError(f"the {what} '{twice}' is given twice")
    return [Job(variant, seed) for seed in seeds for variant in variants]


def newest_checkpoint(folder: Path, run_name: str) -> tuple[Path, int] | None:
    """The checkpoint with most iterations among a run's pieces, and its iterations; None without one."""
    found = []
    for piece in folder.iterdir() if folder.is_dir() else ():
        if re.fullmatch(rf"{_TIME}{re.escape(run_name)}(-\d+)?", piece.name):
            for path in piece.glob("model_*.pt"):
                digits = path.stem.removeprefix("model_")
                if digits.isdigit():
                    found.append((int(digits), piece.name, path))
    if not found:
        return None
    iterations, _, path = max(found, key=lambda entry: entry[:2])
    return path, iterations


def read_evaluation(path: Path, checkpoint: Path, episodes: int, seed: int) -> dict[str, Any] | None:
    """An evaluation that was done before; None if there is none of this checkpoint, length and seed."""
    if not path.is_file():
        return None
    content = json.loads(path.read_text(encoding="utf-8"))
    same = (content["checkpoint"], content["episodes"], content["seed"]) == (str(checkpoint), episodes, seed)
    return content if same else None


def check_settings(old: dict[str, Any], new: dict[str, Any], path: Path) -> None:
    """Refuse to mix trainings of other settings into a study.

    Args:
        old: settings in the results file.
        new: settings now. ``variants`` may grow, but none may change.
        path: the results file.

    Raises:
        ConfigError: they differ; names the first that does.
    """
    for key, value in new.items():
        if key == "variants":
            changed = [label for label in value if label in old.get(key, {}) and old[key][label] != value[label]]
            if changed:
                raise ConfigError(f"'{path}' has other settings for '{changed[0]}': take another --name or label")
        elif key in old and old[key] != value:
            raise ConfigError(f"'{path}' was made with {key} {old[key]}, not {value}: take another --name")
