"""Observations: the order of processing, history, concatenation, and tensors that stay what they were."""

import pytest
import torch

from lift_lab.managers import (
    ManagerTermBase,
    ObservationGroupCfg,
    ObservationManager,
    ObservationTermCfg,
)
from lift_lab.utils import configclass, modifiers
from lift_lab.utils import noise as noise_utils


def state(env):
    """A tensor that the simulation overwrites in place, like joint positions. Shape is (num_envs, 2)."""
    return env.state


def single(env):
    return env.state[:, :1]


def image(env, channels=1):
    return torch.full((env.num_envs, 3, 2, channels), float(channels))


@pytest.fixture
def env(env_factory):
    """Two environments whose state is [[1, 2], [3, 4]]."""
    return env_factory(num_envs=2, state=torch.tensor([[1.0, 2.0], [3.0, 4.0]]))


def group(enable_corruption=False, concatenate_terms=True, concatenate_dim=-1, **settings):
    """A group of terms and group settings."""

    @configclass
    class Group(ObservationGroupCfg):
        pass

    names = ("history_length", "flatten_history_dim")
    cfg = Group(
        enable_corruption=enable_corruption,
        concatenate_terms=concatenate_terms,
        concatenate_dim=concatenate_dim,
        **{name: settings.pop(name) for name in names if name in settings},
    )
    vars(cfg).update(settings)
    return cfg


def manager_of(env, **settings):
    return ObservationManager({"policy": group(**settings)}, env)


def values(env, update_history=False, **term):
    """The values of one term in environment 0."""
    manager = manager_of(env, enable_corruption=True, t=ObservationTermCfg(func=state, **term))
    return manager.compute(update_history)["policy"][0].tolist()


def test_a_group_is_its_terms_one_after_the_other(env):
    manager = manager_of(env, b=ObservationTermCfg(func=state), gone=None, a=ObservationTermCfg(func=single))
    assert manager.compute()["policy"].tolist() == [[1.0, 2.0, 1.0], [3.0, 4.0, 3.0]]
    assert manager.active_terms == {"policy": ["b", "a"]}
    assert manager.group_obs_dim == {"policy": (3,)}
    assert manager.group_obs_term_dim == {"policy": [(2,), (1,)]}


def test_a_configclass_of_groups_gives_the_same(env):
    @configclass
    class Observations:
        @configclass
        class PolicyCfg(ObservationGroupCfg):
            b = ObservationTermCfg(func=state)
            a = ObservationTermCfg(func=single)

            def __post_init__(self):
                self.concatenate_terms = True

        policy: PolicyCfg = PolicyCfg()

    assert ObservationManager(Observations(), env).compute()["policy"].tolist()[1] == [3.0, 4.0, 3.0]


def test_the_lift_group_has_36_observations(env):
    widths = {"joint_pos": 9, "joint_vel": 9, "object": 3, "command": 7, "actions": 8}
    terms = {k: ObservationTermCfg(func=lambda env, n: torch.zeros(2, n), params={"n": n}) for k, n in widths.items()}
    assert manager_of(env, **terms).group_obs_dim["policy"] == (36,)


def test_processing_runs_modifiers_noise_clip_scale(env):
    add_10 = modifiers.ModifierCfg(func=modifiers.bias, params={"value": 10.0})
    double = modifiers.ModifierCfg(func=modifiers.scale, params={"multiplier": 2.0})
    noise = noise_utils.ConstantNoiseCfg(bias=100.0)
    assert values(env, modifiers=[add_10, double]) == [22.0, 24.0]
    assert values(env, modifiers=[double, add_10]) == [12.0, 14.0]
    assert values(env, modifiers=[add_10], noise=noise) == [111.0, 112.0]
    # (1 + 10 + 100, 2 + 10 + 100) clipped at 111.5, then times (2, 4)
    everything = {"modifiers": [add_10], "noise": noise, "clip": (0.0, 111.5), "scale": (2.0, 4.0)}
    assert values(env, **everything) == [222.0, 446.0]
    assert values(env, update_history=True, history_length=2, **everything) == [222.0, 446.0, 222.0, 446.0]


@pytest.mark.parametrize(("scale", "expected"), [(2, [2.0, 4.0]), (0.5, [0.5, 1.0]), ((3.0, -1.0), [3.0, -2.0])])
def test_the_scale_is_a_number_or_a_tuple(env, scale, expected):
    assert values(env, scale=scale) == expected


