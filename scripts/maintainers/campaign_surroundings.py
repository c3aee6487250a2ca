"""Trainings on a full disk, and trainings whose terminal or reader goes away."""

from __future__ import annotations

import contextlib
import os
import random
import resource
import signal
import subprocess
import time
from collections.abc import Callable, Iterator
from pathlib import Path

from campaign_runs import (
    ITERATIONS,
    PATIENCE_S,
    Ended,
    References,
    Script,
    Tally,
    call,
    checkpoints,
    damaged_files,
    train_args,
)


def _wait_for(condition: Callable[[], object], script: Script) -> bool:
    """Wait until something holds; whether it does before the script ends."""
    end = time.monotonic() + PATIENCE_S
    while time.monotonic() < end:
        if condition():
            return True
        if script.wait(0.02) is not None:
            return bool(condition())
    return False


def _continued(place: Path, wanted: bytes) -> list[str]:
    """Continue a training that ended early; what is wrong with how it ends."""
    last, problems = checkpoints(place), []
    if not last or int(last[-1].stem[6:]) < ITERATIONS:
        problems = call("rsl_rl/train.py", train_args("native", resume=bool(last)), place).problems(0)
    if not problems and checkpoints(place)[-1].read_bytes() != wanted:
        problems = ["the continued training ends with other bits"]
    return problems


# -- disks


@contextlib.contextmanager
def _small_disk(folder: Path, size: str = "3m") -> Iterator[bool]:
    """A file system of a few megabytes at a folder; False where this process may not mount one."""
    folder.mkdir(parents=True)
    mount = ["mount", "-t", "tmpfs", "-o", f"size={size}", "tmpfs", str(folder)]
    try:
        mounted = subprocess.run(mount, capture_output=True).returncode == 0
    except OSError:
        mounted = False
    try:
        yield mounted
    finally:
        if mounted:
            subprocess.run(["umount", "-l", str(folder)], capture_output=True)


def _fill(file: Path) -> None:
    """Use up a disk."""
    with open(file, "wb", buffering=0) as ballast, contextlib.suppress(OSError):
        while True:
            ballast.write(bytes(4096))


def full_disks(folder: Path, count: int, rng: random.Random, tally: Tally, ref: References) -> None:
    """Let the disk be full for a part of a training, or to its end."""
    wanted = ref.of("native")[0]
    for number in range(count):
        place = folder / f"disk-{number}"
        with _small_disk(place) as mounted:
            if not mounted:
                _files_too_large(place, tally, wanted)
                continue
            frees, inside = number % 2 == 0, number % 4 >= 2
            words = f"disk full {'for a while' if frees else 'to the end'}{', output on it' if inside else ''}"
            tally.note(words, _full_disk(place, frees, inside, rng, wanted), place.name)


def _full_disk(place: Path, frees: bool, inside: bool, rng: random.Random, wanted: bytes) -> list[str]:
    """What does not hold when the disk is full from some iteration on.

    Args:
        place: the disk.
        frees: whether there is room again before the training ends.
        inside: whether the training's output goes to the same disk.
        rng: chooses the iteration.
        wanted: what an uninterrupted training ends with.
    """
    work, ballast, first = place / "work", place / "ballast", rng.randrange(2, 10)
    output = place / "output.txt" if inside else place.parent / f"{place.name}-output.txt"
    script = Script("rsl_rl/train.py", train_args("native"), work, output=output)
    if not _wait_for(lambda: any(int(path.stem[6:]) >= first for path in checkpoints(work)), script):
        return [f"no checkpoint: {script.finish().text[-300:]}"]
    _fill(ballast)
    if frees:
        if not inside:
            _wait_for(lambda: "trying again after each iteration" in script.text(), script)
        time.sleep(rng.uniform(0.0, 1.0))
        ballast.unlink()
    ended = script.finish()
    ballast.unlink(missing_ok=True)
    problems = damaged_files(work)
    if inside:  # it ends as without a terminal, once a checkpoint is written, or says nothing of the error
        problems += ended.problems(0, 129) if ended.status != 2 else []
    else:  # 0 too if the training was done before
        problems += ended.problems(0, 2)
    if ended.status == 0 and checkpoints(work)[-1].read_bytes() != wanted:
        problems.append("ends with other bits")
    return problems + (_continued(work, wanted) if ended.status else [])


