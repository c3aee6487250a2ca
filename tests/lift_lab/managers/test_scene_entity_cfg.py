"""Selecting joints and bodies of a scene entity."""

import pytest

from lift_lab.managers import SceneEntityCfg
from lift_lab.utils.errors import ConfigError


def resolved(env, *args, **kwargs):
    cfg = SceneEntityCfg(*args, **kwargs)
    cfg.resolve(env.scene)
    return cfg


def test_nothing_selected_is_everything(env):
    cfg = resolved(env, "robot")
    assert cfg.joint_ids == slice(None)
    assert cfg.body_ids == slice(None)
    assert cfg.joint_names is None


def test_names_become_ids_in_the_entitys_order(env):
    assert resolved(env, "robot", joint_names=["finger", "shoulder"]).joint_ids == [0, 2]
    assert resolved(env, "robot", body_names="ha.*").body_ids == [1]


def test_preserve_order_keeps_the_order_given(env):
    cfg = resolved(env, "robot", joint_names=["finger", "shoulder"], preserve_order=True)
    assert cfg.joint_ids == [2, 0]


@pytest.mark.parametrize("names", [".*", ["shoulder", "elbow", "finger"], ["finger", "elbow", "shoulder"]])
def test_the_full_set_in_entity_order_is_a_slice(env, names):
    assert resolved(env, "robot", joint_names=names).joint_ids == slice(None)


def test_the_full_set_in_another_order_is_a_list(env):
    cfg = resolved(env, "robot", joint_names=["finger", "elbow", "shoulder"], preserve_order=True)
    assert cfg.joint_ids == [2, 1, 0]


def test_a_rigid_objects_body_is_selected_by_its_prims_name(env):
    assert resolved(env, "object", body_names="Object").body_ids == slice(None)


def test_ids_become_names(env):
    assert resolved(env, "robot", joint_ids=[2, 0]).joint_names == ["finger", "shoulder"]
    assert resolved(env, "robot", body_ids=1).body_names == ["hand"]
    assert resolved(env, "robot", body_ids=1).body_ids == [1]


@pytest.mark.parametrize(
    "selection",
    [{"joint_names": ["fin.*"]}, {"joint_ids": [2, 0]}, {"joint_names": ".*"}, {"body_ids": slice(0, 1)}],
)
def test_resolving_twice_changes_nothing(env, selection):
    cfg = resolved(env, "robot", **selection)
    before = cfg.to_dict()
    cfg.resolve(env.scene)
    assert cfg.to_dict() == before


def test_names_and_ids_that_agree_are_accepted(env):
    assert resolved(env, "robot", joint_names=["elbow"], joint_ids=[1]).joint_ids == [1]


def test_names_and_ids_that_disagree_are_refused(env):
    with pytest.raises(ValueError, match=r"\['elbow'\].*ids \[1\].*joint_ids is \[2\]"):
        resolved(env, "robot", joint_names=["elbow"], joint_ids=[2])


def test_a_pattern_must_match_a_whole_name(env):
    with pytest.raises(ValueError, match="fing"):
        resolved(env, "robot", joint_names=["fing"])


def test_a_name_may_match_only_one_pattern(env):
    with pytest.raises(ValueError, match="finger"):
        resolved(env, "robot", joint_names=["finger", "f.*"])


def test_an_unknown_entity_is_reported_with_the_closest_name(env):
    with pytest.raises(ValueError, match="no entity 'objct': did you mean 'object'"):
        resolved(env, "objct")


def test_an_entity_without_such_parts_is_named(env):
    with pytest.raises(ValueError, match=r"'object' is a FakeBox.*joint_names"):
        resolved(env, "object", joint_names=["x"])


def test_an_id_beyond_the_entitys_parts_is_named(env):
    with pytest.raises(ConfigError, match=r"'robot' has no joint_ids \[99\]: it has 3, 0 = 'shoulder'"):
        resolved(env, "robot", joint_ids=[0, 99])
