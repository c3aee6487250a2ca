"""Asset paths, YAML, dictionaries, arrays, episodes, timers, seeds."""

import random
import sys

import numpy as np
import pytest
import torch

from lift_lab.utils import (
    Timer,
    TimerError,
    assets,
    class_to_dict,
    configclass,
    configure_seed,
    convert_dict_to_backend,
    convert_to_torch,
    dict_to_md5_hash,
    print_dict,
    replace_slices_with_strings,
    replace_strings_with_slices,
    update_dict,
)
from lift_lab.utils.datasets import EpisodeData, HDF5DatasetFileHandler
from lift_lab.utils.errors import FileError, LiftLabError
from lift_lab.utils.io import dump_yaml, load_torchscript_model, load_yaml

##
# Assets
##


@pytest.fixture
def usd_dir(tmp_path, monkeypatch):
    folder = tmp_path / "usd"
    folder.mkdir()
    for name in ("franka_panda.usda", "cube.usda", "table.usda", "cartpole.usda"):
        (folder / name).write_text(f"#usda 1.0 {name}")
    names = {"panda_instanceable.usd": "franka_panda.usda", "table_instanceable.usd": "table.usda"}
    names["dex_cube_instanceable.usd"] = "cube.usda"
    assets.shipped_folders()  # the files that ship are registered, and put aside
    monkeypatch.setattr(assets, "_shipped_files", {})
    assets.register_assets(folder, names)
    return folder


@pytest.mark.parametrize(
    ("path", "name"),
    [
        (f"{assets.ISAACLAB_NUCLEUS_DIR}/Robots/FrankaEmika/panda_instanceable.usd", "franka_panda.usda"),
        (f"{assets.ISAAC_NUCLEUS_DIR}/Props/Blocks/DexCube/dex_cube_instanceable.usd", "cube.usda"),
        (f"{assets.ISAAC_NUCLEUS_DIR}/Props/Mounts/SeattleLabTable/table_instanceable.usd", "table.usda"),
        (f"{assets.ISAACLAB_NUCLEUS_DIR}/Robots/Classic/Cartpole/cartpole.usd", "cartpole.usda"),
        ("https://server/Assets/Isaac/Props/Blocks/DexCube/dex_cube_instanceable.usd", "cube.usda"),
        ("cube.usda", "cube.usda"),
    ],
)
def test_asset_paths_lead_to_the_files_that_ship(usd_dir, path, name):
    assert assets.resolve_usd_path(path) == usd_dir / name
    assert assets.check_file_path(path) == 2
    assert assets.retrieve_file_path(path) == str(usd_dir / name)
    assert assets.read_file(path).read().endswith(name.encode())


def test_a_local_file_is_taken_as_it_is(usd_dir, tmp_path):
    file = tmp_path / "own.usda"
    file.write_text("#usda 1.0")
    assert assets.resolve_usd_path(file) == file
    assert assets.resolve_usd_path(str(file)) == file
    assert assets.check_file_path(str(file)) == 1


def test_an_asset_may_be_copied_to_a_folder(usd_dir, tmp_path):
    path = f"{assets.ISAAC_NUCLEUS_DIR}/dex_cube_instanceable.usd"
    copied = tmp_path / "download" / "cube.usda"
    assert assets.retrieve_file_path(path, download_dir=str(copied.parent)) == str(copied)
    copied.write_text("mine")
    assets.retrieve_file_path(path, download_dir=str(copied.parent), force_download=False)
    assert copied.read_text() == "mine"
    assets.retrieve_file_path(path, download_dir=str(copied.parent))
    assert copied.read_text() != "mine"


@pytest.mark.parametrize(
    ("path", "message"),
    [
        (f"{assets.ISAAC_NUCLEUS_DIR}/Props/dex_cube.usd", "no local asset stands for .*'dex_cube_instanceable.usd'"),
        ("cubes.usda", r"no file 'cubes.usda'.* did you mean 'cube.usda'"),
        ("nowhere/cube.usda", "no file 'nowhere/cube.usda'"),
    ],
)
def test_a_file_that_does_not_exist_is_refused_with_the_nearest_names(usd_dir, path, message):
    assert assets.check_file_path(path) == 0
    with pytest.raises(FileNotFoundError, match=message) as error:
        assets.resolve_usd_path(path)
    assert isinstance(error.value, FileError)


##
# YAML
##


@configclass
class YamlCfg:
    values = (1.0, 2)
    nested = {"names": ["a"], "part": slice(None, 3), "func": update_dict}
    small = 1e-05
    unset: int | None = None
    array = np.arange(2)
    tensor = torch.ones(2)
    scalar = np.float32(0.5)
    device = torch.device("cpu")


