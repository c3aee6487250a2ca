"""Folders of training runs and the checkpoints in them."""

from __future__ import annotations

import contextlib
import re
import shutil
import sys
import time
from collections.abc import Callable
from difflib import get_close_matches
from pathlib import Path
from typing import Any

from lift_lab.utils.errors import ConfigError, FileError, quote, suggest
from lift_lab.utils.io import remove_dead_temporaries
from lift_lab_assets.files import PRETRAINED_DIR
from lift_lab_rl.fingerprint import Fingerprint
from lift_lab_rl.run_params import read_params

from .parse_cfg import get_checkpoint_path

LOGS = Path("logs")
"""Folder of all runs, below the current directory: a folder for each library."""

LOG_ROOT = LOGS / "rsl_rl"
"""Folder of rsl_rl's runs."""

CHECKPOINT = r"model_\d+\.pt"
"""Files that a run writes as it goes."""

BEST = "model_best.pt"
"""The file of the best policy of a run."""

PRETRAINED = "pretrained"
"""Name of the policy that ships for a task, in place of a path."""

_WORDS = ("latest", "best", PRETRAINED)
"""What a user may call a checkpoint instead of a file."""

_FOLDER, _PART = re.compile(r"[^\\\x00-\x1f\x7f-\x9f]+"), re.compile(r"[^/\\\x00-\x1f\x7f-\x9f]+")
"""Names of folders, and parts of the name of one."""

_LONGEST = 200
"""Bytes in a name; file systems take 255, and a run's folder begins with the time."""

_NO_MATTER = {
    "agent": {
        *("max_iterations", "save_interval", "keep_resume_states", "resume", "load_run", "load_checkpoint"),
        *("run_name", "experiment_name", "logger", "wandb_project", "neptune_project"),
        *("num_threads", "success_metric", "check_for_nan", "evaluation"),
    },
    "env": {"viewer", "log_dir", "export_io_descriptors", "sim.num_threads"},
}
"""Settings in which a continued run may differ from the one it continues."""


def experiment_dir(agent_cfg: Any) -> Path:
    """Folder of an experiment's runs."""
    return (LOG_ROOT / agent_cfg.experiment_name).absolute()


def new_run_dir(agent_cfg: Any) -> Path:
    """A new, empty folder for a run that starts now: time, then the run's name.

    Raises:
        ConfigError: a run's name that is no part of a path.
        FileError: the folder cannot be made.
    """
    return make_run_dir(experiment_dir(agent_cfg), agent_cfg.run_name)


def make_run_dir(parent: Path, *parts: str | None) -> Path:
    """Make a folder that is named by the time and by those of ``parts`` that are not empty.

    Two runs that start at once get one each. What killed processes left half-written in ``parent`` is removed.

    Raises:
        ConfigError: a name that is no part of a path.
        FileError: the folder cannot be made.
    """
    given = "_".join(part for part in parts if part)
    if Path(given).name != given:
        raise ConfigError(f"'{given}' cannot be part of a folder's name")
    name = time.strftime("%Y-%m-%d_%H-%M-%S") + (f"_{given}" if given else "")
    folder, number = parent.absolute() / name, 1
    remove_dead_temporaries(parent)
    while True:
        try:
            folder.mkdir(parents=True)
            return folder
        except OSError as error:
            if isinstance(error, FileNotFoundError) and number < 3:  # another run removed the empty parent
                number += 1
                continue
            if not folder.is_dir():
                raise FileError(f"cannot make the folder '{folder}': {error.strerror}") from error
        number += 1
        folder = folder.with_name(f"{name}-{number}")


def discard_unused(folder: Path) -> None:
    """Remove the folder of a run that did not begin (a library may have opened a log) or that wrote nothing.

    The folders around it that are empty then go too, up to ``logs``.
    """
    with contextlib.suppress(OSError):
        names = {entry.name for entry in folder.iterdir()}
        if "params" not in names or names <= {"params", "io_descriptors"}:
            shutil.rmtree(folder)
            discard_empty_parents(folder)


