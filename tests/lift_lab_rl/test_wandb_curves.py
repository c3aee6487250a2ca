"""W&B gets what TensorBoard gets, and training does not end because of it."""

import importlib.util
import json
import os
import signal
import subprocess
import sys
import types
from pathlib import Path

import pytest
import torch
from point_task import AgentCfg, train
from tensorboard.backend.event_processing.event_accumulator import EventAccumulator

from lift_lab.utils import configclass
from lift_lab.utils.errors import ConfigError, LiftLabError, MissingPackageError
from lift_lab_rl.rsl_rl import to_rsl_rl
from lift_lab_rl.rsl_rl.wandb_writer import LoggerError, WandbWriter, require_logger
from lift_lab_tasks.utils.hydra import compose

INSTALLED = getattr(importlib.util.find_spec("wandb"), "origin", None) is not None


class NoKeyError(Exception):
    """An error of W&B's."""


NoKeyError.__module__ = "wandb.errors"


class Run:
    """Notes what is told to it; fails with ``error`` where one is set."""

    def __init__(self):
        self.logged, self.files, self.finished, self.error = [], [], False, None
        self.config, self.metrics = {}, {}

    def define_metric(self, name, summary=None):
        self.metrics[name] = summary

    def _fail(self):
        if self.error is not None:
            raise self.error

    def log(self, values, step=None, commit=None):
        self._fail()
        self.logged.append((step, dict(values), commit))

    def save(self, path, base_path=None, policy=None):
        self._fail()
        self.files.append(os.path.relpath(path, base_path))

    def finish(self):
        self._fail()
        self.finished = True


@pytest.fixture
def wandb(monkeypatch):
    """A package of that name, whose one run notes what is told to it."""
    fake: types.ModuleType = types.ModuleType("wandb")
    fake.__spec__ = importlib.util.spec_from_loader("wandb", None, origin="a test")
    run, asked = Run(), {}

    def init(**kwargs):
        asked.update(kwargs)
        run._fail()
        return run

    fake.run, fake.asked, fake.init, fake.Settings = run, asked, init, dict
    fake.Video = lambda path, format: (format, Path(path).name)
    monkeypatch.setitem(sys.modules, "wandb", fake)
    for name in ("WANDB_DIR", "WANDB_USERNAME", "WANDB_INIT_TIMEOUT"):
        monkeypatch.delenv(name, raising=False)
    return fake


@pytest.fixture
def without_wandb(monkeypatch):
    """As if it were not installed, beside a folder of that name, as W&B leaves one."""
    spec = importlib.util.spec_from_loader("wandb", None, is_package=True)
    monkeypatch.delitem(sys.modules, "wandb", raising=False)
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: spec if name == "wandb" else None)


def curves(folder):
    """Tag -> [(step, value)] of TensorBoard's files."""
    events = EventAccumulator(str(folder))
    events.Reload()
    return {tag: [(e.step, e.value) for e in events.Scalars(tag)] for tag in events.Tags()["scalars"]}


def test_values_of_an_iteration_are_one_message_and_are_in_tensorboards_files_too(wandb, tmp_path):
    writer = WandbWriter(str(tmp_path), "a project")
    for step in (1, 2):
        writer.add_scalar("Train/mean_reward", 0.5 * step, step)
        writer.add_scalar("Loss/value", torch.tensor(2.0), step)
        writer.flush()
    writer.stop()
    writer.close()
    assert [(s, v) for s, v, _ in wandb.run.logged] == [
        (1, {"Train/mean_reward": 0.5, "Loss/value": 2.0}),
        (2, {"Train/mean_reward": 1.0, "Loss/value": 2.0}),
    ]
    assert wandb.run.finished
    assert wandb.run.metrics == {"Metrics/success_rate": "last,max"}
    assert curves(tmp_path)["Train/mean_reward"] == [(1, 0.5), (2, 1.0)]


def test_a_run_has_the_name_of_its_folder_and_keeps_its_files_there(wandb, tmp_path, monkeypatch):
    WandbWriter(str(tmp_path / "2026-01-01_a"), "a project").close()
    assert wandb.asked["name"] == "2026-01-01_a"
    assert wandb.asked["project"] == "a project"
    assert wandb.asked["dir"] == str(tmp_path / "2026-01-01_a")
    assert wandb.asked["entity"] is None
    monkeypatch.setenv("WANDB_DIR", "elsewhere")
    monkeypatch.setenv("WANDB_USERNAME", "somebody")
    WandbWriter(str(tmp_path / "b"), "a project").close()
    assert wandb.asked["dir"] is None
    assert wandb.asked["entity"] == "somebody"


