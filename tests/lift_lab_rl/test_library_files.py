"""Files of the learning libraries are told apart, and none is read by running code that is in it."""

import io
import os
import pickle
import zipfile

import pytest
import torch

from lift_lab.utils.errors import ConfigError, FileError
from lift_lab_rl.files import save_torch
from lift_lab_rl.library_files import is_sb3_model, read_skrl, read_states
from lift_lab_rl.library_files import read_sb3 as read_model
from lift_lab_rl.rsl_rl.checkpoint_file import read_checkpoint

READERS = {"rsl_rl": read_checkpoint, "skrl": read_skrl, "sb3": read_model}
NAMES = {"rsl_rl": "rsl_rl", "skrl": "skrl", "sb3": "Stable-Baselines3"}


class Marker:
    """Makes a folder when it is unpickled."""

    def __init__(self, path):
        self.path = path

    def __reduce__(self):
        return os.mkdir, (str(self.path),)


def torch_bytes(content):
    buffer = io.BytesIO()
    torch.save(content, buffer)
    return buffer.getvalue()


def write_model(path, policy, **more):
    """A model in Stable-Baselines3's form."""
    entries = {"data": b"{}", "policy.pth": policy, "policy.optimizer.pth": torch_bytes({"state": {}}), **more}
    with zipfile.ZipFile(path, "w") as archive:
        for name, content in entries.items():
            archive.writestr(name, content)
    return path


@pytest.fixture
def files(tmp_path):
    """One file of each library."""
    state = {"weight": torch.ones(2)}
    save_torch(tmp_path / "model_1.pt", {"actor_state_dict": state, "iter": 1, "infos": {}})
    torch.save({"policy": state, "value": state, "optimizer": {"state": {}}}, tmp_path / "agent_1.pt")
    write_model(tmp_path / "model.zip", torch_bytes(state))
    return {"rsl_rl": tmp_path / "model_1.pt", "skrl": tmp_path / "agent_1.pt", "sb3": tmp_path / "model.zip"}


@pytest.mark.parametrize("owner", READERS)
@pytest.mark.parametrize("reader", READERS)
def test_a_checkpoint_is_read_by_its_own_library_and_refused_by_the_others(files, owner, reader):
    if owner == reader:
        assert READERS[reader](files[owner])
        return
    with pytest.raises(ConfigError) as caught:
        READERS[reader](files[owner])
    message = str(caught.value)
    assert message.endswith(
        f"is a checkpoint of {NAMES[owner]}, not of {NAMES[reader]}: use lift-lab train or play with --library {owner}"
    )
    assert str(files[owner]) in message


def test_code_in_a_file_is_not_run_and_the_line_says_why(tmp_path):
    marker = tmp_path / "made"
    torch.save({"policy": Marker(marker), "optimizer": {}}, tmp_path / "agent.pt")
    write_model(tmp_path / "model.zip", torch_bytes({"weight": Marker(marker)}))
    torch.save({"policy": Marker(marker)}, tmp_path / "older.pt", _use_new_zipfile_serialization=False)
    (tmp_path / "plain.pkl").write_bytes(pickle.dumps(Marker(marker)))
    for name, read in (
        ("agent.pt", read_skrl),
        ("model.zip", read_model),
        ("older.pt", read_skrl),
        ("plain.pkl", read_states),
    ):
        with pytest.raises(FileError, match=r"holds pickled Python objects.* runs code .*; add --trust"):
            read(tmp_path / name)
        assert not marker.exists()
    read_skrl(tmp_path / "agent.pt", trust=True)
    assert marker.is_dir()


def test_the_description_of_a_model_is_never_read(tmp_path):
    """Stable-Baselines3 keeps pickles in it, in base64."""
    path = write_model(tmp_path / "model.zip", torch_bytes({"weight": torch.ones(2)}), data=b"\x00 not JSON")
    assert torch.equal(read_model(path)["policy"]["weight"], torch.ones(2))
    assert set(read_model(path)) == {"policy", "policy.optimizer"}


@pytest.mark.parametrize("reader", [read_skrl, read_model, read_states])
@pytest.mark.parametrize("content", [b"", b"not a model", b"PK\x03\x04 half a zip", b"\x80\x02half a pickle"])
def test_a_broken_file_is_named_in_one_line(tmp_path, reader, content):
    path = tmp_path / "agent_3.pt"
    path.write_bytes(content)
    with pytest.raises((FileError, ConfigError), match=r"agent_3\.pt") as caught:
        reader(path)
    assert "\n" not in str(caught.value)
    with pytest.raises(FileError, match="no file"):
        reader(tmp_path / "nothing.pt")


def test_a_number_that_is_not_finite_is_named(tmp_path):
    torch.save({"policy": {"weight": torch.tensor([1.0, float("nan")])}, "optimizer": {}}, tmp_path / "agent.pt")
    with pytest.raises(FileError, match=r"numbers that are not finite, in 'policy\.weight'"):
        read_skrl(tmp_path / "agent.pt")


def test_one_changed_byte_of_a_model_is_noticed(tmp_path):
    path = write_model(tmp_path / "model.zip", torch_bytes({"weight": torch.ones(200)}))
    data = bytearray(path.read_bytes())
    data[data.find(torch.ones(4).numpy().tobytes()) + 3] ^= 1
    path.write_bytes(data)
    assert is_sb3_model(path)
    with pytest.raises(FileError, match="damaged"):
        read_model(path)
