"""Scripts of the project in processes of their own that start at once, and counts of what was tried and what held.

A script runs in a fork of this process, which has imported everything that scripts need: a second of processor time
instead of five. It is a process like any other: it can be killed, and has its own session, folder and streams.
"""

from __future__ import annotations

import contextlib
import os
import runpy
import signal
import sys
import time
import traceback
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path

SCRIPTS = Path(__file__).resolve().parents[1]

PATIENCE_S = 300.0
"""No script of a campaign takes as long, on a busy machine either."""


@dataclass
class Tally:
    """What was tried, and what did not hold."""

    tried: dict[str, int] = field(default_factory=dict)
    """Kind -> how often."""
    failures: list[tuple[str, str]] = field(default_factory=list)
    """Kind, and what happened."""

    def note(self, kind: str, problems: Sequence[str] | str | None, what: str) -> None:
        """Count an attempt.

        Args:
            kind: what was tried.
            problems: what did not hold; empty or None if all did.
            what: names the attempt.
        """
        self.tried[kind] = self.tried.get(kind, 0) + 1
        problems = [problems] if isinstance(problems, str) else list(problems or ())
        if problems:
            self.failures.append((kind, f"{what}: {'; '.join(problems)}"))
            print(f"FAILED {kind}: {self.failures[-1][1]}", flush=True)

    def rows(self) -> list[tuple[str, int, int]]:
        """(kind, tried, held) for each kind."""
        failed = [kind for kind, _ in self.failures]
        return [(kind, count, count - failed.count(kind)) for kind, count in self.tried.items()]


@dataclass(frozen=True)
class Ended:
    """How a script ended."""

    status: int
    """Exit status; less than 0 for the signal that ended it."""
    text: str
    """Standard output and standard error."""

    @property
    def errors(self) -> list[str]:
        """Lines that begin with ``error:``."""
        return [line for line in self.text.splitlines() if line.startswith("error: ")]

    def problems(self, *statuses: int) -> list[str]:
        """What is wrong, if one of these exit statuses is right; status 2 needs one line that names the error."""
        found = []
        if "Traceback (most recent call last)" in self.text or "Exception ignored" in self.text:
            found.append("traceback: " + " | ".join(self.text.strip().splitlines()[-3:])[-400:])
        elif self.status not in statuses:
            found.append(f"status {self.status}: " + " | ".join(self.text.strip().splitlines()[-2:])[-300:])
        elif self.status == 2 and len(self.errors) != 1:
            found.append(f"{len(self.errors)} error lines: {self.text[-300:]!r}")
        return found


def preload(warp: bool) -> None:
    """Import what scripts import, so that forks need not.

    Args:
        warp: whether scripts use the engine ``warp``.
    """
    import gymnasium  # noqa: F401
    import pxr.Usd  # noqa: F401
    import torch

    import lift_lab_tasks.manager_based.classic.cartpole.cartpole_env_cfg
    import lift_lab_tasks.utils.hydra
    import lift_lab_tasks.utils.runs  # noqa: F401

    torch.set_num_threads(1)
    if warp:
        import lift_lab.sim.physics.warp  # noqa: F401


class Script:
    """A script that runs."""

    _count = 0

    def __init__(
        self,
        script: str | Path,
        args: Sequence[object],
        folder: Path,
        streams: dict[int, int] | None = None,
        prepare: Callable[[], None] | None = None,
        output: Path | None = None,
    ):
        """Start it.

        Args:
            script: path, or path below ``scripts``.
            args: arguments.
            folder: current directory; its output goes to a file beside it.
            streams: numbers of standard streams and what they are instead.
            prepare: called in the new process first.
            output: file for its output; None for one beside the folder.
        """
        Script._count += 1
        folder.mkdir(parents=True, exist_ok=True)
        self.output = output or folder.parent / f"{folder.name}-output-{Script._count}.txt"
        self.began = time.monotonic()
        sys.stdout.flush()
        sys.stderr.flush()
        self.pid = os.fork()
        if self.pid == 0:
            self._run(SCRIPTS / script, list(map(str, args)), folder, streams or {}, prepare)
        self._ended: int | None = None

    def _run(
        self,
        path: Path,
        args: list[str],
        folder: Path,
        streams: dict[int, int],
        prepare: Callable[[], None] | None,
    ) -> None:
        status = 1
        try:
            os.setsid()
            os.chdir(folder)
            out = os.open(self.output, os.O_WRONLY | os.O_CREAT | os.O_APPEND, 0o644)
            null = os.open(os.devnull, os.O_RDONLY)
            for number, default in ((0, null), (1, out), (2, out)):
                os.dup2(streams.get(number, default), number)
            sys.stdin = open(0, closefd=False)  # noqa: SIM115
            sys.stdout = open(1, "w", closefd=False)  # noqa: SIM115
            sys.stderr = open(2, "w", closefd=False, buffering=1)  # noqa: SIM115
            for number in (signal.SIGTERM, signal.SIGHUP):
                signal.signal(number, signal.SIG_DFL)
            signal.signal(signal.SIGINT, signal.default_int_handler)
            if prepare is not None:
                prepare()
            sys.argv = [str(path), *args]
            sys.path[:0] = [str(path.parent)]
            try:
                runpy.run_path(str(path), run_name="__main__")
                status = 0
            except SystemExit as ended:
                status = ended.code if isinstance(ended.code, int) else 0 if ended.code is None else 1
            sys.stdout.flush()
        except BaseException:  # what the interpreter would print
            with contextlib.suppress(Exception):
                traceback.print_exc()
        finally:
            os._exit(status)

    def send(self, number: int) -> None:
        """Send a signal."""
        with contextlib.suppress(ProcessLookupError):
            os.kill(self.pid, number)

    def wait(self, timeout: float = PATIENCE_S) -> Ended | None:
        """Wait for its end; None if it still runs after so long, in s."""
        end = time.monotonic() + timeout
        while self._ended is None:
            pid, status = os.waitpid(self.pid, os.WNOHANG)
            if pid:
                self._ended = os.waitstatus_to_exitcode(status)
                break
            if time.monotonic() >= end:
                return None
            time.sleep(0.005)
        text = self.output.read_text(errors="replace") if self.output.exists() else ""
        return Ended(self._ended, text)

    def finish(self) -> Ended:
        """Wait for its end; a script that hangs is killed, with status -9 and a line that says so."""
        ended = self.wait()
        if ended is None:
            self.send(signal.SIGKILL)
            ended = self.wait()
            assert ended is not None
            ended = Ended(ended.status, ended.text + f"\nhung for {PATIENCE_S:.0f} s")
        return ended

    def text(self) -> str:
        """What it has printed so far."""
        return self.output.read_text(errors="replace") if self.output.exists() else ""