def _files_too_large(place: Path, tally: Tally, wanted: bytes) -> None:
    """Without a disk of its own: no file may be larger than a checkpoint's half."""

    def limit() -> None:
        hard = resource.getrlimit(resource.RLIMIT_FSIZE)[1]
        resource.setrlimit(resource.RLIMIT_FSIZE, (len(wanted) // 2, hard))

    read, write = os.pipe()
    script = Script("rsl_rl/train.py", train_args("native"), place / "work", {1: write, 2: write}, limit)
    os.close(write)
    text = os.fdopen(read, "rb").read().decode(errors="replace")
    ended = Ended(script.finish().status, text)
    problems = [*ended.problems(2), *_continued(place / "work", wanted)]
    tally.note("files too large to the end", problems, place.name)


# -- terminals


def lost_terminals(folder: Path, count: int, rng: random.Random, tally: Tally, ref: References) -> None:
    """Take terminals and readers away from trainings; they have to save, and to continue to the same bits."""
    wanted, length_s = ref.of("native")
    kinds = (_terminal, _terminal_without_signal, _pipe, _full_output, _nohup, _closed_from_the_start)
    for number in range(count):
        kind, place = kinds[number % len(kinds)], folder / f"terminal-{number}"
        words = (kind.__doc__ or "").strip().rstrip(".").lower()
        script, hang_up, statuses = kind(place)
        _wait_for(lambda work=place: checkpoints(work), script)
        time.sleep(rng.uniform(0.0, 0.3) * length_s)
        hang_up()
        ended = script.finish()
        problems = ended.problems(*statuses)
        problems += damaged_files(place)
        if not checkpoints(place):
            problems.append("nothing is saved")
        if ended.status != 0:
            problems += _continued(place, wanted)
        elif checkpoints(place)[-1].read_bytes() != wanted:
            problems.append("ends with other bits")
        tally.note(words, problems, place.name)


_Case = tuple[Script, Callable[[], None], tuple[int, ...]]


def _claim() -> None:
    import fcntl
    import termios

    fcntl.ioctl(1, termios.TIOCSCTTY, 0)


def _train(place: Path, streams: dict[int, int], prepare: Callable[[], None] | None = None) -> Script:
    return Script("rsl_rl/train.py", train_args("native"), place, streams, prepare)


def _drain(descriptor: int) -> Callable[[], None]:
    """Read what comes, as a terminal does; returns what closes the reader."""
    import threading

    open_still = [True]

    def read() -> None:
        with contextlib.suppress(OSError):
            while open_still[0] and os.read(descriptor, 65536):
                pass

    threading.Thread(target=read, daemon=True).start()

    def close() -> None:
        open_still[0] = False
        os.close(descriptor)

    return close


def _on_terminal(place: Path, prepare: Callable[[], None] | None) -> _Case:
    master, slave = os.openpty()

    def child() -> None:
        os.close(master)
        if prepare is not None:
            prepare()

    script = _train(place, {0: slave, 1: slave, 2: slave}, child)
    os.close(slave)
    return script, _drain(master), (129, 0)


def _terminal(place: Path) -> _Case:
    """The terminal is closed (SIGHUP)."""
    return _on_terminal(place, _claim)


def _terminal_without_signal(place: Path) -> _Case:
    """The terminal of another session is closed."""
    return _on_terminal(place, None)


def _pipe(place: Path) -> _Case:
    """The reader of a pipe ends."""
    read, write = os.pipe()
    script = _train(place, {1: write}, lambda: os.close(read))
    os.close(write)
    return script, _drain(read), (129, 0)


def _full_output(place: Path) -> _Case:
    """Standard output cannot be written."""
    read, write = os.pipe()
    full = os.open("/dev/full", os.O_WRONLY)

    def swap() -> None:  # from the start nothing would be trained
        os.kill(script.pid, signal.SIGCONT)

    script = _train(place, {1: full}, lambda: _print_nothing_until_trained(place))
    for descriptor in (read, write, full):
        os.close(descriptor)
    return script, swap, (129, 0)


def _print_nothing_until_trained(place: Path) -> None:
    """Hold text back until a checkpoint is there."""
    import sys

    write = sys.stdout.write

    class Held:
        def __getattr__(self, name: str) -> object:
            return getattr(sys.__stdout__, name)

        def write(self, text: str) -> int:
            return write(text) if checkpoints(place) else len(text)

        def flush(self) -> None:
            if checkpoints(place):
                stream.flush()

    stream = sys.stdout
    sys.stdout = Held()


def _nohup(place: Path) -> _Case:
    """Under nohup, the terminal is closed."""

    def ignore() -> None:
        signal.signal(signal.SIGHUP, signal.SIG_IGN)
        _claim()

    script, hang_up, _ = _on_terminal(place, ignore)
    return script, hang_up, (0,)


def _closed_from_the_start(place: Path) -> _Case:
    """Standard streams are closed from the start."""

    def close() -> None:
        import sys

        for number, name in enumerate(("stdin", "stdout", "stderr")):
            os.close(number)
            setattr(sys, name, None)

    return _train(place, {}, close), lambda: None, (0,)
