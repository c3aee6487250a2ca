"""Sandboxed import: another process imports binary files first, so that a damaged one cannot end this process.

usd-core checks text while it parses it. It maps crates (.usdc) and packages (.usdz) into memory and trusts them. A
wrong count in one can make the stage follow an invalid pointer, or fill the machine's memory. This gives no error, only
a signal. So this process opens only what the other one has imported within limits of time and memory. The other process
starts with the first binary file, serves later ones, and ends when none comes for a while.
"""

from __future__ import annotations

import atexit
import contextlib
import io
import json
import os
import signal
import subprocess
import sys
import threading
import warnings
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, cast

from pxr import Ar, Sdf, Tf

from lift_lab.usd.report import UsdImportError
from lift_lab.utils.assets import shipped_folders

COMPUTING_S, COMPUTING_S_PER_MB = 30.0, 1.0
"""Longest computing time for one file, and what is added for each megabyte of it."""
MEMORY, MEMORY_PER_BYTE = 4 << 30, 64
"""Most memory for one file in bytes, and what is added for each byte of it."""
PATIENCE = 20.0
"""Factor from computing time to the longest time by the clock: the machine may be busy."""
IDLE_S = 10.0
"""Time in s that the other process waits for the next file."""
_BINARY = (b"PXR-USDC", b"PK\x03\x04")
_SCRIPT = Path(__file__).with_name("sandbox_process.py")
_MOST_REMEMBERED = 4096


def import_in_sandbox(
    file: str | Path, variants: Mapping[str, str] | None = None, scale: float | Sequence[float] | None = None
) -> list[Sdf.Layer]:
    """Import a file in the other process, to find out whether that ends it. Text files are not sandboxed.

    Args:
        file: A .usd, .usda, .usdc or .usdz file.
        variants: As for :func:`lift_lab.usd.load`.
        scale: As for :func:`lift_lab.usd.load`.

    Returns:
        The text layers that the file is composed of: held until the stage is open, they are not parsed again.

    Raises:
        UsdImportError: The other process could not import it, was ended by usd-core, took too long or too much memory.
    """
    layers, binaries = composed_of(Path(file))
    if binaries:
        texts = [layer.realPath for layer in layers]
        _reader.require(str(file), binaries, texts, variants, scale)
    return layers


def composed_of(file: Path) -> tuple[list[Sdf.Layer], list[str]]:
    """The text layers that a file is composed of, opened, and the binary files that these name, unopened."""
    if not file.is_file():
        return [], []  # opening the stage says so
    if is_binary(file):
        return [], [str(file)]
    layers: list[Sdf.Layer] = []
    binaries: set[str] = set()
    seen: set[str] = set()
    pending = [os.path.abspath(file)]
    resolver = Ar.GetResolver()
    with Ar.ResolverContextBinder(resolver.CreateDefaultContextForAsset(pending[0])):
        while pending:
            identifier = pending.pop()
            if identifier in seen:
                continue
            seen.add(identifier)
            package, inside = Ar.SplitPackageRelativePathOuter(Sdf.Layer.SplitIdentifier(identifier)[0])
            found = resolver.Resolve(package).GetPathString()
            if inside or is_binary(Path(found)):
                if not any(Path(found).is_relative_to(folder) for folder in shipped_folders()):  # what ships is whole
                    binaries.add(found)
                continue
            layer = _open_text(identifier) if found else None
            if layer:
                layers.append(layer)
                for name in filter(None, layer.GetCompositionAssetDependencies()):
                    if Sdf.VariableExpression.IsExpression(name):  # only the stage can tell what it means
                        binaries.add(name)
                    else:
                        pending.append(Sdf.ComputeAssetPathRelativeToLayer(layer, name))
    return layers, sorted(binaries)


def _open_text(identifier: str) -> Sdf.Layer | None:
    try:
        return Sdf.Layer.FindOrOpen(identifier)
    except Tf.ErrorException:  # composition will say so, and of what prim
        return None


def is_binary(file: Path) -> bool:
    """Whether a file is a crate or a package, by its name or by how it starts."""
    if file.suffix.lower() in (".usdc", ".usdz"):
        return True
    try:
        with file.open("rb") as stream:
            return stream.read(8).startswith(_BINARY)
    except OSError:
        return False


