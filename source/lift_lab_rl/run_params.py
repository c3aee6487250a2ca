"""The files in the folder ``params`` of a run: its configurations, its task and its overrides."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import yaml

from lift_lab.utils.errors import FileError
from lift_lab.utils.io import dump_yaml, load_yaml


def write_params(
    run_dir: Path,
    task: str,
    env_cfg: Any,
    agent_cfg: Any,
    overrides: Sequence[str],
    continues: Path | None = None,
) -> None:
    """Write the settings of a run.

    Args:
        run_dir: folder of the run.
        task: the task's name.
        env_cfg: the environment's configuration.
        agent_cfg: the agent's.
        overrides: overrides of the command line.
        continues: checkpoint of another run from which this one continues. Kept as folder and file name, so that runs
            may be moved together.
    """
    dump_yaml(run_dir / "params" / "env.yaml", env_cfg)
    dump_yaml(run_dir / "params" / "agent.yaml", agent_cfg)
    origin = {} if continues is None else {"continues": f"{continues.parent.name}/{continues.name}"}
    dump_yaml(run_dir / "params" / "run.yaml", {"task": task, "overrides": list(overrides), **origin})


def read_params(run_dir: Path, name: str) -> dict[str, Any]:
    """Content of one of the files that :func:`write_params` writes.

    Args:
        run_dir: folder of the run.
        name: ``env``, ``agent`` or ``run``.

    Returns:
        What the file holds; empty where there is none.

    Raises:
        FileError: the file holds no settings, or an entry of another type.
    """
    path = run_dir / "params" / f"{name}.yaml"
    if not path.is_file():
        return {}
    try:
        content = load_yaml(path)
    except (yaml.YAMLError, UnicodeDecodeError) as error:
        raise FileError(f"cannot read '{path}': {' '.join(str(error).split())}") from error
    if not isinstance(content, dict):
        raise FileError(f"cannot read '{path}': it holds no settings")
    for key, (fits, wanted) in _ENTRIES.get(name, {}).items():
        if not fits(content.get(key)):
            raise FileError(f"cannot read '{path}': '{key}' is {str(content[key])[:40]!r}; it must be {wanted}")
    return content


def _is_text(value: Any) -> bool:
    return value is None or isinstance(value, str)


def _is_number(value: Any) -> bool:
    return value is None or type(value) is int


def _is_texts(value: Any) -> bool:
    return value is None or (isinstance(value, list) and all(isinstance(text, str) for text in value))


_ENTRIES: dict[str, dict[str, tuple[Callable[[Any], bool], str]]] = {
    "run": {"task": (_is_text, "text"), "overrides": (_is_texts, "a list of texts"), "continues": (_is_text, "text")},
    "agent": {"seed": (_is_number, "a whole number"), "run_name": (_is_text, "text")},
}
"""Entries that are read again, and what they must be; each may be missing."""