def test_configurations_are_sent_as_values_that_json_can_hold(wandb, tmp_path):
    @configclass
    class Cfg:
        term: object = print
        ids: slice = slice(None)
        limits: tuple = (0.1, 0.2)
        std: torch.Tensor = torch.tensor([1.0, 0.5])

    writer = WandbWriter(str(tmp_path), "a project")
    writer.store_config(Cfg(), {"seed": 3, "std": torch.tensor([0.25])})
    writer.close()
    sent = json.loads(json.dumps(wandb.run.config))
    assert sent["train_cfg"] == {"seed": 3, "std": [0.25]}
    assert sent["env_cfg"]["limits"] == [0.1, 0.2]
    assert sent["env_cfg"]["std"] == [1.0, 0.5]
    assert sent["env_cfg"]["term"] == "builtins:print"
    assert sent["env_cfg"]["ids"] == "slice(None,None,None)"


def test_models_are_sent_and_each_video_once_with_the_values_of_its_step(wandb, tmp_path):
    writer = WandbWriter(str(tmp_path), "a project")
    (tmp_path / "model_1.pt").touch()
    writer.save_model(str(tmp_path / "model_1.pt"), 1)
    for step in (1, 2):
        writer.add_scalar("a", 0.0, step)
        writer.save_video(tmp_path / "videos" / "train" / "step_0.mp4", step)
        writer.flush()
    writer.close()
    assert wandb.run.files == ["model_1.pt"]
    assert [(step, list(values), commit) for step, values, commit in wandb.run.logged] == [
        (1, ["video"], False),
        (1, ["a"], True),
        (2, ["a"], True),
    ]


@pytest.mark.parametrize("error", [BrokenPipeError("the service is gone"), NoKeyError("revoked\nlong story")])
def test_an_error_on_the_way_is_one_line_and_the_curves_go_on_in_tensorboards_files(wandb, tmp_path, capsys, error):
    writer = WandbWriter(str(tmp_path), "a project")
    for step in (1, 2, 3):
        wandb.run.error = error if step > 1 else None
        writer.add_scalar("a", 1.0, step)
        writer.save_model(str(tmp_path / "model.pt"), step)
        writer.flush()
    writer.stop()
    writer.close()
    said = capsys.readouterr().err
    assert said.startswith(f"warning: wandb: {str(error).splitlines()[0]}; ")
    assert said.count("\n") == 1
    assert not wandb.run.finished
    assert curves(tmp_path)["a"] == [(1, 1.0), (2, 1.0), (3, 1.0)]


def test_an_error_at_the_start_tells_what_else_can_be_done(wandb, tmp_path):
    wandb.run.error = NoKeyError("No API key configured. Use `wandb login` to log in.")
    with pytest.raises(LoggerError, match=r"--logger wandb: No API key configured.*WANDB_MODE=offline") as raised:
        WandbWriter(str(tmp_path), "a project")
    assert "\n" not in str(raised.value)
    assert isinstance(raised.value, LiftLabError)


def test_a_mistake_of_our_own_is_not_taken_for_one_of_wandbs(wandb, tmp_path):
    writer = WandbWriter(str(tmp_path), "a project")
    wandb.run.error = ZeroDivisionError()
    writer.add_scalar("a", 1.0, 1)
    with pytest.raises(ZeroDivisionError):
        writer.flush()


def test_ctrl_c_does_not_wait_for_the_last_curves_to_be_sent(wandb, tmp_path, capsys):
    writer = WandbWriter(str(tmp_path), "a project")
    wandb.run.error = KeyboardInterrupt()
    writer.stop()
    writer.close()
    assert "'wandb sync' sends the rest" in capsys.readouterr().err


def test_a_missing_package_is_named(without_wandb):
    with pytest.raises(MissingPackageError, match=r"pip install 'lift-lab\[wandb\]'"):
        require_logger("wandb")


def test_neptune_is_refused_with_the_reason():
    with pytest.raises(ConfigError, match="neptune's service ended"):
        require_logger("neptune")


