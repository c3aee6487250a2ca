"""Recordings: hooks, episodes, export by mode; nothing without terms."""

import json
from types import SimpleNamespace

import pytest
import torch

from lift_lab.managers import (
    DatasetExportMode,
    RecorderManager,
    RecorderManagerBaseCfg,
    RecorderTerm,
    RecorderTermCfg,
)
from lift_lab.utils import configclass

h5py = pytest.importorskip("h5py")


class Steps(RecorderTerm):
    """Records the environment's clock, which tests advance, at every stage."""

    def record_pre_step(self):
        return "actions", torch.arange(self.num_envs).unsqueeze(1) + self._env.clock

    def record_post_step(self):
        return "states", {"arm": {"pos": torch.full((self.num_envs, 2), self._env.clock)}}

    def record_pre_reset(self, env_ids):
        return "last", torch.full((len(env_ids), 1), -1.0)

    def record_post_reset(self, env_ids):
        return "initial", torch.full((len(env_ids), 1), 1.0)

    def close(self, file_path):
        self._env.calls.append("closed")


class Silent(RecorderTerm):
    pass


@configclass
class Recorders(RecorderManagerBaseCfg):
    steps = RecorderTermCfg(class_type=Steps)
    silent = RecorderTermCfg(class_type=Silent)


@pytest.fixture
def env(env_factory):
    cfg = SimpleNamespace(
        sim=SimpleNamespace(dt=0.01, render_interval=2),
        decimation=2,
        scene=SimpleNamespace(num_envs=3),
        env_name="Lift",
    )
    return env_factory(num_envs=3, cfg=cfg, clock=0.0)


@pytest.fixture
def make(env, tmp_path):
    def make(**fields):
        return RecorderManager(Recorders(dataset_export_dir_path=str(tmp_path), **fields), env)

    return make


def step(env, manager):
    manager.record_pre_step()
    env.clock += 1.0
    manager.record_post_step()


def read(path):
    """Episodes of a file: name -> (attributes, arrays by path)."""
    with h5py.File(path, "r") as file:
        episodes = {}
        for name, episode in file["data"].items():
            arrays = {}
            episode.visititems(
                lambda key, item, arrays=arrays: arrays.update({key: item}) if hasattr(item, "shape") else None
            )
            episodes[name] = (dict(episode.attrs), {key: item[()].tolist() for key, item in arrays.items()})
        return episodes


def test_episodes_hold_one_entry_for_each_step(env, make):
    manager = make()
    step(env, manager)
    step(env, manager)
    data = manager.get_episode(2).data
    assert torch.stack(data["actions"]).tolist() == [[2.0], [3.0]]
    assert torch.stack(data["states"]["arm"]["pos"]).tolist() == [[1.0, 1.0], [2.0, 2.0]]


def test_an_episode_is_exported_when_its_environment_resets(env, make, tmp_path):
    manager = make()
    step(env, manager)
    manager.record_pre_reset(torch.tensor([1]))
    manager.reset(torch.tensor([1]))
    manager.record_post_reset(torch.tensor([1]))
    assert manager.get_episode(1).data.keys() == {"initial"}
    assert "actions" in manager.get_episode(0).data
    manager.close()
    episodes = read(tmp_path / "dataset.hdf5")
    assert list(episodes) == ["demo_0"]
    attributes, arrays = episodes["demo_0"]
    assert attributes["num_samples"] == 1
    assert not attributes["success"]
    assert arrays == {"actions": [[1.0]], "states/arm/pos": [[1.0, 1.0]], "last": [[-1.0]]}


def test_the_file_names_the_environment_and_its_time_step(env, make, tmp_path):
    manager = make()
    step(env, manager)
    manager.record_pre_reset(None)
    manager.close()
    with h5py.File(tmp_path / "dataset.hdf5", "r") as file:
        arguments = json.loads(file["data"].attrs["env_args"])
    assert arguments["env_name"] == "Lift"
    assert arguments["sim_args"] == {"dt": 0.01, "decimation": 2, "render_interval": 2, "num_envs": 3}


