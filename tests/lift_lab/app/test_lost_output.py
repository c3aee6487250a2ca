"""A script whose terminal or reader goes away ends as after Ctrl-C, and never with a traceback."""

import io
import os
import pty
import signal
import subprocess
import sys
import time

import pytest

from lift_lab.app import cli, endings
from lift_lab.app.output import Output, guarded

SCRIPT = """
import logging, os, sys, threading, time, warnings
from lift_lab.app import cli

def main():
    note = open("note.txt", "w")
    try:
        for number in range(100):
            print(number, flush=True)
            logging.getLogger("a").warning("a log line")
            warnings.warn("a warning")
            thread = threading.Thread(target=lambda: print("of a thread", flush=True))
            thread.start()
            thread.join()
            time.sleep(0.02)
        note.write("all")
    except KeyboardInterrupt as interrupt:
        note.write(f"interrupted by {interrupt}")
        raise
    finally:
        note.close()

cli.run(main)
"""


@pytest.fixture(autouse=True)
def sighup_counts():
    """A signal that ``nohup`` has the tests ignore would be ignored by the scripts, too."""
    before = signal.signal(signal.SIGHUP, signal.SIG_DFL)
    yield
    signal.signal(signal.SIGHUP, before)


@pytest.fixture
def start(tmp_path):
    """Starts the script with given streams; ends it after the test."""
    processes = []

    def call(stdout, stderr=subprocess.PIPE, **kwargs):
        command = [sys.executable, "-c", SCRIPT]
        processes.append(subprocess.Popen(command, stdout=stdout, stderr=stderr, cwd=tmp_path, **kwargs))
        return processes[-1]

    yield call
    for process in processes:
        process.kill()
        process.communicate()


def ended(process, tmp_path):
    """Exit status, standard error and what the script noted."""
    errors = process.communicate(timeout=60)[1]
    return process.returncode, (errors or b"").decode(), (tmp_path / "note.txt").read_text()


def test_a_full_disk_below_standard_output_ends_the_script_as_sighup_does(start, tmp_path):
    with open("/dev/full", "wb") as full:
        status, errors, note = ended(start(full), tmp_path)
    assert (status, note) == (129, "interrupted by SIGHUP")
    assert "Traceback" not in errors
    assert errors.splitlines()[-1] == "ended: standard output is lost (No space left on device)"


def test_a_reader_that_goes_away_ends_it(start, tmp_path):
    process = start(subprocess.PIPE)
    assert process.stdout.readline() == b"0\n"
    process.stdout.close()
    process.stdout = None
    status, errors, note = ended(process, tmp_path)
    assert (status, note) == (129, "interrupted by SIGHUP")
    assert "Traceback" not in errors
    assert "BrokenPipe" not in errors
    assert "ended:" not in errors  # head ends on purpose


@pytest.mark.parametrize("controlling", [True, False], ids=["SIGHUP of the terminal", "no signal"])
def test_a_terminal_that_is_closed_ends_it(tmp_path, controlling):
    master, slave = pty.openpty()
    command = [sys.executable, "-c", SCRIPT]
    claim = "import fcntl, termios, os, sys; fcntl.ioctl(1, termios.TIOCSCTTY, 0); os.execv(sys.argv[1], sys.argv[1:])"
    if controlling:
        command = [sys.executable, "-c", claim, *command]
    streams = {"stdin": slave, "stdout": slave, "stderr": slave}
    process = subprocess.Popen(command, cwd=tmp_path, start_new_session=True, **streams)
    os.close(slave)
    assert os.read(master, 1) == b"0"
    os.close(master)
    assert ended(process, tmp_path) == (129, "", "interrupted by SIGHUP")


def test_nohup_goes_on_without_output(start, tmp_path):
    with open("/dev/full", "wb") as full:
        before = signal.signal(signal.SIGHUP, signal.SIG_IGN)
        try:
            process = start(full, stderr=full)
        finally:
            signal.signal(signal.SIGHUP, before)
        time.sleep(0.5)
        process.send_signal(signal.SIGHUP)
        assert ended(process, tmp_path) == (0, "", "all")


@pytest.mark.parametrize(("number", "said"), [(signal.SIGTERM, "ended by SIGTERM"), (signal.SIGINT, "interrupted")])
def test_a_signal_ends_it_in_one_line(start, tmp_path, number, said):
    process = start(subprocess.PIPE)
    process.stdout.readline()
    process.send_signal(number)
    status, errors, note = ended(process, tmp_path)
    assert status == 128 + number
    assert errors.splitlines()[-1] == said
    assert note.startswith("interrupted by")


def test_many_signals_end_it_without_a_traceback(start, tmp_path):
    process = start(subprocess.PIPE)
    process.stdout.readline()
    while process.poll() is None:
        process.send_signal(signal.SIGINT)
        time.sleep(0.001)
    status, errors, _ = ended(process, tmp_path)
    assert status == 130
    assert "Traceback" not in errors


def test_streams_closed_from_the_start_are_no_loss_and_no_file_gets_their_text(tmp_path):
    command = ["sh", "-c", 'exec "$0" -c "$1" <&- >&- 2>&-', sys.executable, SCRIPT]
    process = subprocess.run(command, cwd=tmp_path, timeout=60)
    assert process.returncode == 0
    assert (tmp_path / "note.txt").read_text() == "all"


def test_a_full_disk_below_any_file_is_one_line(capsys):
    def main():
        with open("/dev/full", "w") as file:
            file.write("text")

    with pytest.raises(SystemExit) as ended:
        cli.run(main)
    assert ended.value.code == 2
    assert capsys.readouterr().err == "error: a file could not be written: No space left on device\n"


def test_letters_that_an_encoding_lacks_are_escaped():
    raw = io.BytesIO()
    out = Output(io.TextIOWrapper(raw, encoding="ascii"), "standard output")
    out.write("1 · 2")
    out.flush()
    assert raw.getvalue() == rb"1 \xb7 2"
    assert out.problem is None


class Broken(io.StringIO):
    """Raises as a stream of a kind."""

    def __init__(self, error):
        super().__init__()
        self.error = error

    def write(self, text):
        raise self.error


@pytest.mark.parametrize(
    ("error", "lost"),
    [
        (OSError(5, "Input/output error"), "standard output is lost (Input/output error)"),
        (ValueError("I/O operation on closed file."), "standard output is lost (I/O operation on closed file.)"),
        (BlockingIOError(11, "would block"), None),
        (RuntimeError("reentrant call inside <_io.BufferedWriter>"), None),
    ],
)
def test_what_a_loss_is(error, lost):
    signals = []
    with endings.handled(lambda number, _: signals.append(number)):
        out = Output(Broken(error), "standard output")
        assert out.write("word") == 4
        out.write("another")
        out.flush()
    assert out.problem == lost
    assert signals == ([signal.SIGHUP] if lost else [])


def test_the_streams_before_come_back():
    before = sys.stdout, sys.stderr
    with guarded() as streams:
        assert (sys.stdout, sys.stderr) == streams
    assert (sys.stdout, sys.stderr) == before