def test_a_configuration_survives_the_way_through_yaml(tmp_path):
    file = tmp_path / "params" / "env.yaml"
    cfg = YamlCfg()
    shared = [1]
    cfg.nested["a"], cfg.nested["b"] = shared, shared
    dump_yaml(file, cfg)
    data = load_yaml(file)
    assert data["values"] == (1.0, 2)
    assert data["nested"]["part"] == "slice(None,3,None)"
    assert data["nested"]["func"] == "lift_lab.utils.dict:update_dict"
    assert data["small"] == 1e-05
    assert (data["array"], data["tensor"], data["scalar"], data["device"]) == ([0, 1], [1.0, 1.0], 0.5, "cpu")
    assert list(data) == list(cfg.to_dict())
    assert "&id" not in file.read_text()
    again = YamlCfg()
    again.from_dict(
        {key: data[key] for key in ("values", "small", "array", "tensor")} | {"nested": {"part": "slice(1,2,3)"}}
    )
    assert again.nested["part"] == slice(1, 2, 3)
    assert again.values == (1.0, 2)


def test_yaml_reads_numbers_with_an_exponent_and_runs_no_code(tmp_path):
    file = tmp_path / "a.yaml"
    file.write_text("a: 1e-3\nb: -2E5\nc: 1e3x\n")
    assert load_yaml(file) == {"a": 1e-3, "b": -2e5, "c": "1e3x"}
    file.write_text("a: !!python/object/apply:os.system ['true']\n")
    with pytest.raises(Exception, match="could not determine a constructor"):
        load_yaml(file)


def test_yaml_files_get_their_ending_and_missing_ones_are_named(tmp_path):
    dump_yaml(str(tmp_path / "agent"), {"b": 1, "a": 2}, sort_keys=True)
    assert list(load_yaml(tmp_path / "agent.yaml")) == ["a", "b"]
    with pytest.raises(FileNotFoundError, match="no file"):
        load_yaml(tmp_path / "none.yaml")


def test_a_torchscript_model_is_loaded_for_evaluation(tmp_path):
    file = tmp_path / "model.pt"
    torch.jit.save(torch.jit.trace(torch.nn.Linear(2, 1).train(), torch.zeros(1, 2)), str(file))
    model = load_torchscript_model(file)
    assert not model.training
    with pytest.raises(FileNotFoundError):
        load_torchscript_model(tmp_path / "none.pt")


##
# Dictionaries and arrays
##


def test_slices_become_text_and_back_at_any_depth():
    data = {"a": [slice(None), {"b": slice(1, 2, 3)}], "c": (slice(4),), "d": "text"}
    text = replace_slices_with_strings(data)
    assert text == {
        "a": ["slice(None,None,None)", {"b": "slice(1,2,3)"}],
        "c": ("slice(None,4,None)",),
        "d": "text",
    }
    assert replace_strings_with_slices(text) == data


def test_dictionaries_merge_level_by_level():
    merged = update_dict({"a": {"b": 1, "c": 2}, "d": 3}, {"a": {"c": 4}, "d": {"e": 5}})
    assert merged == {"a": {"b": 1, "c": 4}, "d": {"e": 5}}


def test_the_hash_depends_on_the_values_and_not_on_the_order():
    assert dict_to_md5_hash({"a": 1, "b": 2}) == dict_to_md5_hash({"b": 2, "a": 1})
    assert dict_to_md5_hash({"a": 1}) != dict_to_md5_hash({"a": 2})


def test_a_printed_dictionary_is_indented_and_names_callables(capsys):
    print_dict({"a": {"b": 1, "f": update_dict}})
    assert capsys.readouterr().out == "a: \n    b: 1\n    f: lift_lab.utils.dict:update_dict\n"


def test_arrays_in_dictionaries_change_their_library():
    data = {"a": torch.ones(2), "b": {"c": np.zeros(2)}, "d": [1]}
    as_numpy = convert_dict_to_backend(data, "numpy")
    assert isinstance(as_numpy["a"], np.ndarray)
    assert as_numpy["d"] == [1]
    as_torch = convert_dict_to_backend(data, "torch")
    assert isinstance(as_torch["b"]["c"], torch.Tensor)
    with pytest.raises(ValueError, match="unknown array library 'jax'"):
        convert_dict_to_backend(data, "jax")


@pytest.mark.parametrize("array", [[1, 2], (1, 2), np.array([1, 2]), np.array([1, 2], np.uint32), torch.tensor([1, 2])])
def test_anything_like_an_array_becomes_a_tensor(array):
    tensor = convert_to_torch(array, dtype=torch.float32, device="cpu")
    assert tensor.dtype == torch.float32
    assert tensor.tolist() == [1.0, 2.0]


def test_a_tensor_shares_the_memory_of_its_array():
    array = np.zeros(2)
    convert_to_torch(array)[0] = 1.0
    assert array[0] == 1.0


def test_plain_values_pass_through_class_to_dict():
    assert class_to_dict([1, (2, "a")]) == [1, (2, "a")]
    assert class_to_dict(3.5) == 3.5


##
# Episodes
##


@pytest.fixture
def episode() -> EpisodeData:
    episode = EpisodeData()
    episode.add("initial_state", {"robot": {"joint_pos": torch.zeros(2)}})
    for step in range(3):
        episode.add("actions", torch.full((2,), float(step)))
        episode.add("states", {"robot": {"joint_pos": torch.full((2,), 10.0 + step)}})
        episode.add("joint_targets/robot", torch.full((2,), 20.0 + step))
    episode.seed = 3
    episode.success = True
    episode.pre_export()
    return episode