def discard_empty_parents(folder: Path) -> None:
    """Remove the folders around one that is gone, as far as they are empty, up to ``logs``."""
    with contextlib.suppress(OSError):
        for parent in folder.absolute().parents:
            if not parent.is_relative_to(LOGS.absolute()):
                break
            parent.rmdir()


def check_run_names(names: Any) -> None:
    """Check the names from which folders are made.

    Args:
        names: has ``experiment_name``, a folder below that of all runs, and ``run_name``, a part of a folder's name.
            Names that are missing or None are not checked.

    Raises:
        ConfigError: a name leaves the folder, holds control characters, or is too long.
    """
    for key, allowed in (("experiment_name", _FOLDER), ("run_name", _PART)):
        name = getattr(names, key, None)
        if name is None or (key == "run_name" and name == ""):
            continue
        parts = name.split("/")
        wrong = not allowed.fullmatch(name) or any(part in ("", ".", "..") or part != part.strip() for part in parts)
        if wrong or any(len(part.encode()) > _LONGEST for part in parts):
            outer = key == "experiment_name"
            kind = "name folders below that of all runs" if outer else "be part of a folder's name"
            refused = "no '..'" if outer else "no '/'"
            raise ConfigError(
                f"{key} {name[:80]!r} cannot {kind}: {refused}, control characters or more than {_LONGEST} bytes"
            )


def pretrained_name(task: str) -> str:
    """Under which name the policy of a task ships: a task and its ``-Play`` form share one."""
    return task.rpartition(":")[2].removesuffix("-Play")


def pretrained_tasks() -> list[str]:
    """Tasks for which a policy ships."""
    return sorted(path.parent.name for path in PRETRAINED_DIR.glob("*/policy.pt"))


def find_pretrained(task: str) -> Path:
    """The policy that ships for a task.

    Raises:
        FileError: there is none; names the tasks that have one.
    """
    name = pretrained_name(task)
    path = PRETRAINED_DIR / name / "policy.pt"
    if not path.is_file():
        have = ", ".join(pretrained_tasks()) or "none"
        raise FileError(f"no pretrained policy for '{name}'; tasks that have one: {have}")
    return path


def output_dir(agent_cfg: Any, checkpoint: Path) -> Path:
    """Return the folder for files that belong to a checkpoint: beside it, or with the runs for a policy that ships."""
    if checkpoint.is_relative_to(PRETRAINED_DIR):
        return experiment_dir(agent_cfg) / PRETRAINED / checkpoint.parent.name  # tasks may share an experiment
    return checkpoint.parent


