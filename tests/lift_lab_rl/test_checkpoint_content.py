"""A whole torch file that is no checkpoint, or one of something else, is refused in one line and changes nothing."""

import filecmp
import math

import pytest
import torch
from point_task import AgentCfg, PointEnv, train

from lift_lab.utils.errors import ConfigError, LiftLabError
from lift_lab_rl.files import load_torch, save_torch
from lift_lab_rl.rsl_rl import LiftLabRunner, RslRlRndCfg, to_rsl_rl
from lift_lab_rl.rsl_rl.checkpoint_file import read_checkpoint
from lift_lab_rl.rsl_rl.run_files import checkpoint_iteration


@pytest.fixture(scope="module")
def good(tmp_path_factory):
    """Path of a checkpoint."""
    folder = tmp_path_factory.mktemp("run")
    train(folder, iterations=2)
    return folder / "model_2.pt"


def put(*path_and_value):
    """A change of a checkpoint's content: an entry, found by a path of keys, gets a value."""
    *path, last, value = path_and_value

    def change(content):
        inner = content
        for key in path:
            inner = inner[key]
        inner[last] = value
        return content

    return change


def drop(*path):
    """A change of a checkpoint's content: an entry is removed."""
    *path, last = path

    def change(content):
        inner = content
        for key in path:
            inner = inner[key]
        del inner[last]
        return content

    return change


WEIGHT = "mlp.0.weight"  # of shape (16, 2)
ACTOR, CRITIC, OPTIMIZER = "actor_state_dict", "critic_state_dict", "optimizer_state_dict"
NAN = torch.full((16, 2), math.nan)

NOT_VALID = {
    "a list": (lambda content: [content], "is no checkpoint of a training: it holds a value of type list"),
    "a tensor": (lambda _: torch.zeros(3), r"is no checkpoint of a training: it holds a tensor of shape \(3,\)"),
    "a number": (lambda _: 3, "is no checkpoint of a training: it holds a value of type int"),
    "None": (lambda _: None, "is no checkpoint of a training: it holds None"),
    "an empty dictionary": (lambda _: {}, "is no checkpoint of a training: it is empty"),
    "another library's": (
        lambda _: {"policy": {"w": torch.zeros(1)}, "value": {}},
        "is no checkpoint of a training: it has no entry 'iter', it holds 'policy', 'value'",
    ),
    "text for iterations": (put("iter", "5"), "'iter' has to be a number of iterations, it is '5'"),
    "a negative iteration": (put("iter", -1), "'iter' has to be a number of iterations, it is -1"),
    "True for iterations": (put("iter", True), "'iter' has to be a number of iterations, it is True"),
    "a fraction for iterations": (put("iter", 2.0), "'iter' has to be a number of iterations, it is 2.0"),
    "infos that are a list": (put("infos", [1]), "'infos' has to be a dictionary, it is a value of type list"),
    "counters that are a number": (put("infos", "env_state", 3), "'infos.env_state' has to be a dictionary"),
    "a counter that is text": (
        put("infos", {"env_state": {"common_step_counter": "x"}}),
        "'infos.env_state.common_step_counter' has to be a number of steps, it is 'x'",
    ),
    "an infinite weight": (
        put("infos", {"env_state": {"reward_weights": {"a": math.inf}, "configured_weights": {"a": 1.0}}}),
        "'infos.env_state.reward_weights.a' has to be a finite number, it is inf",
    ),
    "half of the weights": (
        put("infos", {"env_state": {"reward_weights": {"a": 1.0}}}),
        "'infos.env_state' has 'reward_weights' but no 'configured_weights'",
    ),
    "an unknown setting of curiosity": (put("infos", "rnd", {"state_normalizer": 1}), "unknown entry"),
    "a network that is a tensor": (put(ACTOR, torch.zeros(2)), f"'{ACTOR}' has to be a dictionary"),
    "a parameter that is a list": (put(ACTOR, WEIGHT, [1.0]), f"'{ACTOR}.{WEIGHT}' has to be a tensor"),
    "a sparse parameter": (put(ACTOR, WEIGHT, torch.zeros(16, 2).to_sparse()), "has to be a tensor"),
    "a parameter without a name": (put(ACTOR, 3, torch.zeros(1)), f"'{ACTOR}' has the key 3"),
    "NaN in the actor": (put(ACTOR, WEIGHT, NAN), f"'{ACTOR}.{WEIGHT}' holds numbers that are not finite"),
    "infinity in the critic": (put(CRITIC, WEIGHT, NAN + math.inf), f"'{CRITIC}.{WEIGHT}' holds numbers that"),
    "NaN in the optimizer": (put(OPTIMIZER, "state", 1, "exp_avg", NAN), "state.1.exp_avg' holds numbers that are not"),
    "an infinite rate": (put(OPTIMIZER, "param_groups", 0, "lr", math.inf), "param_groups.0.lr' is inf"),
    "an optimizer that is a list": (put(OPTIMIZER, []), f"'{OPTIMIZER}' has to be a dictionary"),
    "an empty optimizer": (put(OPTIMIZER, {}), f"'{OPTIMIZER}.param_groups' has to be a list of dictionaries"),
    "moments that are text": (put(OPTIMIZER, "state", 1, "exp_avg", "x"), "exp_avg' has to be a finite number"),
}


@pytest.mark.parametrize("case", NOT_VALID)
def test_what_is_no_valid_checkpoint_is_refused_wherever_one_is_read(good, tmp_path, case):
    change, message = NOT_VALID[case]
    path = tmp_path / "model_7.pt"
    save_torch(path, change(load_torch(good)))
    runner = LiftLabRunner(PointEnv(), to_rsl_rl(AgentCfg()))
    for read in (checkpoint_iteration, runner.load, runner.load_policy):
        with pytest.raises(ConfigError, match=message) as caught:
            read(str(path))
        assert str(caught.value).startswith(f"'{path}' is no ")
        assert "\n" not in str(caught.value)


