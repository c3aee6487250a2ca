"""Binary files are read by another process first: what ends that one is refused, and nothing else changes."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest
from pxr import Sdf, Usd, UsdGeom, UsdUtils

from lift_lab.usd import UsdImportError, load, sandbox
from lift_lab_assets.files import ASSETS_USD_DIR

PROCESS = Path(sandbox.__file__).with_name("sandbox_process.py")
STAND_IN = f"""
import importlib.util, os, signal, sys, time, types
spec = importlib.util.spec_from_file_location("process", {str(PROCESS)!r})
process = importlib.util.module_from_spec(spec)
spec.loader.exec_module(process)
sys.modules["lift_lab.usd.api"] = types.ModuleType("api")  # an import that costs nothing

def import_in_sandbox(file, variants, scale):
    os.write(1, b"noise")
    os.write(2, b"noise")
    what = os.path.basename(file).split(".")[0]
    if what == "fall":
        os.kill(os.getpid(), signal.SIGSEGV)
    while what == "spin":
        pass
    if what == "sleep":
        time.sleep(1e3)
    if what == "greedy":
        return {{"memory": True}}
    if what == "mistake":
        raise RuntimeError
    with open(file + ".log", "a") as log:
        log.write("read ")
    return {{"files": []}}

process.import_in_sandbox = import_in_sandbox
process.main()
"""
"""A process that does what a file's name says, and leaves a word beside the others."""


@pytest.fixture
def reader(tmp_path):
    """A reader whose process is the stand-in."""
    script = tmp_path / "stand_in.py"
    script.write_text(STAND_IN)
    reader = sandbox.Reader(script, computing_s=0.3)
    yield reader
    reader.close()


@pytest.fixture
def asked(monkeypatch):
    """The requests that the real process gets."""
    requests = []
    ask = sandbox.Reader._ask
    monkeypatch.setattr(sandbox.Reader, "_ask", lambda self, line: requests.append(line) or ask(self, line))
    return requests


def _file(folder, name):
    path = folder / name
    path.touch()
    return str(path)


def _crate(path, count=None):
    """A crate of twenty cubes. Its first value is the list of the root's one child; `count` is how many it claims."""
    stage = Usd.Stage.CreateInMemory()
    for i in range(20):
        UsdGeom.Cube.Define(stage, f"/World/b{i}")
    stage.GetRootLayer().Export(str(path))
    if count is not None:
        data = bytearray(path.read_bytes())
        assert data[88:96] == (1).to_bytes(8, "little")
        data[88] = count
        path.write_bytes(bytes(data))
    return path


def _gone(pid, seconds=20.0):
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        try:
            os.kill(pid, 0)
        except ProcessLookupError:
            return True
        time.sleep(0.01)
    return False


@pytest.mark.parametrize("where", ["crate", "package", "reference"])
def test_a_crate_that_ends_usd_core_is_refused_in_one_line(tmp_path, where):
    """A list of sixty children where there is one: the other names are whatever bytes follow."""
    crate = path = _crate(tmp_path / "damaged.usdc", count=60)
    opening = f"from pxr import Usd; Usd.Stage.Open({str(crate)!r})"
    alone = subprocess.run([sys.executable, "-c", opening], capture_output=True)
    if alone.returncode >= 0:
        pytest.skip("this usd-core survives the file")
    culprit = r"damaged: "
    if where == "package":
        path = tmp_path / "damaged.usdz"
        whole = _crate(tmp_path / "whole.usdc")
        UsdUtils.CreateNewUsdzPackage(Sdf.AssetPath(str(whole)), str(path))
        path.write_bytes(path.read_bytes().replace(whole.read_bytes(), crate.read_bytes()))
    elif where == "reference":
        path = tmp_path / "scene.usda"
        path.write_text("#usda 1.0\n(\n    subLayers = [@./damaged.usdc@]\n)\n")
        culprit = r"one of the binary files that it refers to is damaged \(damaged\.usdc\): "
    with pytest.raises(UsdImportError, match=rf"{path.name}: {culprit}reading it ends usd-core by SIG") as caught:
        load(path)
    assert "\n" not in str(caught.value)