class Reader:
    """The other process: started on demand, used by one thread at a time, started again after its end.

    Args:
        script: What it runs.
        computing_s: Longest computing time for one file.
        idle_s: How long it waits for the next file.
    """

    def __init__(self, script: Path = _SCRIPT, computing_s: float = COMPUTING_S, idle_s: float = IDLE_S) -> None:
        self._script, self._computing_s, self._idle_s = script, computing_s, idle_s
        self._lock = threading.Lock()
        self._process: subprocess.Popen[bytes] | None = None
        self._survived: dict[str, list[tuple[str, int, int]]] = {}
        self._hooked = False

    @property
    def pid(self) -> int | None:
        """The process, None while there is none."""
        process = self._process
        return process.pid if process else None

    def require(
        self,
        file: str,
        binaries: Sequence[str],
        texts: Sequence[str] = (),
        variants: Mapping[str, str] | None = None,
        scale: float | Sequence[float] | None = None,
    ) -> None:
        """Raise UsdImportError if the process cannot import the file; `binaries` and `texts` are known parts of it.

        A file that was read is not read again while it and the files that it is composed of stay as they are.
        """
        size = sum(size for _, size, _ in _states({*binaries, *texts}))
        computing_s = self._computing_s + COMPUTING_S_PER_MB * size / 1e6
        request = {
            "file": os.path.abspath(file),
            "variants": dict(variants) if variants else None,
            "scale": [float(v) for v in scale] if isinstance(scale, Iterable) else scale,
            "computing_s": computing_s,
            "clock_s": computing_s * PATIENCE,
            "memory": MEMORY + MEMORY_PER_BYTE * size,
        }
        line = json.dumps(request, default=float)
        with self._lock:
            states = self._survived.get(line)
            if states and states == _states(state[0] for state in states):
                return
            answer = self._ask(line)
            if isinstance(answer, dict) and "files" in answer:
                if len(self._survived) >= _MOST_REMEMBERED:
                    self._survived.clear()
                self._survived[line] = _states({*binaries, *texts, *answer["files"]})
                return
        if answer is None:
            text = "the process that reads binary USD files first does not start; a damaged file may end this one"
            warnings.warn(text, RuntimeWarning, stacklevel=4)
            return
        if isinstance(answer, dict) and "error" in answer:
            raise UsdImportError(file, *answer["error"])
        if isinstance(answer, dict):
            end = f"takes more than {request['memory'] / 1e9:.1f} GB of memory, or more than there is"
        elif answer in (-signal.SIGPROF, -signal.SIGALRM):
            end = f"takes more than {computing_s:.0f} s of computing"
        elif answer < 0:
            end = f"ends usd-core by {_name(answer)}"
        else:  # an error in Python, which this process will raise
            return
        raise UsdImportError(file, reason=f"{_culprit(file, binaries)}: reading it {end}")

    def _ask(self, line: str) -> dict[str, Any] | int | None:
        """The answer, or the exit status of a process that ended over the request, or None where none can start."""
        while True:
            fresh = self._process is None
            if fresh and not self._start():
                return None
            answer = self._exchange(line)
            if answer is not None:
                return answer
            status = self._stop(5.0)
            # One that has served before may have left for want of work, or carry the harm of an earlier file.
            if fresh or status in (-signal.SIGPROF, -signal.SIGALRM):
                return status

    def _start(self) -> bool:
        if not self._hooked:
            self._hooked = True
            atexit.register(self.close)
            if hasattr(os, "register_at_fork"):
                os.register_at_fork(after_in_child=self._forget)
        folder = Path(__file__).parent
        packages = {"lift_lab": folder.parent, "lift_lab.usd": folder, "lift_lab.utils": folder.parent / "utils"}
        setup = {
            "path": [os.path.abspath(entry) for entry in sys.path],
            "packages": {name: str(path) for name, path in packages.items()},
            "idle_s": self._idle_s,
        }
        command = [sys.executable, "-I", "-S", str(self._script)]
        try:
            self._process = subprocess.Popen(
                command, bufsize=0, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL
            )
        except OSError:
            return False
        threading.Thread(target=self._reap, args=(self._process,), daemon=True).start()
        if self._exchange(json.dumps(setup)) is None:
            self._stop()
        return self._process is not None

    def _exchange(self, line: str) -> dict[str, Any] | None:
        """Send a line and wait for the answer; None if the process ends instead."""
        assert self._process is not None
        stdin, stdout = cast("io.RawIOBase", self._process.stdin), cast("io.RawIOBase", self._process.stdout)
        try:
            data = memoryview(line.encode() + b"\n")
            while data:
                data = data[stdin.write(data) :]
            answer = stdout.readline()
        except BrokenPipeError:
            return None
        except BaseException:  # an answer that nobody waited for would be taken for the next one's
            self._stop()
            raise
        return json.loads(answer) if answer.endswith(b"\n") else None

    def _stop(self, patience_s: float = 0.0) -> int:
        """End the process unless it ends by itself; its exit status."""
        process, self._process = self._process, None
        if process is None:
            return 0
        try:
            return process.wait(patience_s)
        except subprocess.TimeoutExpired:
            process.kill()
            return process.wait()
        finally:
            _close_pipes(process)

    def _reap(self, process: subprocess.Popen[bytes]) -> None:
        """Collect a process that leaves for want of work."""
        process.wait()
        with self._lock:
            if self._process is process:
                self._stop()

    def close(self) -> None:
        """End the process, even in the middle of a question."""
        process = self._process
        if process is not None:
            process.kill()
            process.wait()

    def _forget(self) -> None:
        """After a fork: the process is the parent's, who may be in the middle of a question."""
        process, self._process, self._lock = self._process, None, threading.Lock()
        if process is not None:
            process.returncode = 0
            _close_pipes(process)


def _close_pipes(process: subprocess.Popen[bytes]) -> None:
    for pipe in (process.stdin, process.stdout):
        if pipe is not None:
            pipe.close()


def _states(files: Iterable[str]) -> list[tuple[str, int, int]]:
    """Size in bytes and time of change of each file, by name."""
    states = []
    for file in sorted(files):
        with contextlib.suppress(OSError):
            found = os.stat(file)
            states.append((file, found.st_size, found.st_mtime_ns))
    return states


def _culprit(file: str, binaries: Sequence[str]) -> str:
    if list(binaries) == [str(Path(file))]:
        return "damaged"
    names = ", ".join(sorted(os.path.basename(name) for name in binaries)[:3])
    return f"one of the binary files that it refers to is damaged ({names}{', ...' if len(binaries) > 3 else ''})"


def _name(status: int) -> str:
    try:
        return signal.Signals(-status).name
    except ValueError:
        return f"signal {-status}"


_reader = Reader()