NO_FIT = {
    "no actor": (drop(ACTOR), f"it has no '{ACTOR}'"),
    "no critic": (drop(CRITIC), f"it has no '{CRITIC}'"),
    "no optimizer": (drop(OPTIMIZER), f"it has no '{OPTIMIZER}'"),
    "an empty network": (put(ACTOR, {}), f"'{ACTOR}' has no '"),
    "a parameter less": (drop(ACTOR, WEIGHT), f"'{ACTOR}' has no '{WEIGHT}'"),
    "a parameter more": (put(CRITIC, "more", torch.zeros(1)), f"'{CRITIC}' has 'more', which the network does not"),
    "another shape": (
        put(ACTOR, WEIGHT, torch.zeros(16, 3)),
        rf"'{ACTOR}.{WEIGHT}' has shape \(16, 3\), the network needs \(16, 2\)",
    ),
    "another type of number": (
        put(ACTOR, WEIGHT, torch.zeros(16, 2, dtype=torch.float64)),
        f"'{ACTOR}.{WEIGHT}' is of type torch.float64, the network needs torch.float32",
    ),
    "whole numbers": (put(CRITIC, WEIGHT, torch.zeros(16, 2, dtype=torch.long)), "is of type torch.int64"),
    "moments of another network": (
        put(OPTIMIZER, "state", 1, "exp_avg", torch.zeros(7)),
        rf"'{OPTIMIZER}.state.1.exp_avg' has shape \(7,\)",
    ),
    "a moment less": (drop(OPTIMIZER, "state", 1, "exp_avg_sq"), f"'{OPTIMIZER}.state.1' has no 'exp_avg_sq'"),
    "parameters less": (put(OPTIMIZER, "param_groups", 0, "params", [0, 1]), f"'{OPTIMIZER}' is of 2 parameters"),
    "no groups": (put(OPTIMIZER, "param_groups", []), f"'{OPTIMIZER}' is of 0 parameters"),
    "no rate": (drop(OPTIMIZER, "param_groups", 0, "lr"), "param_groups.0.lr' is missing"),
    "a rate that is text": (put(OPTIMIZER, "param_groups", 0, "lr", "fast"), "param_groups.0.lr' is 'fast'"),
    "moments of unknown parameters": (put(OPTIMIZER, "state", 99, {}), "numbers its parameters in another way"),
    "betas that are a number": (put(OPTIMIZER, "param_groups", 0, "betas", 0.9), "param_groups.0.betas' is 0.9"),
}


@pytest.mark.parametrize("case", NO_FIT)
def test_what_does_not_fit_is_named_and_changes_nothing(good, tmp_path, case):
    change, message = NO_FIT[case]
    path = tmp_path / "model_7.pt"
    save_torch(path, change(load_torch(good)))
    torch.manual_seed(8)
    runner = LiftLabRunner(PointEnv(), to_rsl_rl(AgentCfg()))
    runner.save(str(tmp_path / "before.pt"))
    with pytest.raises(ConfigError, match=message) as caught:
        runner.load(str(path))
    assert "does not fit this task's networks" in str(caught.value)
    assert "\n" not in str(caught.value)
    runner.save(str(tmp_path / "after.pt"))
    assert filecmp.cmp(tmp_path / "after.pt", tmp_path / "before.pt", shallow=False)


def test_a_checkpoint_of_a_training_with_curiosity_needs_its_networks(good, tmp_path):
    cfg = AgentCfg()
    cfg.algorithm.rnd_cfg = RslRlRndCfg(weight=1.0, num_outputs=4)
    cfg.obs_groups = {"policy": ["policy"], "rnd_state": ["policy"]}
    runner = LiftLabRunner(PointEnv(), to_rsl_rl(cfg))
    with pytest.raises(ConfigError, match="it has no 'rnd_state_dict'"):
        runner.load(str(good))
    content = load_torch(good)
    content |= {"rnd_state_dict": {}, "rnd_optimizer_state_dict": content[OPTIMIZER]}
    save_torch(tmp_path / "model_7.pt", content)
    with pytest.raises(ConfigError, match="'rnd_state_dict' has no '"):
        runner.load(str(tmp_path / "model_7.pt"))


def test_the_state_of_the_averaged_policy_is_checked_too(good, tmp_path):
    content = load_torch(good)
    content["actor_average_state_dict"] = {WEIGHT: torch.zeros(1)}
    save_torch(tmp_path / "model_7.pt", content)
    runner = LiftLabRunner(PointEnv(), to_rsl_rl(AgentCfg()))
    with pytest.raises(ConfigError, match="'actor_average_state_dict' has no '"):
        runner.load(str(tmp_path / "model_7.pt"))


def test_a_checkpoint_without_digest_and_infos_loads(good, tmp_path):
    content = load_torch(good)
    del content["infos"]
    torch.save(content, tmp_path / "model_2.pt")
    runner = LiftLabRunner(PointEnv(), to_rsl_rl(AgentCfg()))
    assert runner.load(str(tmp_path / "model_2.pt")) == {}
    assert runner.current_learning_iteration == 2


def test_every_flip_of_a_byte_in_a_checkpoint_is_one_line(good, tmp_path):
    data = good.read_bytes()
    path = tmp_path / "model_2.pt"
    for position in range(0, len(data), len(data) // 40):
        path.write_bytes(data[:position] + bytes([data[position] ^ 1]) + data[position + 1 :])
        with pytest.raises(LiftLabError, match=r"^cannot read '[^\n]*$"):
            read_checkpoint(path)
