"""How managers read, check, copy and bind their terms, whatever the manager."""

import pytest
import torch

from lift_lab.managers import ManagerTermBase, RewardManager, RewardTermCfg, SceneEntityCfg
from lift_lab.utils import configclass


def ones(env):
    return torch.ones(env.num_envs)


def distance(env, std, command_name="pose", *, sharp=False):
    return torch.full((env.num_envs,), float(std))


def with_extras(env, std, **options):
    return torch.zeros(env.num_envs)


def selected(env, asset_cfg=SceneEntityCfg("robot", joint_names=["finger"])):
    env.calls.append(asset_cfg.joint_ids)
    return torch.zeros(env.num_envs)


class Counter(ManagerTermBase):
    def __init__(self, cfg, env):
        super().__init__(cfg, env)
        self.count = torch.zeros(self.num_envs, device=self.device)

    def reset(self, env_ids=None):
        self.count[env_ids] = 0

    def __call__(self, env, step=1.0):
        self.count += step
        return self.count.clone()


class WithoutSuper(ManagerTermBase):
    def __init__(self, cfg, env):
        self.value = cfg.params["value"]

    def __call__(self, env, value):
        return torch.full((self.num_envs,), self.value)


class WithoutCall(ManagerTermBase):
    pass


class NotATerm:
    def __call__(self, env):
        return ones(env)


def one_term(env, func, weight=1.0, **params):
    return RewardManager({"term": RewardTermCfg(func=func, weight=weight, params=params)}, env)


def test_a_dict_and_a_configclass_give_the_same_manager(env):
    @configclass
    class Rewards:
        near = RewardTermCfg(func=distance, weight=2.0, params={"std": 3.0})
        alive: RewardTermCfg = RewardTermCfg(func=ones, weight=1)

    from_class = RewardManager(Rewards(), env)
    from_dict = RewardManager(
        {
            "near": RewardTermCfg(func=distance, weight=2.0, params={"std": 3.0}),
            "alive": RewardTermCfg(func=ones, weight=1),
        },
        env,
    )
    assert from_class.active_terms == from_dict.active_terms == ["near", "alive"]
    assert torch.equal(from_class.compute(0.1), from_dict.compute(0.1))


def test_a_term_set_to_none_is_left_out(env):
    cfg = {"a": RewardTermCfg(func=ones, weight=1.0), "b": None}
    assert RewardManager(cfg, env).active_terms == ["a"]


def test_edits_of_the_managers_config_do_not_reach_the_environments_config(env):
    cfg = {"a": RewardTermCfg(func=distance, weight=1.0, params={"std": 1.0})}
    manager = RewardManager(cfg, env)
    manager.get_term_cfg("a").weight = 5.0
    manager.get_term_cfg("a").params["std"] = 2.0
    assert cfg["a"].weight == 1.0
    assert cfg["a"].params == {"std": 1.0}
    assert manager.cfg["a"].weight == 5.0
    assert torch.allclose(manager.compute(0.1), torch.full((4,), 5.0 * 2.0 * 0.1))


def test_two_terms_that_share_a_config_object_are_independent(env):
    shared = RewardTermCfg(func=Counter, weight=1.0)
    manager = RewardManager({"a": shared, "b": shared}, env)
    assert manager.get_term_cfg("a").func is not manager.get_term_cfg("b").func


def test_a_missing_parameter_is_named(env):
    with pytest.raises(ValueError, match=r"term 'term'.*missing 'std'"):
        one_term(env, distance)


def test_an_unexpected_parameter_is_named_with_the_closest_one(env):
    with pytest.raises(ValueError, match=r"unexpected 'comand_name' \(did you mean 'command_name'"):
        one_term(env, distance, std=1.0, comand_name="pose")


def test_a_parameter_of_a_function_that_takes_none_is_refused(env):
    with pytest.raises(ValueError, match="unexpected 'std'"):
        one_term(env, ones, std=1.0)


def test_parameters_with_defaults_and_keyword_only_ones_are_optional(env):
    one_term(env, distance, std=1.0)
    one_term(env, distance, std=1.0, sharp=True, command_name="x")


def test_a_function_with_keyword_arguments_takes_any_parameter_but_env(env):
    one_term(env, with_extras, std=1.0, anything=2)
    with pytest.raises(ValueError, match="unexpected 'env'"):
        RewardManager({"t": RewardTermCfg(func=with_extras, weight=1.0, params={"std": 1.0, "env": 2})}, env)


def test_a_function_that_does_not_take_env_is_refused(env):
    with pytest.raises(ValueError, match="must take \\(env\\)"):
        one_term(env, lambda: 1.0)


def test_a_string_names_a_function(env):
    manager = one_term(env, "torch:numel", weight=0.0)
    assert manager.get_term_cfg("term").func is torch.numel


