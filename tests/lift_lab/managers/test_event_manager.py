"""Events: modes, timers, step counts, and terms built before the simulation starts."""

from types import SimpleNamespace

import pytest
import torch

from lift_lab.managers import EventManager, EventTermCfg, ManagerTermBase, SceneEntityCfg


def note(env, env_ids, name="note"):
    """Append (name, env ids) to env.calls."""
    ids = env_ids.tolist() if isinstance(env_ids, torch.Tensor) else env_ids
    env.calls.append((name, ids))


def joints(env, env_ids, asset_cfg):
    env.calls.append(asset_cfg.joint_ids)


class Pusher(ManagerTermBase):
    def __init__(self, cfg, env):
        super().__init__(cfg, env)
        env.calls.append("built")

    def reset(self, env_ids=None):
        self._env.calls.append(("reset", env_ids))

    def __call__(self, env, env_ids):
        env.calls.append("pushed")


def event(mode, func=note, **fields):
    return EventTermCfg(func=func, mode=mode, **fields)


def interval(env, lower_s, upper_s, **fields):
    cfg = event("interval", interval_range_s=(lower_s, upper_s), **fields)
    return EventManager({"push": cfg}, env)


def test_terms_are_applied_by_mode_in_declaration_order(env):
    manager = EventManager(
        {
            "b": event("startup", params={"name": "b"}),
            "a": event("startup", params={"name": "a"}),
            "mine": event("my_mode", params={"name": "mine"}),
            "gone": None,
        },
        env,
    )
    assert manager.available_modes == ["startup", "my_mode"]
    assert manager.active_terms == {"startup": ["b", "a"], "my_mode": ["mine"]}
    manager.apply("startup")
    manager.apply("my_mode", env_ids=[1, 2])
    assert env.calls == [("b", None), ("a", None), ("mine", [1, 2])]


def test_a_mode_without_terms_is_only_warned_of(env, caplog):
    EventManager({"a": event("startup")}, env).apply("startpu")
    assert "did you mean 'startup'" in caplog.text


def test_a_reset_term_gets_the_environments_that_reset(env):
    manager = EventManager({"a": event("reset")}, env)
    manager.apply("reset", env_ids=torch.tensor([1, 3]), global_env_step_count=0)
    manager.apply("reset", global_env_step_count=0)
    assert env.calls == [("note", [1, 3]), ("note", slice(None))]


def test_a_reset_term_waits_for_its_step_count_in_each_environment(env):
    manager = EventManager({"a": event("reset", min_step_count_between_reset=10)}, env)

    def fires(step, env_ids):
        env.calls.clear()
        manager.apply("reset", env_ids=env_ids, global_env_step_count=step)
        return env.calls[0][1] if env.calls else []

    assert fires(0, torch.tensor([0, 1])) == [0, 1]  # never fired before
    assert fires(5, torch.tensor([0, 1, 2])) == [2]  # 5 steps are too few for 0 and 1
    assert fires(9, torch.tensor([0, 1])) == []
    assert fires(10, torch.tensor([0, 1, 2])) == [0, 1]  # 10 steps have passed; 2 fired at step 5
    assert fires(15, None) == [2, 3]
    assert fires(20, [0, 1, 2, 3]) == [0, 1]


def test_a_local_interval_fires_in_each_environment_by_its_own_timer(env):
    manager = interval(env, 1.0, 1.0)
    manager.reset([0, 1])  # the others' timers started at 1 s too
    fired = []
    for step in range(10):
        if step == 4:
            manager.reset([3])  # environment 3 starts over: due at step 4 + 5
        env.calls.clear()
        manager.apply("interval", dt=0.2)
        fired.append(env.calls[0][1] if env.calls else [])
    assert fired == [[], [], [], [], [0, 1, 2], [], [], [], [3], [0, 1, 2]]


def test_an_interval_begins_at_the_step_that_fires_not_when_it_was_due(env):
    manager = interval(env, 1.0, 1.0)
    fired = []
    for step in range(1, 10):
        env.calls.clear()
        manager.apply("interval", dt=0.4)
        fired += [step] if env.calls else []
    assert fired == [3, 6, 9]


@pytest.mark.parametrize("is_prefetched", [False, True])
@pytest.mark.parametrize(
    ("interval_s", "applied"),
    [
        (1.0, [0, 2]),
        (0.2, [0, 2, 3]),  # the timer of environment 3 runs for one step, the one after its reset
        (0.1, [0, 2, 3]),
    ],
)
def test_what_is_prefetched_is_what_would_be_applied(env, prefetch, is_prefetched, interval_s, applied):
    manager = interval(env, interval_s, interval_s)
    manager._interval_term_time_left[0][:] = torch.tensor([0.1, 0.3, 0.2, 0.1])
    if is_prefetched:
        prefetch(manager, 0.2, ended=torch.tensor([False, False, False, True]))
    manager.reset(torch.tensor([3]))
    manager.apply("interval", dt=0.2)
    assert env.calls == [("note", applied)]
    manager._interval_term_time_left[0][:] = torch.tensor([1.0, 0.1, 1.0, 1.0])
    manager.apply("interval", dt=0.2)  # what was prefetched held for one step
    assert env.calls[1:] == [("note", [1])]


