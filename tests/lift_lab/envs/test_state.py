"""What the state of an environment is made of, and what terms have changed in configurations."""

from __future__ import annotations

from typing import Any

import pytest
import torch

from lift_lab.envs.state import ChangedSettings
from lift_lab.managers import ManagerTermBase, RewardTermCfg
from lift_lab.utils import configclass
from lift_lab.utils.errors import StateMismatchError


@configclass
class Inner:
    """A part of a configuration."""

    span: tuple[float, float] = (0.0, 1.0)
    names: list[str] = ["a", "b"]


@configclass
class Cfg:
    """A configuration as terms change it."""

    weight: float = 1.0
    inner: Inner = Inner()
    params: dict[str, Any] = {"std": 0.5, "table": torch.zeros(2)}
    limit: float | None = None


def changed(cfg: Cfg) -> ChangedSettings:
    return ChangedSettings(lambda: {"reward_manager": cfg})


def test_only_settings_that_have_changed_are_in_the_state():
    cfg = Cfg()
    settings = changed(cfg)
    assert settings.state_dict() == {}
    cfg.weight, cfg.inner.span, cfg.inner.names[1], cfg.limit, cfg.params["more"] = 2.0, (0.0, 2.0), "c", 3.0, 1
    cfg.params["table"][1] = 7.0
    state = settings.state_dict()
    assert state.pop(("reward_manager", "params", "table")).tolist() == [0.0, 7.0]
    assert state == {
        ("reward_manager", "weight"): 2.0,
        ("reward_manager", "inner", "span"): (0.0, 2.0),
        ("reward_manager", "inner", "names"): ["a", "c"],
        ("reward_manager", "limit"): 3.0,
        ("reward_manager", "params", "more"): 1,
    }


def test_a_function_that_was_replaced_is_reported():
    cfg = Cfg()
    cfg.params |= {"kernel": torch.exp, "same": torch.tanh, "list": [None]}
    settings = changed(cfg)
    assert settings.unsaved() == []
    cfg.params["kernel"], cfg.params["list"][0] = torch.square, torch.sin
    kind = type(torch.square).__name__
    expected = [f"reward_manager.params.kernel ({kind})", f"reward_manager.params.list.0 ({kind})"]
    assert sorted(settings.unsaved()) == expected


@pytest.mark.parametrize(
    "change",
    [
        lambda cfg: cfg.inner.names.append("c"),
        lambda cfg: cfg.inner.names.pop(),
        lambda cfg: cfg.params.update({"gains": {"joint.*": 2.0, 3: 1.0}}),
        lambda cfg: cfg.params["plain"].pop("a.b"),
        lambda cfg: cfg.params["plain"].update({2: 5.0}),
        lambda cfg: setattr(cfg, "limit", [1.0, {"a": None}]),
        lambda cfg: setattr(cfg.inner, "span", [3.0]),
    ],
    ids=[
        "list grows",
        "list shrinks",
        "pattern as a key",
        "key goes",
        "number as a key",
        "other type",
        "tuple to list",
    ],
)
def test_what_a_term_does_to_a_container_comes_back(change):
    source, other = Cfg(), Cfg()
    for cfg in (source, other):
        cfg.params["plain"] = {"a.b": 1.0, "c": 2.0}
    settings, others = changed(source), changed(other)
    change(source)
    state = settings.state_dict()
    assert len(state) == 1
    names = other.inner.names
    for target, cfg in ((others, other), (settings, source)):  # another environment, and the same one
        target.check_state_dict(state)
        target.load_state_dict(state)
        assert repr(cfg) == repr(source)
    assert other.inner.names is names  # who holds the list sees the change
    others.load_state_dict({})
    assert others.state_dict() == {}


def test_a_part_that_was_taken_out_is_refused_where_it_cannot_come_back():
    cfg, other = Cfg(), Cfg()
    settings, others = changed(cfg), changed(other)
    before = settings.state_dict()
    cfg.inner = None
    state = settings.state_dict()
    assert state == {("reward_manager", "inner"): None}
    others.check_state_dict(state)
    others.load_state_dict(state)
    assert other.inner is None
    with pytest.raises(StateMismatchError, match=r"'reward_manager\.inner\.span', which is not there"):
        settings.check_state_dict(before)