def find_checkpoint(
    agent_cfg: Any,
    wanted: str | None,
    run: str | None = None,
    task: str | None = None,
    training: bool = False,
    say: Callable[[str], None] | None = None,
) -> Path:
    """The checkpoint that a user means.

    Tasks may share an experiment: of its runs, those of ``task`` are looked at first, then the others. ``latest``,
    ``best``, an expression for several files, and a run's folder pass over damaged files.

    Args:
        agent_cfg: agent configuration, for the experiment's folder.
        wanted: path of a file or of a run's folder, ``latest`` (or None), ``best``, ``pretrained``, or a regular
            expression of file names.
        run: regular expression of the run's folder name; None for all.
        task: id of the task; None if it does not matter.
        training: whether training will continue, which is not possible with a pretrained policy.
        say: takes one line for each run with a damaged file; None for standard error.

    Raises:
        FileError: there is none; names the nearest.
        ConfigError: a pretrained policy where none will do.
    """
    if wanted == PRETRAINED:
        if task is None or training:
            raise ConfigError("a pretrained policy can be played and evaluated; it holds nothing to train on from")
        return find_pretrained(task)
    folder = experiment_dir(agent_cfg)

    from lift_lab_rl.rsl_rl.run_files import Readable

    readable = Readable(say if say is not None else lambda text: print(text, file=sys.stderr))

    def newest(pattern: str, accept: Callable[[Path], bool] | None = readable.checkpoint) -> Path:
        own = None if task is None else pretrained_name(task)
        prefer = None if own is None else lambda place: readable.run(place) and trained_task(place) == own
        take = None if accept is None else lambda path: readable.run(path.parent) and accept(path)
        return Path(get_checkpoint_path(folder, run or ".*", pattern, prefer=prefer, accept=take))

    if wanted in (None, "", "latest"):
        return newest(CHECKPOINT)
    if wanted == "best":
        return newest(re.escape(BEST))
    path = Path(wanted)
    if path.is_file():
        return path.absolute()
    if path.is_dir():
        folder = path.resolve()
        return Path(get_checkpoint_path(folder.parent, re.escape(folder.name), CHECKPOINT, accept=readable.checkpoint))
    if path.parent != Path("."):
        near = path.parent
        while not near.is_dir():
            near = near.parent
        names = [str(entry.name) for entry in near.iterdir() if entry.is_dir() or entry.suffix == ".pt"]
        missing = path.relative_to(near).parts[0]
        raise FileError(f"no checkpoint '{wanted}': '{near}' has no '{missing}'; {suggest(missing, names)}")
    try:
        names_one = re.fullmatch(r"[\w.-]+", wanted) is not None  # a file that a user names is not replaced by another
        return newest(wanted, None) if names_one else newest(wanted)
    except FileError as error:
        meant = get_close_matches(wanted.lower(), _WORDS, n=1, cutoff=0.7)
        if not meant:
            raise
        raise FileError(f"no checkpoint '{wanted}'; did you mean {quote(meant)}?") from error


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


def trained_task(run_dir: Path) -> str | None:
    """Task that a run was of, without ``-Play``; None where its folder does not say."""
    name = read_params(run_dir, "run").get("task")
    return None if name is None else pretrained_name(str(name))


def note_other_task(checkpoint: Path, task: str, say: Callable[[str], None] = print) -> None:
    """Say so if a checkpoint is of a run of another task.

    Args:
        checkpoint: the file.
        task: id of the task that it is used for.
        say: shows a line to the user.
    """
    trained = trained_task(checkpoint.parent)
    if trained not in (None, pretrained_name(task)):
        say(f"'{checkpoint}' was trained on {trained}")


def note_annealing(agent_cfg: Any, given: Callable[[str], bool], say: Callable[[str], None]) -> None:
    """Log given settings that change during the training, unless their final value is given, too.

    Args:
        agent_cfg: configuration of rsl_rl's PPO.
        given: function that says whether a setting is given, by its path.
        say: takes the line.
    """
    algorithm = vars(agent_cfg.algorithm)
    for name, value in algorithm.items():
        path, final = f"agent.algorithm.{name}", algorithm.get(f"{name}_final")
        if final is not None and given(path) and not given(f"{path}_final"):
            begin, end = algorithm["anneal_iterations"]
            level = algorithm.get("anneal_at_success")
            after = "" if level is None else f" after the success rate reaches {level:g}"
            say(
                f"{path} is {value} at first and goes to {final} over iterations {begin} to {end}{after}; "
                f"{path}_final=null keeps it"
            )


def fingerprint(env_cfg: Any, agent_cfg: Any) -> Fingerprint:
    """Everything in the configurations that a result depends on."""
    leave_out = [f"{part}.{name}" for part, names in _NO_MATTER.items() for name in names]
    if getattr(getattr(agent_cfg, "algorithm", None), "symmetry_cfg", None) is None:
        leave_out.append("env.mirror")  # nothing mirrors
    return Fingerprint.of({"env": env_cfg, "agent": agent_cfg}, leave_out)