def test_an_interval_is_drawn_from_its_range_at_the_start_and_at_resets(env_factory):
    manager = interval(env_factory(num_envs=2000), 2.0, 4.0)
    for _ in range(2):
        (time_left,) = manager._interval_term_time_left
        assert time_left.min() >= 2.0
        assert time_left.max() <= 4.0
        assert time_left.mean().item() == pytest.approx(3.0, abs=0.05)
        time_left.zero_()
        manager.reset()


def test_a_global_interval_has_one_timer_that_resets_leave_alone(env):
    manager = interval(env, 1.0, 1.0, is_global_time=True)
    fired = []
    for _ in range(10):
        env.calls.clear()
        manager.reset([0])
        manager.apply("interval", dt=0.25)
        fired.append(list(env.calls))
    assert [bool(calls) for calls in fired] == [False, False, False, True] * 2 + [False, False]
    assert fired[3] == [("note", None)]


def test_repeated_subtraction_does_not_delay_an_interval(env):
    manager = interval(env, 1.0, 1.0)
    for _ in range(10):
        manager.apply("interval", dt=0.1)
    assert len(env.calls) == 1


def test_modes_need_their_arguments(env):
    manager = EventManager({"a": event("reset"), "b": event("interval", interval_range_s=(1.0, 1.0))}, env)
    with pytest.raises(ValueError, match="global_env_step_count"):
        manager.apply("reset")
    with pytest.raises(ValueError, match="dt"):
        manager.apply("interval")
    with pytest.raises(ValueError, match="env_ids"):
        manager.apply("interval", env_ids=[0], dt=0.1)


def test_wrong_fields_are_refused_with_the_terms_name(env):
    with pytest.raises(ValueError, match=r"term 'a'.*interval_range_s"):
        EventManager({"a": event("interval")}, env)
    with pytest.raises(ValueError, match=r"term 'a'.*\(2.0, 1.0\) is no range of seconds"):
        EventManager({"a": event("interval", interval_range_s=(2.0, 1.0))}, env)
    with pytest.raises(ValueError, match=r"term 'a'.*min_step_count_between_reset"):
        EventManager({"a": event("reset", min_step_count_between_reset=-1)}, env)
    with pytest.raises(ValueError, match=r"term 'a'.*mode"):
        EventManager({"a": EventTermCfg(func=note)}, env)
    with pytest.raises(ValueError, match=r"term 'a'.*\(env, env_ids\)"):
        EventManager({"a": event("reset", func=lambda env: None)}, env)


def test_class_terms_of_every_mode_are_reset(env):
    EventManager({"a": event("reset", func=Pusher), "b": event("startup", func=Pusher)}, env).reset([2])
    assert env.calls == ["built", "built", ("reset", [2]), ("reset", [2])]


def test_before_the_simulation_starts_only_prestartup_terms_are_built(env_factory):
    env = env_factory(sim=SimpleNamespace(is_started=False), scene=None)
    entity = SceneEntityCfg("robot", joint_names=["finger"])
    manager = EventManager(
        {
            "early": event("prestartup", func=Pusher),
            "late": event("startup", func=Pusher),
            "joints": event("startup", func=joints, params={"asset_cfg": entity}),
        },
        env,
    )
    manager.apply("prestartup")
    assert env.calls == ["built", "pushed"]
    env.scene, env.sim.is_started = env_factory().scene, True
    manager.apply("startup")
    assert env.calls == ["built", "pushed", "built", "pushed", [2]]
    env.calls.clear()
    manager.apply("startup")
    assert env.calls == ["pushed", [2]]


def test_resolving_the_terms_reports_mistakes_before_a_mode_is_applied(env_factory):
    env = env_factory(sim=SimpleNamespace(is_started=False))
    entity = SceneEntityCfg("robot", joint_names=["fingr"])
    manager = EventManager({"joints": event("reset", func=joints, params={"asset_cfg": entity})}, env)
    env.sim.is_started = True
    with pytest.raises(ValueError, match=r"'joints', param 'asset_cfg'.*fingr"):
        manager.resolve_terms()


def test_wrong_parameters_are_reported_before_the_simulation_starts(env_factory):
    env = env_factory(sim=SimpleNamespace(is_started=False), scene=None)
    with pytest.raises(ValueError, match="unexpected 'nme' \\(did you mean 'name'"):
        EventManager({"a": event("reset", params={"nme": "x"})}, env)


def test_a_terms_config_can_be_read_edited_and_replaced(env):
    manager = EventManager({"a": event("reset"), "b": event("startup")}, env)
    manager.get_term_cfg("a").params["name"] = "edited"
    manager.apply("reset", global_env_step_count=0)
    manager.set_term_cfg("a", event("reset", func=Pusher))
    manager.apply("reset", global_env_step_count=0)
    assert env.calls == [("edited", slice(None)), "built", "pushed"]
    with pytest.raises(ValueError, match="mode"):
        manager.set_term_cfg("a", event("startup"))
    with pytest.raises(ValueError, match="'c' not found: choose one of"):
        manager.get_term_cfg("c")


def test_the_tables_list_every_mode(env):
    manager = EventManager({"a": event("reset"), "b": event("interval", interval_range_s=(1.0, 2.0))}, env)
    assert "2 active terms" in str(manager)
    assert "Mode: 'interval'" in str(manager)
    assert "(1.0, 2.0)" in str(manager)
    assert "0 active terms" in str(EventManager(None, env))