def test_changed_settings_come_back_and_all_others_are_as_configured():
    source, other = Cfg(), Cfg()
    settings, others = changed(source), changed(other)
    source.weight, source.params["more"], source.params["table"][0] = 2.0, 1, 5.0
    state = settings.state_dict()
    table = other.params["table"]
    other.weight, other.inner.span, other.params["else"] = 9.0, (1.0, 1.0), 3
    for _ in range(2):
        others.check_state_dict(state)
        others.load_state_dict(state)
        assert (other.weight, other.inner.span, other.limit) == (2.0, (0.0, 1.0), None)
        assert other.params.keys() == {"std", "table", "more"}
        assert other.params["table"] is table
        assert table.tolist() == [5.0, 0.0]
    others.load_state_dict({})
    assert others.state_dict() == {}
    assert (other.weight, other.params.keys(), table.tolist()) == (1.0, {"std", "table"}, [0.0, 0.0])


def test_a_changed_setting_that_is_not_there_is_named():
    with pytest.raises(StateMismatchError, match=r"has changed the setting 'reward_manager\.other\.x', which is not"):
        changed(Cfg()).check_state_dict({("reward_manager", "other", "x"): 1.0})
    with pytest.raises(StateMismatchError, match="it has no settings"):
        changed(Cfg()).check_state_dict(None)


class Custom(ManagerTermBase):
    """A reward that saves itself, in its own form."""

    def __init__(self, cfg, env):
        super().__init__(cfg, env)
        self.level, self.window = 0.0, iter("abc")

    def __call__(self, env):
        self.level += 1.0
        return torch.full((env.num_envs,), self.level, device=env.device)

    def state_dict(self):
        return {"level": self.level}

    def load_state_dict(self, state):
        self.level = state["level"]


class Plain(ManagerTermBase):
    """A reward that knows nothing of saved states; its buffers have the names of the framework's own."""

    def __init__(self, cfg, env):
        super().__init__(cfg, env)
        self._cache, self._kept = {}, torch.zeros(env.num_envs, device=env.device)
        self.generator = torch.Generator().manual_seed(3)

    def __call__(self, env):
        self._kept += torch.rand(env.num_envs, generator=self.generator).to(env.device)
        self._cache["last"] = env.episode_length_buf.float() + self._kept
        return self._cache["last"]


@pytest.mark.parametrize("physics", ["native", pytest.param("warp", marks=pytest.mark.slow)])
def test_terms_are_saved_by_their_names(make_env, physics):
    def rewards(cls):
        return {"custom": RewardTermCfg(func=Custom, weight=1.0), "plain": RewardTermCfg(func=cls, weight=0.5)}

    env = make_env(physics=physics, rewards=rewards(Plain))
    env.reset()
    action = torch.zeros(env.num_envs, env.action_manager.total_action_dim)
    for _ in range(3):
        env.step(action)
    env.reward_manager.get_term_cfg("plain").weight = 0.25
    state = env.state_dict()
    assert state["unsaved"] == []
    assert state["settings"] == {("reward_manager", "plain", "weight"): 0.25}
    assert state["objects"]["reward_manager/custom"] == ("own", "Custom", ("dict", "dict", [("level", 3.0)]))
    assert set(state["objects"]["reward_manager/plain"][3]) == {"_cache", "_kept", "generator"}
    expected = [env.step(action)[1].clone() for _ in range(3)]
    env.load_state_dict(state)
    found = [env.step(action)[1].clone() for _ in range(3)]
    assert all(torch.equal(a, b) for a, b in zip(expected, found, strict=True))
    other = make_env(physics=physics, rewards=rewards(Custom))
    with pytest.raises(StateMismatchError, match="'reward_manager/plain' is Custom, it was Plain"):
        other.load_state_dict(state)


def test_a_manager_and_a_term_give_their_own_state(make_env):
    env = make_env(rewards={"plain": RewardTermCfg(func=Plain, weight=0.5)})
    env.reset()
    action = torch.ones(env.num_envs, env.action_manager.total_action_dim)
    env.step(action)
    term = env.reward_manager.term_objects()["plain"]
    of_term, of_manager = term.state_dict(), env.action_manager.state_dict()
    env.step(2.0 * action)
    term.load_state_dict(of_term)
    env.action_manager.load_state_dict(of_manager)
    assert torch.equal(term._kept, of_term["_kept"])
    assert torch.equal(env.action_manager.action, action)
