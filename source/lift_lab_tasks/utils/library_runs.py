"""Run folders, checkpoints and flags of the learning libraries whose configuration is a dictionary (skrl, sb3)."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from lift_lab.utils.errors import ConfigError, FileError
from lift_lab_rl.library_ranges import check_library_cfg

from .parse_cfg import get_checkpoint_path, names_path
from .runs import apply_flags, check_given_once, check_run_names


def task_folder(task: str) -> str:
    """Name of the folder of a task's runs: its id; a task and its ``-Play`` share one."""
    return task.rpartition(":")[2].removesuffix("-Play")


def model_file(path: str) -> Path:
    """An existing checkpoint's path.

    Raises:
        FileError: there is no such file.
    """
    if not Path(path).is_file():
        raise FileError(f"no checkpoint '{path}'")
    return Path(path).absolute()


def find_model(parent: Path, wanted: str | None, run: str | None, *patterns: str, folder: str = "") -> Path:
    """The checkpoint that a user means.

    Args:
        parent: folder of the experiment's runs.
        wanted: path of a file; a regular expression of file names; None for what matches ``patterns``.
        run: regular expression of the run's folder name; None for all.
        *patterns: regular expressions of file names; of the newest run that has any, the first that it has is taken.
        folder: folder between a run and its checkpoints.

    Raises:
        FileError: there is none.
    """
    if wanted is not None:
        if Path(wanted).is_file() or Path(wanted).parent != Path("."):
            return model_file(wanted)
        patterns = (wanted,)
    others = [folder] if folder else None
    any_of_them = "|".join(f"(?:{pattern})" for pattern in patterns)
    newest = Path(get_checkpoint_path(parent.absolute(), run or ".*", any_of_them, others)).parent
    newest = newest.parent if folder else newest
    for pattern in patterns[:-1]:
        try:
            return Path(get_checkpoint_path(newest.parent, re.escape(newest.name), pattern, others))
        except FileError:
            continue
    return Path(get_checkpoint_path(newest.parent, re.escape(newest.name), patterns[-1], others))


def apply_dict_flags(
    env_cfg: Any, agent_cfg: dict, args: Any, task: str, overrides: Sequence[str], training: bool = False
) -> None:
    """Write the flags that all scripts share into the configurations; the agent's is a dictionary with a ``seed``.

    Args:
        env_cfg: environment configuration.
        agent_cfg: agent configuration.
        args: flags, see :func:`~lift_lab_tasks.utils.runs.apply_flags`.
        task: id of the task.
        overrides: overrides that were applied.
        training: whether a policy is trained, not shown.

    Raises:
        ConfigError: the agent's configuration is not a dictionary, a flag and an override differ, or a setting is
            outside of its range.
    """
    if not isinstance(agent_cfg, dict):
        raise ConfigError(f"--agent {args.agent} is a {type(agent_cfg).__name__}: this library reads dictionaries")
    check_given_once(env_cfg, agent_cfg, args, overrides)
    apply_flags(env_cfg, None, args, task, overrides, training)
    if args.seed is not None or names_path(overrides, "env.seed"):
        agent_cfg["seed"] = env_cfg.seed
    elif agent_cfg.get("seed") is not None:
        env_cfg.seed = agent_cfg["seed"]
    check_library_cfg(agent_cfg)
    check_run_names(args)