def test_a_scale_that_does_not_fit_is_refused(env):
    with pytest.raises(ValueError, match=r"'policy/t'.*3 entries, the observation 2"):
        values(env, scale=(1.0, 2.0, 3.0))
    with pytest.raises(TypeError, match=r"'policy/t'.*scale"):
        values(env, scale="2")


def test_without_corruption_only_the_noise_is_dropped(env):
    term = ObservationTermCfg(
        func=state,
        modifiers=[modifiers.ModifierCfg(func=modifiers.bias, params={"value": 10.0})],
        noise=noise_utils.ConstantNoiseCfg(bias=100.0),
        clip=(0.0, 11.5),
        scale=2.0,
    )
    manager = manager_of(env, enable_corruption=False, t=term)
    assert manager.compute()["policy"][0].tolist() == [22.0, 23.0]


def test_processing_leaves_the_simulations_tensor_alone(env):
    def in_place(data, value):
        return data.add_(value)

    modifier = modifiers.ModifierCfg(func=in_place, params={"value": 1.0})
    values(env, modifiers=[modifier], clip=(0.0, 1.0), scale=5.0)
    assert env.state.tolist() == [[1.0, 2.0], [3.0, 4.0]]


@pytest.mark.parametrize("concatenate", [True, False])
@pytest.mark.parametrize("history_length", [0, 3])
@pytest.mark.parametrize("flatten", [True, False])
def test_observations_handed_out_never_change(env, concatenate, history_length, flatten):
    term = ObservationTermCfg(func=state, history_length=history_length, flatten_history_dim=flatten)
    manager = manager_of(env, concatenate_terms=concatenate, t=term)
    first = manager.compute(update_history=True)["policy"]
    first = first if concatenate else first["t"]
    before = first.clone()
    env.state += 5.0
    manager.compute(update_history=True)
    manager.reset()
    manager.compute(update_history=True)
    assert torch.equal(first, before)


def test_a_class_modifier_keeps_state_for_each_term_and_is_reset(env):
    """An integrator of dt 0.5 by the trapezoid rule gives 0.5 * 0.5 * x in its first step from rest."""
    shared = modifiers.IntegratorCfg(dt=0.5)
    once = ObservationTermCfg(func=state, modifiers=[shared])
    twice = ObservationTermCfg(func=state, modifiers=[shared, shared])
    manager = manager_of(env, a=once, b=twice)
    single_step = manager.compute()["policy"][:, :2]
    assert torch.allclose(single_step, 0.25 * env.state)
    assert not torch.allclose(manager.compute()["policy"][:, :2], single_step)
    manager.reset([0])
    third = manager.compute()["policy"][:, :2]
    assert torch.allclose(third[0], single_step[0])
    assert not torch.allclose(third[1], single_step[1])


def test_wrong_modifiers_are_refused_with_the_terms_name(env):
    with pytest.raises(ValueError, match=r"'policy/t', a modifier.*missing 'bounds'.*unexpected 'min'"):
        values(env, modifiers=[modifiers.ModifierCfg(func=modifiers.clip, params={"min": 0.0})])
    with pytest.raises(TypeError, match="ModifierCfg"):
        values(env, modifiers=[modifiers.bias])
    with pytest.raises(TypeError, match="ModifierBase"):
        values(env, modifiers=[modifiers.ModifierCfg(func=dict)])


def test_a_noise_model_draws_its_bias_at_resets(env):
    noise = noise_utils.NoiseModelWithAdditiveBiasCfg(
        noise_cfg=noise_utils.ConstantNoiseCfg(bias=0.0),
        bias_noise_cfg=noise_utils.UniformNoiseCfg(n_min=10.0, n_max=20.0, operation="abs"),
    )
    manager = manager_of(env, enable_corruption=True, t=ObservationTermCfg(func=state, noise=noise))
    manager.reset()
    bias = manager.compute()["policy"] - env.state
    assert bias.min() >= 10.0
    assert bias.max() <= 20.0
    assert torch.allclose(manager.compute()["policy"] - env.state, bias)
    manager.reset([1])
    after = manager.compute()["policy"] - env.state
    assert torch.allclose(after[0], bias[0])
    assert not torch.allclose(after[1], bias[1])


def test_the_first_value_fills_the_history_and_the_oldest_comes_first(env):
    manager = manager_of(env, t=ObservationTermCfg(func=single, history_length=3))
    assert manager.group_obs_dim["policy"] == (3,)
    seen = []
    for step in range(4):
        env.state[:] = float(step)
        seen.append(manager.compute(update_history=True)["policy"][0].tolist())
    assert seen == [[0.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, 1.0, 2.0], [1.0, 2.0, 3.0]]


