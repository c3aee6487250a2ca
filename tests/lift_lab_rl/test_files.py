"""Files are whole or not there, and what cannot be written or read is named with its path."""

import hashlib
import re
import resource
import zipfile

import pytest
import torch

from lift_lab.utils.errors import FileError
from lift_lab_rl.digest import damage
from lift_lab_rl.files import check_target, load_torch, read_json, save_torch, write_atomically
from lift_lab_rl.run_params import read_params


@pytest.mark.parametrize("check", [check_target, lambda path: write_atomically(path, b"x")])
def test_a_target_that_cannot_be_written_is_named(tmp_path, check):
    (tmp_path / "file").touch()
    (tmp_path / "folder").mkdir()
    for path in (tmp_path / "folder", tmp_path / "file" / "a.json"):
        with pytest.raises(FileError, match=f"cannot write '{path}': "):
            check(path)
    assert sorted(entry.name for entry in tmp_path.iterdir()) == ["file", "folder"]
    check(tmp_path / "new" / "a.json")


def test_a_full_disk_is_one_line_with_the_path(tmp_path):
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (1000, before[1]))  # Python ignores the signal of a file too large
    try:
        with pytest.raises(FileError, match=r"cannot write '.*a\.pt': File too large"):
            write_atomically(tmp_path / "a.pt", bytes(5000))
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    assert list(tmp_path.iterdir()) == []


def test_a_file_that_is_no_checkpoint_is_told_in_plain_words(tmp_path):
    torch.save({"iter": 1, "x": torch.zeros(100)}, tmp_path / "whole.pt")
    torch.jit.script(torch.nn.Linear(1, 1)).save(str(tmp_path / "scripted.pt"))
    (tmp_path / "cut.pt").write_bytes((tmp_path / "whole.pt").read_bytes()[:400])
    (tmp_path / "README.md").write_text("# Words")
    (tmp_path / "policy.onnx").write_bytes(b"\x08\x0a\x12\x07pytorch\xff")
    for name in ("scripted.pt", "cut.pt", "README.md", "policy.onnx"):
        with pytest.raises(FileError, match=rf"cannot read '.*{name}': it is no checkpoint \(model_N\.pt\)"):
            load_torch(tmp_path / name)
    assert load_torch(tmp_path / "whole.pt")["iter"] == 1
    with pytest.raises(FileError, match=r"policy\.onnx': it is not JSON"):
        read_json(tmp_path / "policy.onnx")


@pytest.mark.parametrize("content", [b"a: [", b"\xff\xfe\x00", b"- 1", b"words"])
def test_settings_that_cannot_be_read_are_named(tmp_path, content):
    (tmp_path / "params").mkdir()
    (tmp_path / "params" / "agent.yaml").write_bytes(content)
    with pytest.raises(FileError, match=r"cannot read '.*agent\.yaml': "):
        read_params(tmp_path, "agent")
    assert read_params(tmp_path, "run") == {}


# -- damage


def flipped(data: bytes, position: int) -> bytes:
    """``data`` with one bit of one byte changed."""
    return data[:position] + bytes([data[position] ^ 0x10]) + data[position + 1 :]


def test_one_flipped_byte_anywhere_is_noticed(tmp_path):
    path = tmp_path / "model_3.pt"
    save_torch(path, {"x": torch.arange(5.0), "y": {"z": [1, "text"]}})
    data = path.read_bytes()
    assert damage(data) is None
    assert all(damage(flipped(data, position)) for position in range(len(data)))
    for position in range(0, len(data), 97):
        path.write_bytes(flipped(data, position))
        with pytest.raises(FileError, match=r"^cannot read '.*model_3\.pt': [^\n]+$"):
            load_torch(path)
    path.write_bytes(data)
    assert torch.equal(load_torch(path)["x"], torch.arange(5.0))


def test_a_file_with_a_digest_is_an_ordinary_torch_file(tmp_path):
    save_torch(tmp_path / "model_3.pt", {"x": torch.arange(5.0)})
    assert torch.equal(torch.load(tmp_path / "model_3.pt", weights_only=True)["x"], torch.arange(5.0))
    with zipfile.ZipFile(tmp_path / "model_3.pt") as archive:
        assert archive.testzip() is None
        covered = (tmp_path / "model_3.pt").read_bytes()[:-64]
        assert archive.comment == b"lift-lab sha256 " + hashlib.sha256(covered).hexdigest().encode()


def test_a_file_without_a_digest_loads_and_its_numbers_are_checked(tmp_path):
    path = tmp_path / "model_3.pt"
    numbers = torch.arange(100.0)
    torch.save({"x": numbers}, path)
    assert torch.equal(load_torch(path)["x"], numbers)
    data = path.read_bytes()
    start = data.index(numbers.numpy().tobytes())
    for position in range(start, start + 400, 7):
        path.write_bytes(flipped(data, position))
        with pytest.raises(FileError, match="the file is damaged"):
            load_torch(path)


@pytest.mark.parametrize("change", [lambda data: data + b"\0", lambda data: data[:-1], lambda data: data[1:]])
def test_a_longer_or_shorter_file_is_noticed(tmp_path, change):
    for write in (save_torch, lambda path, content: torch.save(content, path)):
        write(tmp_path / "a.pt", {"x": torch.zeros(3)})
        (tmp_path / "a.pt").write_bytes(change((tmp_path / "a.pt").read_bytes()))
        with pytest.raises(FileError, match=r"^cannot read '[^\n]+$"):
            load_torch(tmp_path / "a.pt")


@pytest.mark.parametrize(
    ("name", "content", "says"),
    [
        ("run", "task: 5", "'task' is '5'; it must be text"),
        ("run", "task: T\noverrides: 3", "'overrides' is '3'; it must be a list of texts"),
        ("run", "overrides: [1, null]", "'overrides' is '[1, None]'; it must be a list of texts"),
        ("run", "continues: {a: 1}", "'continues' is"),
        ("agent", "seed: [1]", "'seed' is '[1]'; it must be a whole number"),
        ("agent", "run_name: {a: 1}", "'run_name' is"),
    ],
)
def test_settings_of_another_type_are_named(tmp_path, name, content, says):
    (tmp_path / "params").mkdir()
    (tmp_path / "params" / f"{name}.yaml").write_text(content)
    with pytest.raises(FileError, match=rf"cannot read '.*{name}\.yaml': {re.escape(says)}"):
        read_params(tmp_path, name)
