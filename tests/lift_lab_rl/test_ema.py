"""The averaged policy follows its definition, is saved, continued and acted with, and changes no training."""

import filecmp

import pytest
import torch
from point_task import AgentCfg, PointEnv

from lift_lab.utils.errors import ConfigError
from lift_lab_rl.files import load_torch, save_torch
from lift_lab_rl.rsl_rl import LiftLabRunner, to_rsl_rl
from lift_lab_rl.rsl_rl.ema import AVERAGE
from lift_lab_rl.rsl_rl.pretrained import write_pretrained

SHARE = 0.5


def make_runner(folder, share=SHARE):
    torch.manual_seed(5)
    return LiftLabRunner(PointEnv(), to_rsl_rl(AgentCfg(average_share=share)), log_dir=folder)


def weights(runner):
    return {name: value.detach().clone() for name, value in runner.alg.get_policy().named_parameters()}


def test_the_average_follows_its_recursion_over_the_policies_of_all_iterations(tmp_path):
    runner, seen = make_runner(tmp_path), []
    seen.append(weights(runner))
    runner.learn(6, on_iteration=lambda _: seen.append(weights(runner)))
    expected = seen[0]
    for k, policy in enumerate(seen[1:], start=1):
        part = 1.0 / max(1.0, SHARE * k)
        expected = {name: (1.0 - part) * value + part * policy[name] for name, value in expected.items()}
    saved = load_torch(tmp_path / "model_6.pt")
    for name, value in expected.items():
        torch.testing.assert_close(saved[AVERAGE][name], value)
        assert not torch.equal(saved[AVERAGE][name], saved["actor_state_dict"][name])
    # Statistics of the observations are not averaged.
    assert torch.equal(saved[AVERAGE]["obs_normalizer._mean"], saved["actor_state_dict"]["obs_normalizer._mean"])


def test_averaging_changes_nothing_about_training(tmp_path):
    for name, share in (("with", SHARE), ("without", 0.0)):
        make_runner(tmp_path / name, share).learn(4)
    one, other = (load_torch(tmp_path / name / "model_4.pt") for name in ("with", "without"))
    assert AVERAGE in one
    assert AVERAGE not in other
    for name, value in one["actor_state_dict"].items():
        assert torch.equal(value, other["actor_state_dict"][name])


def test_a_loaded_average_goes_on_where_it_was(tmp_path):
    make_runner(tmp_path).learn(4)
    runner = make_runner(None)
    runner.load(str(tmp_path / "model_4.pt"))
    runner.save(str(tmp_path / "again.pt"))
    assert filecmp.cmp(tmp_path / "again.pt", tmp_path / "model_4.pt", shallow=False)


def test_a_run_that_starts_to_average_begins_at_the_policy_it_loads(tmp_path):
    make_runner(tmp_path, share=0.0).learn(2)
    runner = make_runner(None)
    runner.load(str(tmp_path / "model_2.pt"))
    for name, value in weights(runner).items():
        assert torch.equal(runner.alg.ema.parameters[name], value)


@pytest.mark.parametrize(("share", "entry"), [(SHARE, AVERAGE), (0.0, "actor_state_dict")])
def test_play_and_evaluate_act_with_the_average_where_there_is_one(tmp_path, share, entry):
    make_runner(tmp_path, share).learn(4)
    runner = make_runner(None, share=0.0)
    runner.load_policy(str(tmp_path / "model_4.pt"))
    saved = load_torch(tmp_path / "model_4.pt")
    for name, value in weights(runner).items():
        assert torch.equal(value, saved[entry][name])


def test_a_file_without_a_policy_is_answered_alike_by_playing_and_shipping(tmp_path):
    path = tmp_path / "resume_state_4.pt"
    save_torch(path, {"iter": 4})
    runner = make_runner(None)
    with pytest.raises(ConfigError, match=r"resume_state_4\.pt' holds no policy") as playing:
        runner.load_policy(str(path))
    with pytest.raises(ConfigError) as shipping:
        write_pretrained(runner, path, tmp_path / "out", "Point")
    assert str(playing.value) == str(shipping.value)
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("share", [-0.1, 1.0])
def test_a_share_that_is_none_is_refused(share):
    with pytest.raises(ConfigError, match="average_share"):
        to_rsl_rl(AgentCfg(average_share=share))
