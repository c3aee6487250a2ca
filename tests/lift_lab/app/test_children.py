"""Children end with the process that started them, and a folder is worked in once at a time."""

import os
import signal
import subprocess
import sys
import time

import pytest

from lift_lab.app import children
from lift_lab.app.children import FolderLock, child_environment
from lift_lab.utils.errors import ConfigError

CHILD = """
import os, sys, time
delay = float(sys.argv[1])
print("started", flush=True)
time.sleep(delay)
from lift_lab.app import cli
def main():
    try:
        print("working", flush=True)
        time.sleep(60)
    except KeyboardInterrupt as interrupt:
        open("ended.txt", "w").write(str(interrupt))
        raise
cli.run(main)
"""
PARENT = """
import subprocess, sys
from lift_lab.app.children import child_environment
child = subprocess.Popen([sys.executable, "-c", *sys.argv[1:]], env=child_environment(), start_new_session=True)
print(f"{child.pid}\\n", end="", flush=True)  # one write: the child writes to the same pipe
child.wait()
"""


def start_both(delay_s, cwd):
    """A parent with a child that has started; the parent, and the child's process number."""
    parent = subprocess.Popen(
        [sys.executable, "-c", PARENT, CHILD, str(delay_s)], cwd=cwd, stdout=subprocess.PIPE, text=True
    )
    number, text = sorted(parent.stdout.readline() for _ in range(2))  # the child may be first
    assert text == "started\n"
    return parent, int(number)


def ends(pid, within_s=20.0):
    """Whether a process that is no child of this one ends."""
    end = time.monotonic() + within_s
    while time.monotonic() < end:
        try:
            with open(f"/proc/{pid}/stat") as state:
                if state.read().rpartition(")")[2].split()[0] == "Z":
                    return True
        except (FileNotFoundError, ProcessLookupError):
            return True
        time.sleep(0.02)
    return False


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="prctl is Linux's")
def test_a_child_is_told_that_its_parent_was_killed(tmp_path):
    parent, child = start_both(0, tmp_path)
    assert parent.stdout.readline() == "working\n"
    parent.kill()
    parent.wait()
    assert ends(child)
    assert (tmp_path / "ended.txt").read_text() == "SIGTERM"


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="prctl is Linux's")
def test_a_child_whose_parent_was_killed_before_it_could_ask_does_not_begin(tmp_path):
    parent, child = start_both(1.0, tmp_path)
    parent.kill()
    assert parent.stdout.readline() == ""  # it never worked; its end closed the pipe
    parent.wait()
    assert ends(child)
    assert not (tmp_path / "ended.txt").exists()


def test_a_grandchild_is_not_asked_for():
    code = (
        "from lift_lab.app.children import follow_parent as f; import os; f(); print('LIFT_LAB_PARENT' in os.environ)"
    )
    done = subprocess.run([sys.executable, "-c", code], env=child_environment(), capture_output=True, text=True)
    assert (done.returncode, done.stdout) == (0, "False\n")


def test_a_second_start_in_a_folder_is_refused_while_the_first_runs(tmp_path):
    first = FolderLock(tmp_path / "new", "study.py")
    with pytest.raises(ConfigError, match=rf"study\.py already works in '.*new' \(process {os.getpid()}\)"):
        FolderLock(tmp_path / "new", "study.py")
    first.release()
    FolderLock(tmp_path / "new", "study.py").release()


def test_a_second_start_waits_for_the_children_of_a_killed_first(tmp_path, capsys, monkeypatch):
    lock = FolderLock(tmp_path, "study.py")
    child = subprocess.Popen(["sleep", "60"], pass_fds=[lock.handle])
    lock.release()
    gone = subprocess.Popen(["true"])
    gone.wait()
    (tmp_path / ".lock").write_text(f"{gone.pid}\n")
    monkeypatch.setattr(children, "PATIENCE_S", 0.3)
    with pytest.raises(ConfigError, match=r"in use by a process that an earlier study\.py left"):
        FolderLock(tmp_path, "study.py")
    monkeypatch.setattr(children, "PATIENCE_S", 20.0)
    child.send_signal(signal.SIGKILL)
    child.wait()
    FolderLock(tmp_path, "study.py").release()
    assert capsys.readouterr().err == "waiting for what an earlier study.py left to save and end\n"