def test_after_a_reset_the_next_value_fills_the_history_of_that_environment(env):
    manager = manager_of(env, t=ObservationTermCfg(func=single, history_length=3))
    for step in (1.0, 2.0, 3.0):
        env.state[:] = step
        manager.compute(update_history=True)
    manager.reset([1])
    env.state[:] = 9.0
    assert manager.compute(update_history=True)["policy"].tolist() == [[2.0, 3.0, 9.0], [9.0, 9.0, 9.0]]
    env.state[:] = 10.0
    assert manager.compute(update_history=True)["policy"].tolist() == [[3.0, 9.0, 10.0], [9.0, 9.0, 10.0]]


def test_computing_without_update_leaves_the_history_as_it_is(env):
    manager = manager_of(env, t=ObservationTermCfg(func=single, history_length=2))
    env.state[:] = 1.0
    assert manager.compute()["policy"].tolist() == [[1.0, 1.0], [1.0, 1.0]]  # nothing stored yet
    env.state[:] = 2.0
    manager.compute(update_history=True)
    env.state[:] = 3.0
    assert manager.compute()["policy"].tolist() == [[2.0, 2.0], [2.0, 2.0]]
    manager.reset([0])
    assert manager.compute()["policy"].tolist() == [[3.0, 3.0], [2.0, 2.0]]
    assert manager.compute(update_history=True)["policy"].tolist() == [[3.0, 3.0], [2.0, 3.0]]


def test_a_preview_is_what_the_next_update_gives_and_leaves_no_trace(env):
    low_pass = modifiers.DigitalFilterCfg(A=[-0.5], B=[0.5])
    term = ObservationTermCfg(func=single, history_length=3, modifiers=[low_pass])
    manager = manager_of(env, t=term, u=ObservationTermCfg(func=state))
    twin = manager_of(env, t=term, u=ObservationTermCfg(func=state))
    for value in (2.0, 4.0):
        env.state[:] = value
        previewed = [manager.preview()["policy"] for _ in range(2)]
        updated = manager.compute(update_history=True)["policy"]
        assert torch.equal(previewed[0], updated)
        assert torch.equal(previewed[1], updated)
        assert torch.equal(twin.compute(update_history=True)["policy"], updated)


def test_a_preview_leaves_a_noise_model_with_a_state_where_it_was(env):
    class Walk(noise_utils.NoiseModel):
        def __init__(self, *args, **kwargs):
            super().__init__(*args, **kwargs)
            self.calls = 0

        def __call__(self, data):
            self.calls += 1
            return data + self.calls

    cfg = noise_utils.NoiseModelCfg(class_type=Walk, noise_cfg=noise_utils.ConstantNoiseCfg(bias=0.0))
    manager = manager_of(env, t=ObservationTermCfg(func=state, noise=cfg), enable_corruption=True)
    before = manager.compute()["policy"]
    assert torch.equal(manager.preview()["policy"], before + 1)
    assert torch.equal(manager.preview()["policy"], before + 1)
    assert torch.equal(manager.compute()["policy"], before + 1)


def test_each_term_is_one_block_of_history(env):
    manager = manager_of(env, a=ObservationTermCfg(func=state, history_length=2), b=ObservationTermCfg(func=single))
    manager.compute(update_history=True)
    env.state *= 10.0
    assert manager.compute(update_history=True)["policy"][0].tolist() == [1.0, 2.0, 10.0, 20.0, 10.0]


def test_the_groups_history_overrides_its_terms(env):
    terms = {
        "a": ObservationTermCfg(func=state, history_length=5, flatten_history_dim=False),
        "b": ObservationTermCfg(func=single),
    }
    manager = manager_of(env, history_length=3, **terms)
    assert manager.group_obs_term_dim["policy"] == [(6,), (3,)]
    assert manager_of(env, history_length=0, **terms).group_obs_term_dim["policy"] == [(2,), (1,)]


def test_a_history_that_is_not_flattened_keeps_its_dimension(env):
    term = ObservationTermCfg(func=state, history_length=3, flatten_history_dim=False)
    manager = manager_of(env, t=term)
    assert manager.group_obs_dim["policy"] == (3, 2)
    assert manager.compute(update_history=True)["policy"].shape == (2, 3, 2)
    grouped = manager_of(env, t=ObservationTermCfg(func=state), history_length=3, flatten_history_dim=False)
    assert grouped.group_obs_dim["policy"] == (3, 2)