def test_the_configuration_names_the_writer_and_the_project():
    _, cfg = compose("Cartpole", "rsl_rl_cfg_entry_point", ["agent.logger=wandb", "agent.wandb_project=mine"])
    logger = to_rsl_rl(cfg)["logger"]
    module, _, name = logger["class_name"].partition(":")
    assert getattr(importlib.import_module(module), name) is WandbWriter
    assert logger["project_name"] == "mine"
    cfg.logger = "neptune"
    with pytest.raises(ConfigError, match="neptune's service ended"):
        to_rsl_rl(cfg)


def test_a_training_sends_its_configuration_curves_and_models(wandb, tmp_path):
    cfg = AgentCfg(logger="wandb")
    train(tmp_path, cfg=cfg)
    assert wandb.run.config["train_cfg"]["num_steps_per_env"] == 8
    assert [step for step, _, _ in wandb.run.logged] == [1, 2, 3, 4]
    assert all("Loss/surrogate" in values for _, values, _ in wandb.run.logged)
    assert wandb.run.files == ["model_2.pt", "model_4.pt"]
    assert wandb.run.finished
    assert len(curves(tmp_path)["Loss/surrogate"]) == 4


OFFLINE = """
import os, signal, sys
from lift_lab_rl.rsl_rl.wandb_writer import WandbWriter

writer = WandbWriter(sys.argv[1], "a project")
writer.store_config({"decimation": 2}, {"seed": 3})
for step in (1, 2):
    writer.add_scalar("Train/mean_reward", 0.5 * step, step)
    writer.add_scalar("Loss/value", 2.0, step)
    writer.flush()
print("written", flush=True)
if sys.argv[2] == "kill":
    sys.stdin.readline()
writer.stop()
writer.close()
"""


def records(file):
    """Records of W&B's file: LevelDB's log format, blocks of 32 KiB, after a header of 7 bytes."""
    data, at, parts = file.read_bytes(), 7, b""
    while at + 7 <= len(data):
        if 32768 - at % 32768 < 7:
            at += 32768 - at % 32768
            continue
        length, kind = int.from_bytes(data[at + 4 : at + 6], "little"), data[at + 6]
        if kind == 0:
            break
        parts += data[at + 7 : at + 7 + length]
        at += 7 + length
        if kind in (1, 4):  # a whole record, or the last part of one
            yield parts
            parts = b""


def read(file):
    """Rows of curves, and the configuration, of W&B's file."""
    from wandb.proto import wandb_internal_pb2

    rows, config = [], {}
    for data in records(file):
        record = wandb_internal_pb2.Record.FromString(data)
        row = {(".".join(item.nested_key) or item.key): json.loads(item.value_json) for item in record.history.item}
        if row:
            rows.append({key: value for key, value in row.items() if not key.startswith("_") or key == "_step"})
        for holder in (record.run.config, record.config):
            config.update({item.key: json.loads(item.value_json) for item in holder.update if item.key})
    return rows, config


@pytest.mark.skipif(not INSTALLED, reason="wandb is not installed (the extra 'wandb')")
@pytest.mark.parametrize("end", ["finish", "kill"])
def test_a_run_offline_holds_configuration_and_curves_and_after_a_kill_some_of_them(end, tmp_path):
    env = {**os.environ, "WANDB_MODE": "offline", "WANDB_SILENT": "true"}
    process = subprocess.Popen(
        [sys.executable, "-c", OFFLINE, str(tmp_path), end],
        env=env,
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )
    assert process.stdout.readline() == "written\n"
    if end == "kill":
        process.send_signal(signal.SIGKILL)
    process.communicate(timeout=120)
    assert process.returncode == (-signal.SIGKILL if end == "kill" else 0)
    (file,) = tmp_path.glob("wandb/offline-run-*/*.wandb")
    rows, config = read(file)
    expected = [
        {"Train/mean_reward": 0.5, "Loss/value": 2.0, "_step": 1},
        {"Train/mean_reward": 1.0, "Loss/value": 2.0, "_step": 2},
    ]
    if end == "kill":  # W&B's process writes blocks, and ends with ours
        assert rows == expected[: len(rows)]
    else:
        assert rows == expected
        assert config["env_cfg"] == {"decimation": 2}
        assert config["train_cfg"] == {"seed": 3}
    assert curves(tmp_path)["Train/mean_reward"] == [(1, 0.5), (2, 1.0)]