@pytest.mark.parametrize(
    ("mode", "succeeded", "failed"),
    [
        (DatasetExportMode.EXPORT_NONE, None, None),
        (DatasetExportMode.EXPORT_ALL, [0.0, 1.0, 2.0], None),
        (DatasetExportMode.EXPORT_SUCCEEDED_ONLY, [1.0], None),
        (DatasetExportMode.EXPORT_SUCCEEDED_FAILED_IN_SEPARATE_FILES, [1.0], [0.0, 2.0]),
    ],
)
def test_the_mode_decides_which_episodes_go_where(env, make, tmp_path, mode, succeeded, failed):
    env.termination_manager = SimpleNamespace(
        active_terms=["success"], get_term=lambda name: torch.tensor([False, True, False])
    )
    manager = make(dataset_export_mode=mode)
    step(env, manager)
    manager.record_pre_reset(None)
    manager.close()
    for name, expected in (("dataset", succeeded), ("dataset_failed", failed)):
        path = tmp_path / f"{name}.hdf5"
        assert path.exists() == (expected is not None)
        if expected is not None:
            assert [arrays["actions"][0][0] for _, arrays in read(path).values()] == expected
    assert manager.exported_successful_episode_count == 1
    assert manager.exported_failed_episode_count == 2


def test_success_is_that_of_the_environments_that_reset(env, make):
    env.termination_manager = SimpleNamespace(
        active_terms=["success"], get_term=lambda name: torch.tensor([False, True, False])
    )
    manager = make(export_in_record_pre_reset=False)
    step(env, manager)
    manager.record_pre_reset(torch.tensor([1, 2]))
    assert [manager.get_episode(env_id).success for env_id in (1, 2)] == [True, False]


def test_exports_can_be_held_back_and_numbered(env, make, tmp_path):
    manager = make(export_in_record_pre_reset=False)
    step(env, manager)
    manager.record_pre_reset([0])
    assert not manager.get_episode(0).is_empty()
    with pytest.raises(ValueError, match="demo_ids"):
        manager.export_episodes([0, 1], demo_ids=[5, 5])
    manager.export_episodes([0, 1], demo_ids=[5, 7])
    assert manager.get_episode(0).is_empty()
    manager.close()
    assert list(read(tmp_path / "dataset.hdf5")) == ["demo_5", "demo_7"]


@pytest.mark.parametrize(("export_in_close", "count"), [(True, 3), (False, 0)])
def test_unfinished_episodes_are_exported_at_the_close_if_asked_for(env, make, tmp_path, export_in_close, count):
    manager = make(export_in_close=export_in_close)
    step(env, manager)
    manager.close()
    assert len(read(tmp_path / "dataset.hdf5")) == count
    assert env.calls == ["closed"]


def test_a_reset_drops_what_was_not_exported(env, make):
    manager = make()
    step(env, manager)
    manager.reset([0])
    assert manager.get_episode(0).is_empty()
    assert not manager.get_episode(1).is_empty()


@pytest.mark.parametrize("cfg", [None, {}, RecorderManagerBaseCfg(), Recorders(steps=None, silent=None)])
def test_without_terms_nothing_is_done_or_written(env, tmp_path, monkeypatch, cfg):
    monkeypatch.chdir(tmp_path)
    manager = RecorderManager(cfg, env)
    step(env, manager)
    manager.record_post_physics_decimation_step()
    manager.record_pre_reset(None)
    manager.record_post_reset(None)
    assert manager.reset() == {}
    manager.export_episodes()
    manager.close()
    assert manager.active_terms == []
    assert list(tmp_path.iterdir()) == []


def test_terms_need_a_recorder_config(env):
    with pytest.raises(TypeError, match="RecorderManagerBaseCfg"):
        RecorderManager({"steps": RecorderTermCfg(class_type=Steps)}, env)
    with pytest.raises(TypeError, match="'steps' must be of type RecorderTermCfg"):
        RecorderManager(Recorders(steps=3), env)


def test_the_table_lists_the_terms(make):
    assert "silent" in str(make())
    assert not make().has_debug_vis_implementation