def call(script: str | Path, args: Sequence[object], folder: Path) -> Ended:
    """Run a script to its end."""
    return Script(script, args, folder).finish()


# -- the training that campaigns use

ITERATIONS = 24
SMALL = [
    *("--task", "Cartpole", "--device", "cpu", "--num_threads", "1", "--num_envs", "8"),
    *("agent.num_steps_per_env=8", "agent.algorithm.num_learning_epochs=1", "agent.save_interval=2"),
]
ENGINES: dict[str, list[str]] = {"native": [], "warp": ["env.sim.physics=warp"]}


def train_args(engine: str, iterations: int = ITERATIONS, resume: bool = False) -> list[str]:
    """Arguments of the training."""
    return [*SMALL, "--max_iterations", str(iterations), *(["--resume"] if resume else []), *ENGINES[engine]]


def run_folders(folder: Path) -> list[Path]:
    """Folders of the runs that were trained in a folder, the oldest first."""
    return sorted(folder.glob("logs/rsl_rl/*/20*"))


def checkpoints(folder: Path) -> list[Path]:
    """Numbered checkpoints of all runs in a folder, in the order of their iterations."""
    found = [path for run in run_folders(folder) for path in run.glob("model_*.pt") if path.stem[6:].isdigit()]
    return sorted(found, key=lambda path: int(path.stem[6:]))


class References:
    """Trainings that nothing interrupts, one for each engine: what the interrupted ones have to end with."""

    def __init__(self, folder: Path):
        self._folder = folder
        self._made: dict[str, tuple[bytes, float]] = {}

    def folder(self, engine: str) -> Path:
        """Where the training of an engine is."""
        self.of(engine)
        return self._folder / engine

    def of(self, engine: str) -> tuple[bytes, float]:
        """The last checkpoint of an engine's training, and how long it took, in s."""
        if engine not in self._made:
            script = Script("rsl_rl/train.py", train_args(engine), self._folder / engine)
            ended = script.finish()
            if ended.problems(0):
                raise RuntimeError(f"the training of reference fails: {ended.text[-2000:]}")
            self._made[engine] = checkpoints(self._folder / engine)[-1].read_bytes(), time.monotonic() - script.began
        return self._made[engine]


def damaged_files(folder: Path, ran: int | None = None) -> list[str]:
    """What is wrong with files that interrupted processes left; hidden files may be half-written, no others.

    Args:
        folder: where to look.
        ran: process number whose temporary files have to be gone; None for no such look.
    """
    from tensorboard.backend.event_processing.event_file_loader import RawEventFileLoader

    from lift_lab.utils.errors import LiftLabError
    from lift_lab_rl.files import load_torch, read_json
    from lift_lab_rl.run_params import read_params

    found = []
    for path in sorted(folder.rglob("*")):
        if ran is not None and path.name.endswith(f"-{ran}.tmp"):
            found.append(f"left: {path.name}")
        if not path.is_file() or path.name.startswith("."):
            continue
        try:
            if path.suffix == ".pt" and path.parent.name != "exported":
                load_torch(path)
            elif path.suffix == ".json":
                read_json(path)
            elif path.suffix == ".yaml":
                read_params(path.parent.parent, path.stem)
            elif path.name.startswith("events.out."):
                count = sum(1 for _ in RawEventFileLoader(str(path)).Load())
                if count == 0 and path.stat().st_size:
                    found.append(f"{path.name}: no record")
        except LiftLabError as error:
            found.append(str(error))
    return found
