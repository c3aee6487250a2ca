"""Writing nested dictionaries into configurations."""

from __future__ import annotations

import enum
import math
from collections.abc import Callable
from dataclasses import MISSING
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import pytest
import torch

from lift_lab.utils import configclass, update_class_from_dict
from lift_lab.utils.errors import ConfigError

if TYPE_CHECKING:
    from nowhere import Unknown


class Mode(enum.Enum):
    FAST = 1
    SLOW = 2


@configclass
class TermCfg:
    func: Callable = MISSING
    params: dict[str, Any] = {}
    weight: float = MISSING


@configclass
class RobotCfg:
    pos: tuple[float, float, float] = (0.0, 0.0, 0.0)
    joint_pos: dict[str, float] = {"panda_joint1": 0.0, "panda_joint2": -0.5}
    stiffness: dict[str, float] | float | None = None
    joint_ids: list[int] | slice = slice(None)


@configclass
class SceneCfg:
    num_envs: int = 4
    env_spacing: float = 2.5
    replicate = True
    robot: RobotCfg = RobotCfg()
    robots: dict[str, RobotCfg] = {"left": RobotCfg(), "right": RobotCfg()}
    extra: RobotCfg | None = None
    more: list[RobotCfg] = MISSING
    engine: Literal["native", "warp"] | None = None
    mode = Mode.FAST
    folder = Path("logs")
    tensor = torch.zeros(2)
    names: str | list[str] = "panda_.*"
    seed: int | None = None
    typed_elsewhere: Unknown = None
    anything: Any = 1
    entries: list[Any] | None = None
    gains = [1.0, 2.0]
    ranges = {"x": (0.0, 1.0)}


@configclass
class EnvCfg:
    scene: SceneCfg = SceneCfg()
    reaching: TermCfg = TermCfg(func=math.sin, weight=1, params={"std": 1, "names": ["a"]})
    terms = [TermCfg(weight=1.0), TermCfg(weight=2.0)]


def updated(data: dict) -> EnvCfg:
    cfg = EnvCfg()
    cfg.from_dict(data)
    return cfg


def test_nested_values_are_set_and_the_rest_stays():
    cfg = updated({"scene": {"num_envs": 8, "robot": {"pos": [1, 2, 3]}}})
    assert cfg.scene.num_envs == 8
    assert cfg.scene.env_spacing == 2.5
    assert cfg.scene.robot.pos == (1.0, 2.0, 3.0)
    assert all(isinstance(value, float) for value in cfg.scene.robot.pos)
    assert isinstance(cfg.scene.robot, RobotCfg)


def test_an_int_is_taken_for_a_float():
    value = updated({"scene": {"env_spacing": 3}}).scene.env_spacing
    assert value == 3.0
    assert type(value) is float


def test_a_float_is_taken_for_a_float_field_that_holds_an_int():
    assert updated({"reaching": {"weight": 0.25}}).reaching.weight == 0.25


def test_a_whole_float_is_taken_for_an_int_and_a_fraction_is_not():
    assert updated({"scene": {"num_envs": 16.0}}).scene.num_envs == 16
    with pytest.raises(ConfigError, match=r"^scene\.num_envs: expected int, got float 1\.5$"):
        updated({"scene": {"num_envs": 1.5}})


def test_a_number_in_a_plain_dictionary_may_become_a_fraction():
    assert updated({"reaching": {"params": {"std": 0.1}}}).reaching.params["std"] == 0.1


@pytest.mark.parametrize(
    ("data", "message"),
    [
        ({"scene": {"env_spacing": "wide"}}, r"^scene\.env_spacing: expected float, got str 'wide'$"),
        ({"scene": {"num_envs": True}}, r"^scene\.num_envs: expected int, got bool True$"),
        ({"scene": {"replicate": 1}}, r"^scene\.replicate: expected bool, got int 1$"),
        ({"scene": {"robot": 3}}, r"^scene\.robot: expected RobotCfg, got int 3$"),
        ({"scene": {"robot": {"pos": ["a", 0, 0]}}}, r"^scene\.robot\.pos: expected tuple, got list"),
        ({"scene": {"robot": {"pos": [0, 0]}}}, r"^scene\.robot\.pos: expected 3 values, got 2"),
        ({"scene": {"num_envs": {"a": 1}}}, r"^scene\.num_envs: expected int, got dict"),
        ({"reaching": {"func": 3}}, r"^reaching\.func: expected 'module:name', got int 3$"),
        ({"reaching": {"func": "math:sine"}}, r"^reaching\.func: cannot resolve 'math:sine'.*'sin'"),
        ({"terms": [{"weight": 1}]}, r"^terms: expected 2 entries, got 1$"),
    ],
)
def test_a_value_that_does_not_fit_is_refused_with_its_path(data, message):
    with pytest.raises(ValueError, match=message):
        updated(data)