def test_text_and_what_ships_is_read_by_this_process_alone(author, tmp_path, asked):
    a = author()
    a.stage.GetRootLayer().Export(str(tmp_path / "other.usda"))
    text = '#usda 1.0\n(\n    defaultPrim = "A"\n)\ndef "A" (\n    references = @./other.usda@\n)\n{\n}\n'
    (tmp_path / "scene.usd").write_text(text)
    load(tmp_path / "scene.usd")
    load(ASSETS_USD_DIR / "franka_panda.usda")  # its pictures are a crate
    load(a.stage)
    assert asked == []


def test_a_binary_file_is_read_first_once_while_it_and_what_it_refers_to_stay_as_they_are(tmp_path, asked):
    inner, outer = _crate(tmp_path / "inner.usdc"), tmp_path / "outer.usdc"
    layer = Sdf.Layer.CreateNew(str(outer))
    layer.subLayerPaths.append("./inner.usdc")
    layer.Save()
    del layer
    counts = []
    for change in (None, None, inner, None, outer):
        if change:
            os.utime(change, ns=(1, len(counts)))
        load(outer)
        counts.append(len(asked))
    load(outer, scale=2.0)
    assert [*counts, len(asked)] == [1, 1, 2, 2, 3, 4]


def test_the_layers_of_a_text_are_found_through_references_sublayers_variants_and_cycles(tmp_path):
    crate = _crate(tmp_path / "a.usdc")
    _crate(tmp_path / "b.usd")
    UsdUtils.CreateNewUsdzPackage(Sdf.AssetPath(str(crate)), str(tmp_path / "p.usdz"))
    texts = {
        "root.usda": "(\n    subLayers = [@./one.usda@, @./gone.usda@]\n)\n"
        'def "A" (\n    references = @./p.usdz[a.usdc]@</World>\n)\n{\n}\n',
        "one.usda": '(\n    subLayers = [@./root.usda@]\n)\ndef "A" (\n    variantSets = "v"\n)\n{\n'
        '    variantSet "v" = {\n        "x" (\n            payload = @./b.usd@\n        ) {\n        }\n    }\n}\n',
    }
    for name, text in texts.items():
        (tmp_path / name).write_text(f"#usda 1.0\n{text}")
    layers, binaries = sandbox.composed_of(tmp_path / "root.usda")
    assert sorted(Path(layer.realPath).name for layer in layers) == ["one.usda", "root.usda"]
    assert [Path(name).name for name in binaries] == ["b.usd", "p.usdz"]


@pytest.mark.parametrize(
    ("name", "reason"),
    [
        ("fall.usdc", "damaged: reading it ends usd-core by SIGSEGV"),
        ("spin.usdc", "damaged: reading it takes more than 0 s of computing"),
        ("greedy.usdc", "damaged: reading it takes more than 4.3 GB of memory, or more than there is"),
    ],
)
def test_a_file_that_ends_or_holds_up_the_process_is_refused_and_the_next_one_is_read(
    reader, tmp_path, name, reason, capfd
):
    path, good = _file(tmp_path, name), _file(tmp_path, "good.usdc")
    for _ in range(2):
        with pytest.raises(UsdImportError) as caught:
            reader.require(path, [path])
        assert str(caught.value) == f"{path}: {reason}"
    reader.require(good, [good])
    assert Path(good + ".log").read_text() == "read "
    assert capfd.readouterr() == ("", "")


def test_a_process_that_waits_for_ever_is_ended_by_the_clock(reader, tmp_path, monkeypatch):
    monkeypatch.setattr(sandbox, "PATIENCE", 1.0)
    path = _file(tmp_path, "sleep.usdc")
    with pytest.raises(UsdImportError, match="of computing"):
        reader.require(path, [path])


