"""Names by regular expression, callables by name, case, suggestions."""

import math

import pytest
import torch

from lift_lab.utils import string as string_utils
from lift_lab.utils.errors import (
    ConfigError,
    FileError,
    LiftLabError,
    NotFoundError,
    PhysicsError,
    suggest,
)

JOINTS = ["panda_joint1", "panda_joint2", "panda_finger_joint1", "panda_finger_joint2"]


class Outer:
    class Inner:
        pass

    def method(self):
        pass


def test_names_come_in_the_order_of_the_list_or_of_the_expressions():
    keys = ["panda_finger_.*", "panda_joint.*"]
    assert string_utils.resolve_matching_names(keys, JOINTS) == ([0, 1, 2, 3], JOINTS)
    ids, names = string_utils.resolve_matching_names(keys, JOINTS, preserve_order=True)
    assert ids == [2, 3, 0, 1]
    assert names == [JOINTS[i] for i in ids]


def test_an_expression_must_match_the_whole_name():
    with pytest.raises(ValueError, match="no name matches 'panda_joint'; did you mean 'panda_joint1'"):
        string_utils.resolve_matching_names("panda_joint", JOINTS)


def test_no_match_names_the_candidates():
    with pytest.raises(ConfigError, match="no name matches 'x', 'y'; choose one of: 'panda_joint1', 'panda_joint2'"):
        string_utils.resolve_matching_names(["panda_joint1", "x", "y"], JOINTS)


def test_a_name_that_two_expressions_match_is_refused():
    with pytest.raises(ValueError, match=r"Multiple matches for 'panda_joint1': '\.\*', 'panda_joint1'"):
        string_utils.resolve_matching_names([".*", "panda_joint1"], JOINTS)


def test_a_malformed_expression_is_refused():
    with pytest.raises(ValueError, match=r"'panda_\(' is not a regular expression"):
        string_utils.resolve_matching_names("panda_(", JOINTS)


def test_values_follow_their_names():
    data = {"panda_finger_.*": 2.0, "panda_joint[1]": 1.0}
    assert string_utils.resolve_matching_names_values(data, JOINTS) == (
        [0, 2, 3],
        [JOINTS[0], *JOINTS[2:]],
        [1.0, 2.0, 2.0],
    )
    ids, _, values = string_utils.resolve_matching_names_values(data, JOINTS, preserve_order=True)
    assert (ids, values) == ([2, 3, 0], [2.0, 2.0, 1.0])


def test_values_without_a_name_are_refused_unless_not_strict():
    data = {"panda_joint1": 1.0, "nothing": 2.0}
    with pytest.raises(ValueError, match="no name matches 'nothing'"):
        string_utils.resolve_matching_names_values(data, JOINTS)
    assert string_utils.resolve_matching_names_values(data, JOINTS, strict=False)[2] == [1.0]
    with pytest.raises(TypeError):
        string_utils.resolve_matching_names_values(["a"], JOINTS)  # type: ignore[arg-type]


@pytest.mark.parametrize("value", [math.sin, Outer, Outer.Inner, Outer.method, torch.tanh, torch.nn.functional.elu])
def test_a_callable_is_found_again_by_its_name(value):
    assert string_utils.string_to_callable(string_utils.callable_to_string(value)) is value


def test_a_lambda_becomes_its_source_even_beside_another():
    first, second = lambda x: x + 1, lambda x: (x, 2)[0] * 3
    multi_line = [
        lambda x: (
            x  # a comment
            - 5
        ),
    ]
    assert string_utils.callable_to_string(first) == "lambda x: x + 1"
    assert string_utils.callable_to_string(second) == "lambda x: (x, 2)[0] * 3"
    assert string_utils.string_to_callable("lambda x: (x, 2)[0] * 3")(2) == 6
    with_default = [lambda x=1: x, lambda y=2: y]
    assert [string_utils.callable_to_string(f) for f in with_default] == ["lambda x=1: x", "lambda y=2: y"]
    text = string_utils.callable_to_string(multi_line[0])
    assert eval(f"({text})")(7) == 2


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("math", "expected 'module:name'"),
        ("maths:sin", "No module named 'maths'"),
        ("math:sine", "'math' has no 'sine'; did you mean 'sin'"),
        ("math:pi", "not callable but a float"),
        (3, "expected a string"),
    ],
)
def test_a_callable_that_cannot_be_found_is_a_value_error(name, message):
    with pytest.raises(ValueError, match=message):
        string_utils.string_to_callable(name)


def test_lambda_expressions_are_recognised():
    assert string_utils.is_lambda_expression("lambda x: x")
    assert not string_utils.is_lambda_expression("lambda_function")
    assert not string_utils.is_lambda_expression("module:lambda")


def test_slices_are_read_from_text():
    assert string_utils.string_to_slice("slice(None,None,None)") == slice(None)
    assert string_utils.string_to_slice("slice(1, -2, 3)") == slice(1, -2, 3)
    for text in ("slice(1,2)", "slice(a,b,c)", "1:2"):
        with pytest.raises(ValueError, match="not a slice"):
            string_utils.string_to_slice(text)


def test_case_is_changed_both_ways():
    assert string_utils.to_camel_case("rigid_object_cfg") == "rigidObjectCfg"
    assert string_utils.to_camel_case("rigid_object_cfg", to="CC") == "RigidObjectCfg"
    assert string_utils.to_snake_case("RigidObjectCfg") == "rigid_object_cfg"
    assert string_utils.to_snake_case("ManagerBasedRLEnv2Cfg") == "manager_based_rl_env2_cfg"
    with pytest.raises(ValueError, match="'cC' or 'CC'"):
        string_utils.to_camel_case("a", to="c")


def test_a_unique_name_is_numbered_from_one():
    taken = {"cube", "cube_1"}
    assert string_utils.find_unique_string_name("cube", lambda name: name not in taken) == "cube_2"
    assert string_utils.find_unique_string_name("table", lambda name: name not in taken) == "table"


def test_the_root_above_the_first_expression_of_a_prim_path():
    assert string_utils.find_root_prim_path_from_regex("/World/envs/env_.*/Robot") == ("/World/envs", 3)
    assert string_utils.find_root_prim_path_from_regex("/World/Robot") == (None, None)


def test_suggestions_prefer_close_names_and_else_list_all():
    assert suggest("reachin_object", ["reaching_object", "lifting_object"]) == (
        "did you mean 'reaching_object', 'lifting_object'?"
    )
    assert suggest("PANDA", ["panda"]) == "did you mean 'panda'?"
    assert suggest("zzz", ["a", "b"]) == "choose one of: 'a', 'b'"
    assert suggest("zzz", [f"n{i}" for i in range(20)]).endswith("... (8 more)")
    assert suggest("a", []) == "there are none to choose from"


@pytest.mark.parametrize(
    ("error", "builtin"),
    [
        (ConfigError, ValueError),
        (NotFoundError, KeyError),
        (FileError, FileNotFoundError),
        (PhysicsError, RuntimeError),
    ],
)
def test_errors_are_the_natural_builtin_and_print_their_message_plainly(error, builtin):
    assert issubclass(error, LiftLabError)
    assert issubclass(error, builtin)
    assert str(error("no 'x'; did you mean 'y'?")) == "no 'x'; did you mean 'y'?"