@pytest.mark.parametrize(
    ("data", "message"),
    [
        ({"scen": {}}, r"^scen: no such key in EnvCfg; did you mean 'scene'\?$"),
        ({"scene": {"num_env": 1}}, r"^scene\.num_env: no such key in SceneCfg; did you mean 'num_envs'\?$"),
        (
            {"scene": {"robot": {"joint_pos": {"panda_joint3": 1}}}},
            r"^scene\.robot\.joint_pos\.panda_joint3: .*joint1'",
        ),
        ({"terms": [{}, {"wight": 1}]}, r"^terms\[1\]\.wight: .*'weight'"),
        ({"scene": {"to_dict": 1}}, r"^scene\.to_dict: no such key"),
    ],
)
def test_an_unknown_key_is_refused_with_its_path_and_the_closest_names(data, message):
    with pytest.raises(KeyError, match=message) as error:
        updated(data)
    assert isinstance(error.value, ConfigError)


def test_a_key_may_be_added_to_an_empty_dictionary():
    cfg = TermCfg()
    cfg.from_dict({"params": {"std": 0.1, "cfg": {"name": "robot"}}})
    assert cfg.params == {"std": 0.1, "cfg": {"name": "robot"}}


def test_a_value_is_taken_where_there_was_none_and_converted_by_the_annotation():
    cfg = updated(
        {"scene": {"seed": 3, "extra": {"pos": [1, 2, 3]}, "more": [{"pos": [0, 0, 1]}], "typed_elsewhere": 7}}
    )
    assert cfg.scene.seed == 3
    assert isinstance(cfg.scene.extra, RobotCfg)
    assert cfg.scene.extra.pos == (1.0, 2.0, 3.0)
    assert cfg.scene.more[0].pos == (0.0, 0.0, 1.0)
    assert cfg.scene.typed_elsewhere == 7


def test_a_wrong_key_below_a_configuration_that_was_none_is_refused():
    with pytest.raises(KeyError, match=r"^scene\.extra\.poss: .*'pos'"):
        updated({"scene": {"extra": {"poss": 1}}})


def test_none_is_always_taken():
    assert updated({"scene": {"robot": None}}).scene.robot is None


def test_another_kind_is_taken_where_the_annotation_allows_it():
    cfg = updated({"scene": {"robot": {"stiffness": 80, "joint_ids": [0, 2]}, "names": ["a", "b"]}})
    assert cfg.scene.robot.stiffness == 80.0
    assert cfg.scene.robot.joint_ids == [0, 2]
    assert cfg.scene.names == ["a", "b"]
    cfg.from_dict({"scene": {"robot": {"stiffness": {"panda_.*": 10}}}})
    assert cfg.scene.robot.stiffness == {"panda_.*": 10.0}


def test_anything_is_taken_where_the_annotation_says_so():
    cfg = updated({"scene": {"anything": "text", "entries": ["a", 1, {"b": 2}]}})
    assert cfg.scene.anything == "text"
    assert cfg.scene.entries == ["a", 1, {"b": 2}]


def test_configurations_in_dictionaries_and_lists_are_updated_in_place():
    cfg = updated({"scene": {"robots": {"left": {"pos": [1, 0, 0]}}}, "terms": [{"weight": 5}, {}]})
    assert cfg.scene.robots["left"].pos == (1.0, 0.0, 0.0)
    assert cfg.scene.robots["right"].pos == (0.0, 0.0, 0.0)
    assert [term.weight for term in cfg.terms] == [5.0, 2.0]
    assert all(isinstance(term, TermCfg) for term in cfg.terms)


def test_a_flat_list_replaces_a_list_of_another_length():
    cfg = updated({"scene": {"gains": [3], "ranges": {"x": [-1, 1]}}})
    assert cfg.scene.gains == [3.0]
    assert cfg.scene.ranges["x"] == (-1.0, 1.0)


def test_callables_are_found_by_name():
    cfg = updated({"reaching": {"func": "math:cos"}, "terms": [{"func": "math:tan"}, {"func": "lambda x: x + 1"}]})
    assert cfg.reaching.func is math.cos
    assert cfg.terms[0].func is math.tan
    assert cfg.terms[1].func(1) == 2


def test_a_literal_takes_its_choices_only():
    assert updated({"scene": {"engine": "warp"}}).scene.engine == "warp"
    with pytest.raises(ConfigError, match=r"^scene\.engine: 'wrap' is not a choice; did you mean 'warp'\?$"):
        updated({"scene": {"engine": "wrap"}})


def test_enums_paths_tensors_and_slices_are_read_from_plain_values():
    cfg = updated(
        {
            "scene": {
                "mode": "SLOW",
                "folder": "out",
                "tensor": [1, 2],
                "robot": {"joint_ids": "slice(1,None,2)"},
            }
        }
    )
    assert cfg.scene.mode is Mode.SLOW
    assert cfg.scene.folder == Path("out")
    assert torch.equal(cfg.scene.tensor, torch.tensor([1.0, 2.0]))
    assert cfg.scene.robot.joint_ids == slice(1, None, 2)


def test_question_marks_mean_missing():
    assert updated({"reaching": {"weight": "???"}}).reaching.weight is MISSING


def test_values_are_not_shared_with_the_dictionary():
    data = {"params": {"names": ["a"]}}
    cfg = TermCfg()
    cfg.from_dict(data)
    cfg.params["names"].append("b")
    assert data == {"params": {"names": ["a"]}}


def test_something_that_is_no_dictionary_is_a_type_error():
    with pytest.raises(TypeError, match="expected a dictionary, got int 3"):
        update_class_from_dict(EnvCfg(), 3)  # type: ignore[arg-type]