def test_an_error_in_python_is_left_to_this_process(reader, tmp_path):
    path = _file(tmp_path, "mistake.usdc")
    reader.require(path, [path])


def test_a_process_that_somebody_ended_is_no_verdict_on_the_next_file(reader, tmp_path):
    for name in ("one.usdc", "two.usdc"):
        path = _file(tmp_path, name)
        reader.require(path, [path])
        assert Path(path + ".log").read_text() == "read "
        os.kill(reader.pid, signal.SIGKILL)


def test_the_process_leaves_when_idle_and_nothing_of_it_stays(reader, tmp_path):
    reader._idle_s = 0.2
    path = _file(tmp_path, "one.usdc")
    descriptors = Path("/proc/self/fd")
    before = len(list(descriptors.iterdir())) if descriptors.exists() else 0
    reader.require(path, [path])
    pid = reader.pid
    assert _gone(pid)  # a process that nobody collected would still be there
    end = time.monotonic() + 20.0
    while reader.pid is not None and time.monotonic() < end:
        time.sleep(0.01)
    assert reader.pid is None
    assert (len(list(descriptors.iterdir())) if descriptors.exists() else 0) <= before
    other = _file(tmp_path, "two.usdc")
    reader.require(other, [other])
    assert reader.pid not in (None, pid)


def test_several_threads_wait_for_one_reading(reader, tmp_path):
    path = _file(tmp_path, "one.usdc")
    threads = [threading.Thread(target=reader.require, args=(path, [path])) for _ in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(60)
    assert Path(path + ".log").read_text() == "read "


@pytest.fixture
def fork():
    """Calls a function in a forked process, which it ends by `signal`; returns what the function returned, a number."""

    def call(function, how):
        reading, writing = os.pipe()
        child = os.fork()
        if child == 0:
            try:
                os.write(writing, str(function()).encode())
                os.kill(os.getpid(), how)
            finally:
                os._exit(1)
        os.close(writing)
        assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == -how
        with os.fdopen(reading) as answer:
            return int(answer.read())

    return call


@pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="processes are looked up in /proc")
@pytest.mark.filterwarnings("ignore::DeprecationWarning")
def test_a_forked_process_starts_one_of_its_own_which_ends_with_it(reader, tmp_path, fork):
    one, two, three = (_file(tmp_path, f"{name}.usdc") for name in ("one", "two", "three"))
    reader.require(one, [one])
    mine = reader.pid

    def other():
        reader.require(two, [two])
        return reader.pid

    other_pid = fork(other, signal.SIGKILL)
    assert other_pid != mine
    stat, end = Path(f"/proc/{other_pid}/stat"), time.monotonic() + 8.0
    while stat.exists() and stat.read_text().split()[2] != "Z" and time.monotonic() < end:
        time.sleep(0.01)
    # nobody may be there to collect it, but it has ended, and sooner than for want of work
    assert not stat.exists() or stat.read_text().split()[2] == "Z"
    reader.require(three, [three])
    assert reader.pid == mine


def test_where_no_process_can_be_started_a_warning_says_so_and_the_file_is_read(tmp_path, monkeypatch):
    monkeypatch.setattr(sandbox, "_reader", sandbox.Reader(tmp_path / "gone.py"))
    with pytest.warns(RuntimeWarning, match="does not start"):
        load(_crate(tmp_path / "one.usdc"))


def test_the_process_imports_no_learning_library(tmp_path):
    """They would make the first binary file wait for seconds."""
    answer = 'lambda *_: {"files": [], "memory": "torch" in sys.modules or "numpy" not in sys.modules}'
    script = tmp_path / "modules.py"
    script.write_text(f"{STAND_IN.split('sys.modules[')[0]}\nprocess.import_in_sandbox = {answer}\nprocess.main()\n")
    reader = sandbox.Reader(script)
    path = _file(tmp_path, "one.usdc")
    reader.require(path, [path])
    reader.close()
