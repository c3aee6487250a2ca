"""What a run's folder says of the run: the files in its ``params``."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import yaml

from lift_lab.utils.errors import FileError
from lift_lab.utils.io import load_yaml


def read_params(run_dir: Path, name: str) -> dict[str, Any]:
    """Content of one of the files that :func:`~lift_lab_rl.script_steps.write_configurations` writes.

    Args:
        run_dir: folder of the run.
        name: ``env``, ``agent`` or ``run``.

    Returns:
        What the file holds; empty where there is none.

    Raises:
        FileError: the file holds no settings.
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
    return content