def test_an_episode_is_played_back_step_by_step(episode):
    assert [float(episode.get_next_action()[0]) for _ in range(3)] == [0.0, 1.0, 2.0]
    assert episode.get_next_action() is None
    assert episode.get_next_state()["robot"]["joint_pos"].tolist() == [[10.0, 10.0]]
    assert episode.get_state(2)["robot"]["joint_pos"].shape == (1, 2)
    assert episode.get_state(3) is None
    assert episode.get_next_joint_target()["robot"].tolist() == [20.0, 20.0]
    assert episode.next_joint_target_index == 1
    assert episode.get_initial_state()["robot"]["joint_pos"].shape == (1, 2)


def test_an_empty_episode_has_nothing_to_play():
    episode = EpisodeData()
    assert episode.is_empty()
    assert episode.get_next_action() is episode.get_next_state() is episode.get_next_joint_target() is None
    assert episode.get_initial_state() is None


def test_a_recorded_value_is_a_copy():
    episode, value = EpisodeData(), torch.zeros(1)
    episode.add("a/b", value)
    value += 1.0
    assert episode.data["a"]["b"][0].tolist() == [0.0]


def test_episodes_are_written_to_a_file_and_read_back(tmp_path, episode):
    pytest.importorskip("h5py")
    handler = HDF5DatasetFileHandler()
    handler.create(str(tmp_path / "sub" / "demos"), env_name="Lift")
    handler.write_episode(episode)
    handler.write_episode(EpisodeData())
    handler.write_episode(episode, demo_id=7)
    with pytest.raises(ValueError, match="'demo_7' already"):
        handler.write_episode(episode, demo_id=7)
    handler.flush()
    handler.close()

    handler.open(str(tmp_path / "sub" / "demos.hdf5"))
    assert handler.get_num_episodes() == 2
    assert list(handler.get_episode_names()) == ["demo_0", "demo_7"]
    assert handler.get_env_name() == "Lift"
    loaded = handler.load_episode("demo_0", "cpu")
    assert loaded.seed == 3
    assert bool(loaded.success)
    torch.testing.assert_close(loaded.data, episode.data)
    assert handler.load_episode("demo_1") is None
    with pytest.raises(RuntimeError, match="open already"):
        handler.open("other")
    handler.close()
    with pytest.raises(RuntimeError, match="no file is open"):
        handler.get_env_name()


def test_without_h5py_the_error_names_the_package(monkeypatch):
    monkeypatch.setitem(sys.modules, "h5py", None)
    with pytest.raises(ImportError, match="need the package h5py") as error:
        HDF5DatasetFileHandler()
    assert isinstance(error.value, LiftLabError)


##
# Timer and seed
##


def test_a_timer_measures_prints_and_remembers(capsys):
    with Timer("work took", name="work") as timer:
        assert timer.time_elapsed >= 0.0
    assert capsys.readouterr().out == f"work took: {timer.total_run_time:0.6f} seconds\n"
    assert Timer.get_timer_info("work") == timer.total_run_time
    assert str(timer) == f"{timer.total_run_time:0.6f} seconds"
    with pytest.raises(TimerError, match="did you mean 'work'"):
        Timer.get_timer_info("works")


def test_a_timer_out_of_order_is_refused():
    timer = Timer()
    for misuse in (timer.stop, lambda: timer.total_run_time):
        with pytest.raises(TimerError):
            misuse()
    timer.start()
    with pytest.raises(TimerError):
        timer.start()


def test_a_seed_fixes_every_generator():
    def draw() -> tuple:
        return random.random(), float(np.random.rand()), float(torch.rand(()))  # noqa: NPY002

    assert configure_seed(5) == 5
    first = draw()
    configure_seed(5)
    assert draw() == first
    assert 0 <= configure_seed(None) <= 10000
    try:
        assert configure_seed(-1, torch_deterministic=True) == 42
        assert torch.are_deterministic_algorithms_enabled()
    finally:
        configure_seed(0)
    assert not torch.are_deterministic_algorithms_enabled()


@pytest.mark.parametrize("damage", ["text", "cut", "no episodes", "wrong arguments"])
def test_a_damaged_dataset_is_named_in_one_line(tmp_path, damage):
    h5py = pytest.importorskip("h5py")
    path = tmp_path / "demos.hdf5"
    handler = HDF5DatasetFileHandler()
    handler.create(str(path), "Cartpole")
    handler.close()
    if damage == "text":
        path.write_text("words")
    elif damage == "cut":
        path.write_bytes(path.read_bytes()[:300])
    elif damage == "no episodes":
        h5py.File(path, "w").close()
    else:
        with h5py.File(path, "a") as file:
            file["data"].attrs["env_args"] = "[1, 2]"
    with pytest.raises(FileError, match=rf"^cannot read '{path}': damaged, or no file of episodes \(.*\)$"):
        HDF5DatasetFileHandler().open(str(path))
    path.unlink()  # nothing holds it