@pytest.mark.parametrize("name", ["no_such_module:f", "torch:no_such_function", "nonsense"])
def test_a_string_that_names_nothing_is_refused_with_the_terms_name(env, name):
    with pytest.raises(ValueError, match="term 'term'"):
        one_term(env, name)


def test_a_func_that_is_not_callable_is_refused(env):
    with pytest.raises(AttributeError, match=r"term 'term'.*not callable"):
        one_term(env, 3.0)


def test_a_field_that_is_no_term_config_is_refused(env):
    with pytest.raises(TypeError, match="term 'oops' must be of type RewardTermCfg, not 'float'"):
        RewardManager({"oops": 1.0}, env)


def test_a_class_term_is_built_once_and_keeps_its_state(env):
    manager = one_term(env, Counter, step=2.0)
    manager.compute(1.0)
    assert torch.equal(manager.compute(1.0), torch.full((4,), 4.0))
    manager.reset([0, 2])
    assert torch.equal(manager.compute(1.0), torch.tensor([2.0, 6.0, 2.0, 6.0]))


def test_a_class_term_that_never_calls_super_still_has_its_environment(env):
    manager = one_term(env, WithoutSuper, value=7.0)
    assert torch.equal(manager.compute(1.0), torch.full((4,), 7.0))
    assert manager.get_term_cfg("term").func.cfg is manager.get_term_cfg("term")


def test_the_arguments_of_a_class_term_are_those_of_its_call(env):
    with pytest.raises(ValueError, match="unexpected 'stepp' \\(did you mean 'step'"):
        one_term(env, Counter, stepp=1.0)


def test_a_class_term_without_call_is_refused(env):
    with pytest.raises(NotImplementedError, match="WithoutCall"):
        one_term(env, WithoutCall)


def test_a_class_that_is_no_term_is_refused(env):
    with pytest.raises(TypeError, match="NotATerm"):
        one_term(env, NotATerm)


def test_a_class_term_serializes_with_the_name_of_its_class(env):
    term = one_term(env, Counter).get_term_cfg("term").func
    assert term.serialize()["cfg"]["func"].endswith(":Counter")
    assert term.__name__ == "Counter"


def test_scene_entities_in_parameters_are_resolved_also_in_nested_ones(env):
    def nested(env, entities):
        return torch.zeros(env.num_envs)

    manager = one_term(env, nested, entities={"a": [SceneEntityCfg("robot", joint_names=["finger"])]})
    assert manager.get_term_cfg("term").params["entities"]["a"][0].joint_ids == [2]


def test_a_scene_entity_that_does_not_exist_is_reported_with_term_and_parameter(env):
    def named(env, asset_cfg):
        return torch.zeros(env.num_envs)

    with pytest.raises(ValueError, match=r"term 'term', param 'asset_cfg'.*'robt'.*did you mean 'robot'"):
        one_term(env, named, asset_cfg=SceneEntityCfg("robt"))


def test_a_default_argument_that_selects_by_name_is_resolved_too(env):
    one_term(env, selected).compute(0.1)
    assert env.calls == [[2]]


def test_terms_are_found_by_regular_expression(env):
    names = ["reach_left", "reach_right", "lift"]
    manager = RewardManager({name: RewardTermCfg(func=ones, weight=1.0) for name in names}, env)
    assert manager.find_terms("reach_.*") == ["reach_left", "reach_right"]
    with pytest.raises(ValueError):
        manager.find_terms("push")


def test_an_unknown_term_is_reported_with_the_closest_name(env):
    with pytest.raises(ValueError, match=r"'lfting' not found.*did you mean 'lifting'"):
        RewardManager({"lifting": RewardTermCfg(func=ones, weight=1.0)}, env).get_term_cfg("lfting")


def test_setting_a_new_config_resolves_it(env):
    manager = one_term(env, ones)
    manager.set_term_cfg("term", RewardTermCfg(func=Counter, weight=3.0))
    assert torch.equal(manager.compute(1.0), torch.full((4,), 3.0))
    manager.reset()
    assert torch.equal(manager.compute(1.0), torch.full((4,), 3.0))
    with pytest.raises(ValueError, match="missing 'std'"):
        manager.set_term_cfg("term", RewardTermCfg(func=distance, weight=1.0))
    with pytest.raises(TypeError):
        manager.set_term_cfg("term", SceneEntityCfg("robot"))


def test_a_copy_of_a_config_shares_its_term_and_not_a_copy_of_the_environment(env):
    manager = one_term(env, Counter)
    cfg = manager.get_term_cfg("term")
    copied = cfg.replace(weight=2.0)
    assert copied.func is cfg.func
    manager.set_term_cfg("term", copied)
    assert torch.equal(manager.compute(1.0), torch.full((4,), 2.0))
