"""A policy that ships is the run's policy, small, found by its task's name, and says where it comes from."""

import json
import tomllib
from pathlib import Path

import gymnasium as gym
import onnx
import pytest
import torch
from onnx.reference import ReferenceEvaluator
from point_task import AgentCfg, PointEnv

import lift_lab_tasks  # noqa: F401
from lift_lab.utils.errors import ConfigError, FileError
from lift_lab_assets.files import PRETRAINED_DIR
from lift_lab_rl.files import load_torch
from lift_lab_rl.rsl_rl import LiftLabRunner, to_rsl_rl
from lift_lab_rl.rsl_rl.ema import AVERAGE
from lift_lab_rl.rsl_rl.pretrained import MAX_BYTES, write_pretrained
from lift_lab_tasks.utils import runs

ROOT = Path(__file__).resolve().parents[2]
SHIPPED = runs.pretrained_tasks()


def make_runner(folder=None, share=0.5):
    torch.manual_seed(5)
    return LiftLabRunner(PointEnv(), to_rsl_rl(AgentCfg(average_share=share)), log_dir=folder)


@pytest.fixture(scope="module", params=[0.5, 0.0], ids=["averaged", "last"])
def shipped(request, tmp_path_factory):
    """A short run's checkpoint and the policy written from it."""
    folder = tmp_path_factory.mktemp("run")
    make_runner(folder, request.param).learn(4)
    results = {"task": "Point-Play", "checkpoint": str(folder / "model_4.pt"), "perturb": [], "episodes": 10}
    files = write_pretrained(make_runner(), folder / "model_4.pt", folder / "out" / "Point", "Point", results)
    return folder / "model_4.pt", files


def test_a_shipped_policy_acts_exactly_as_its_checkpoint_does(shipped):
    checkpoint, (policy, _, _) = shipped
    obs, actions = PointEnv().get_observations(), []
    for path in (checkpoint, policy):
        runner = make_runner()
        runner.load_policy(str(path))
        with torch.inference_mode():
            actions.append(runner.get_inference_policy(device="cpu")(obs).clone())
    assert torch.equal(*actions)


def test_a_shipped_policy_is_the_averaged_actor_alone_without_optimiser_and_critic(shipped):
    source, content = (load_torch(path) for path in (shipped[0], shipped[1][0]))
    assert sorted(content) == ["actor_state_dict", "infos", "iter"]
    assert content["iter"] == 4
    for name, value in source.get(AVERAGE, source["actor_state_dict"]).items():
        assert torch.equal(content["actor_state_dict"][name], value)


def test_the_onnx_file_agrees_with_the_shipped_policy(shipped):
    runner = make_runner()
    runner.load_policy(str(shipped[1][0]))
    obs = PointEnv().get_observations()
    with torch.inference_mode():
        expected = runner.get_inference_policy(device="cpu")(obs)
    session = ReferenceEvaluator(str(shipped[1][1]))
    found = torch.cat([torch.as_tensor(session.run(None, {"obs": row[None].numpy()})[0]) for row in obs["policy"]])
    torch.testing.assert_close(found, expected, atol=1e-5, rtol=1e-5)


def test_the_card_says_where_the_policy_comes_from_and_names_no_path_of_the_machine(shipped):
    text = shipped[1][2].read_text()
    card = json.loads(text)
    assert (card["task"], card["iterations"], card["evaluation"]) == ("Point", 4, {"episodes": 10})
    assert str(shipped[0].parent) not in text


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"checkpoint": "model_3.pt"}, "the results are of 'Point', 'model_3.pt'"),
        ({"task": "Line"}, "the results are of 'Line'"),
        ({"perturb": ["mass=2"]}, r"a changed task \(mass=2\)"),
    ],
)
def test_results_of_something_else_are_refused(shipped, tmp_path, change, message):
    results = {"task": "Point", "checkpoint": str(shipped[0]), "perturb": []} | change
    with pytest.raises(ConfigError, match=message):
        write_pretrained(make_runner(), shipped[0], tmp_path / "Point", "Point", results)
    assert not list(tmp_path.iterdir())


def test_a_shipped_policy_is_not_trained_on(shipped):
    with pytest.raises(ConfigError, match="does not fit this task's networks"):
        make_runner().load(str(shipped[1][0]))
    with pytest.raises(ConfigError, match="nothing to train on from"):
        runs.find_checkpoint(AgentCfg(), "pretrained", task="Lift", training=True)


def test_a_task_and_its_play_form_share_a_policy_and_a_task_without_one_names_those_that_have(tmp_path, monkeypatch):
    for name in ("Lift", "Reach"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "policy.pt").touch()
    monkeypatch.setattr(runs, "PRETRAINED_DIR", tmp_path)
    for task in ("Lift", "Lift-Play", "my_tasks:Lift-Play"):
        assert runs.find_checkpoint(AgentCfg(), "pretrained", task=task) == tmp_path / "Lift" / "policy.pt"
    with pytest.raises(FileError, match="no pretrained policy for 'Push'; tasks that have one: Lift, Reach"):
        runs.find_checkpoint(AgentCfg(), "pretrained", task="Push-Play")


def test_what_is_made_with_a_shipped_policy_goes_to_the_runs_not_into_the_package(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    cfg = AgentCfg()
    for task in ("Lift", "Lift-CL"):  # one experiment, two policies
        place = tmp_path / "logs/rsl_rl/test/pretrained" / task
        assert runs.output_dir(cfg, PRETRAINED_DIR / task / "policy.pt") == place
    assert runs.output_dir(cfg, tmp_path / "run" / "model_4.pt") == tmp_path / "run"


def test_the_wheel_holds_the_folder():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())
    included = project["tool"]["hatch"]["build"]["targets"]["wheel"]["force-include"]
    assert included["assets/pretrained"] == "lift_lab_assets/pretrained"
    assert (ROOT / "assets" / "pretrained").is_dir()


@pytest.mark.parametrize("task", SHIPPED)
def test_each_policy_of_the_repository_is_small_and_of_a_registered_task(task):
    assert task in gym.registry
    files = {path.name: path for path in (PRETRAINED_DIR / task).iterdir()}
    assert sorted(files) == ["card.json", "policy.onnx", "policy.pt"]
    assert all(path.stat().st_size <= MAX_BYTES for path in files.values())
    card = json.loads(files["card.json"].read_text())
    content = load_torch(files["policy.pt"])
    assert (card["task"], card["iterations"]) == (task, content["iter"])
    assert card["evaluation"]["episodes"] >= 100
    network = onnx.load(files["policy.onnx"])
    texts = {prop.key: prop.value for prop in network.metadata_props}
    terms = json.loads(texts["observations"])
    assert (texts["task"], texts["iteration"]) == (task, str(content["iter"]))
    assert terms[-1]["start"] + terms[-1]["size"] == network.graph.input[0].type.tensor_type.shape.dim[1].dim_value
