"""The ``@configclass`` decorator: what is copied, and what stays the same object."""

from __future__ import annotations

import copy
import dataclasses
import pickle
from collections.abc import Callable
from dataclasses import MISSING

import pytest
from example_configs import EnvCfg, ViewerCfg

from lift_lab.utils import configclass


def test_mutable_defaults_are_not_shared_between_instances():
    a, b = EnvCfg(num_envs=1), EnvCfg(num_envs=1)
    a.viewer.eye[0] = 0.0
    a.params["names"].append("b")
    assert b.viewer.eye == [7.5, 7.5, 7.5]
    assert b.params["names"] == ["a"]


def test_mutable_defaults_are_not_shared_with_a_subclass():
    @configclass
    class Child(EnvCfg):
        extra = [1]

    child, parent = Child(), EnvCfg()
    child.viewer.eye[0] = 0.0
    child.params["std"] = 9.0
    assert parent.viewer.eye[0] == 7.5
    assert parent.params["std"] == 0.1
    assert Child().params["std"] == 0.1


def test_values_passed_in_and_assigned_in_post_init_are_copied():
    shared = ViewerCfg()

    @configclass
    class Cfg:
        passed: ViewerCfg = MISSING
        assigned: ViewerCfg = MISSING
        nested: EnvCfg = EnvCfg()

        def __post_init__(self):
            self.assigned = shared
            self.nested.viewer = shared
            self.added = shared

    cfg = Cfg(passed=shared)
    for value in (cfg.passed, cfg.assigned, cfg.nested.viewer, cfg.added):
        assert value == shared
        assert value is not shared


def test_a_module_level_default_is_read_when_the_instance_is_made():
    marker = ViewerCfg()

    @configclass
    class Cfg:
        viewer = marker

    marker.eye = [0.0, 0.0, 0.0]
    assert Cfg().viewer.eye == [0.0, 0.0, 0.0]


def test_a_bound_method_as_value_is_shared_with_its_object():
    class Env:
        def term(self):
            return self

    @configclass
    class Cfg:
        func: Callable = MISSING

    env = Env()
    assert Cfg(func=env.term).func() is env


def test_copy_is_independent_and_does_not_run_post_init_again():
    @configclass
    class Cfg:
        value = 1
        values = [1]

        def __post_init__(self):
            self.value = 2

    cfg = Cfg()
    cfg.value = 3
    twin = cfg.copy()
    twin.values.append(2)
    assert twin.value == 3
    assert cfg.values == [1]


def test_replace_changes_fields_of_an_independent_copy():
    cfg = EnvCfg(num_envs=1)
    other = cfg.replace(num_envs=2, params={"std": 1.0})
    other.viewer.eye[0] = 0.0
    assert (cfg.num_envs, other.num_envs) == (1, 2)
    assert cfg.viewer.eye[0] == 7.5
    assert cfg.params["std"] == 0.1


def test_replace_names_the_nearest_field_to_a_wrong_one():
    with pytest.raises(TypeError, match=r"EnvCfg has no field 'num_env'; did you mean 'num_envs'\?"):
        EnvCfg().replace(num_env=3)


def test_missing_stays_the_same_object_through_copies_and_pickles():
    assert EnvCfg().copy().num_envs is MISSING
    assert copy.deepcopy({"a": [MISSING]})["a"][0] is MISSING
    assert pickle.loads(pickle.dumps(EnvCfg())).num_envs is MISSING


def test_a_frozen_configclass_can_be_made_copied_and_replaced():
    @configclass(frozen=True)
    class Cfg:
        values: list = [1]

    cfg = Cfg(values=[2])
    assert cfg.replace(values=[3]).values == [3]
    assert cfg.copy().values == [2]
    with pytest.raises(dataclasses.FrozenInstanceError):
        cfg.values = []