@pytest.mark.parametrize(("dim", "shape"), [(-1, (3, 2, 2)), (2, (3, 2, 2)), (0, (6, 2, 1)), (1, (3, 4, 1))])
def test_terms_are_concatenated_along_the_dimension_asked_for(env, dim, shape):
    manager = manager_of(
        env, concatenate_dim=dim, a=ObservationTermCfg(func=image), b=ObservationTermCfg(func=image, scale=2.0)
    )
    assert manager.group_obs_dim["policy"] == shape
    assert manager.compute()["policy"].shape == (2, *shape)
    parts = dict(manager.get_active_iterable_terms(1))
    assert torch.equal(torch.tensor(parts["policy-b"]), torch.full((3, 2, 1), 2.0))


def test_a_group_that_is_not_concatenated_is_a_dict(env):
    manager = manager_of(
        env, concatenate_terms=False, a=ObservationTermCfg(func=state), b=ObservationTermCfg(func=image)
    )
    observations = manager.compute()["policy"]
    assert list(observations) == ["a", "b"]
    assert observations["b"].shape == (2, 3, 2, 1)
    assert manager.group_obs_dim["policy"] == [(2,), (3, 2, 1)]
    assert manager.group_obs_concatenate == {"policy": False}


@pytest.mark.parametrize(
    "terms",
    [
        {"a": ObservationTermCfg(func=state), "b": ObservationTermCfg(func=image)},
        {"a": ObservationTermCfg(func=lambda env: env.state[:, 0])},
    ],
)
def test_terms_that_cannot_be_concatenated_are_refused(env, terms):
    with pytest.raises(RuntimeError, match="group 'policy' cannot be concatenated"):
        manager_of(env, **terms)


def test_images_that_differ_off_the_concatenated_dimension_are_refused(env):
    with pytest.raises(RuntimeError, match="cannot be concatenated"):
        manager_of(
            env,
            concatenate_dim=0,
            a=ObservationTermCfg(func=image),
            b=ObservationTermCfg(func=image, params={"channels": 2}),
        )


def test_learning_the_shape_does_not_leave_a_trace_in_a_class_term(env):
    class Elapsed(ManagerTermBase):
        def __init__(self, cfg, env):
            super().__init__(cfg, env)
            self.time = torch.zeros(env.num_envs, 1)

        def reset(self, env_ids=None):
            self.time[slice(None) if env_ids is None else env_ids] = 0.0

        def __call__(self, env):
            self.time += 0.5
            return self.time

    manager = manager_of(env, t=ObservationTermCfg(func=Elapsed))
    assert manager.compute()["policy"].tolist() == [[0.5], [0.5]]
    manager.reset([1])
    assert manager.compute()["policy"].tolist() == [[1.0], [0.5]]


def test_groups_that_share_one_config_object_are_independent(env):
    shared = group(t=ObservationTermCfg(func=single, scale=(2.0,), history_length=2))
    manager = ObservationManager({"policy": shared, "critic": shared}, env)
    manager.compute_group("policy", update_history=True)
    env.state[:] = 7.0
    assert manager.compute_group("critic", update_history=True)[0].tolist() == [14.0, 14.0]
    assert shared.t.scale == (2.0,)


def test_wrong_configs_are_refused(env):
    with pytest.raises(ValueError, match="no observations"):
        ObservationManager(None, env)
    with pytest.raises(TypeError, match="'policy' must be of type ObservationGroupCfg"):
        ObservationManager({"policy": ObservationTermCfg(func=state)}, env)
    with pytest.raises(TypeError, match="'t' must be of type ObservationTermCfg"):
        manager_of(env, t=3)
    with pytest.raises(ValueError, match="no observation group 'polcy': did you mean 'policy'"):
        manager_of(env, t=ObservationTermCfg(func=state)).compute_group("polcy")


def test_viewers_and_tables_show_every_term(env):
    manager = manager_of(env, b=ObservationTermCfg(func=state), a=ObservationTermCfg(func=single))
    assert manager.get_active_iterable_terms(1) == [("policy-b", [3.0, 4.0]), ("policy-a", [3.0])]
    table = str(manager)
    assert "Group: 'policy' (shape: (3,))" in table
    cells = [cell.strip() for cell in table.split("|")]
    assert cells[cells.index("b") + 1] == "(2,)"
    assert manager.serialize()["policy"]["a"]["cfg"]["history_length"] == 0
