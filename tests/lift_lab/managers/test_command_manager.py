"""Commands: timers, resampling, metrics."""

import pytest
import torch

from lift_lab.managers import CommandManager, CommandTerm, CommandTermCfg


class Numbered(CommandTerm):
    """The command is the number of draws so far; every stage is noted in env.calls."""

    def __init__(self, cfg, env):
        super().__init__(cfg, env)
        self.draws = 0
        self._command = torch.zeros(self.num_envs, 1)
        self.metrics["age"] = torch.zeros(self.num_envs)

    @property
    def command(self):
        return self._command

    def _update_metrics(self):
        self._env.calls.append("metrics")
        self.metrics["age"] += 1.0

    def _resample_command(self, env_ids):
        self._env.calls.append(env_ids.tolist())
        self.draws += 1
        self._command[env_ids] = self.draws

    def _update_command(self):
        self._env.calls.append("update")


def manager_of(env, lower_s, upper_s):
    cfg = CommandTermCfg(class_type=Numbered, resampling_time_range=(lower_s, upper_s))
    return CommandManager({"pose": cfg}, env)


def test_a_step_updates_metrics_then_timers_then_draws_then_commands(env):
    manager = manager_of(env, 1.0, 1.0)
    manager.compute(dt=0.4)  # every timer starts at zero, so all are due at once
    assert env.calls == ["metrics", [0, 1, 2, 3], "update"]
    assert torch.allclose(manager.get_term("pose").time_left, torch.ones(4))


def test_a_command_is_held_until_its_time_is_up(env):
    manager = manager_of(env, 1.0, 1.0)
    manager.reset()
    held = []
    for _ in range(6):
        manager.compute(dt=0.5)  # due at exactly zero: in the second, fourth and sixth step
        held.append(manager.get_command("pose")[0].item())
    assert held == [1.0, 2.0, 2.0, 3.0, 3.0, 4.0]
    assert manager.get_term("pose").command_counter.tolist() == [4] * 4


def test_only_environments_that_are_due_draw(env):
    manager = manager_of(env, 1.0, 1.0)
    manager.reset()
    manager.get_term("pose").time_left[:] = torch.tensor([0.1, 5.0, 0.1, 5.0])
    env.calls.clear()
    manager.compute(dt=0.2)
    assert env.calls == ["metrics", [0, 2], "update"]


def test_timers_are_drawn_from_the_range(env_factory):
    env = env_factory(num_envs=2000)
    manager = manager_of(env, 2.0, 6.0)
    manager.reset()
    time_left = manager.get_term("pose").time_left
    assert time_left.min() >= 2.0
    assert time_left.max() <= 6.0
    assert time_left.mean().item() == pytest.approx(4.0, abs=0.1)


def test_a_reset_logs_the_mean_of_each_metric_and_zeroes_it(env):
    manager = manager_of(env, 9.0, 9.0)
    for _ in range(3):
        manager.compute(dt=0.1)
    manager.get_term("pose").metrics["age"][1] = 7.0
    log = manager.reset([0, 1])
    assert list(log) == ["Metrics/pose/age"]
    assert log["Metrics/pose/age"].item() == pytest.approx(5.0)  # mean of 3 and 7
    assert log["Metrics/pose/age"].shape == ()
    assert manager.get_term("pose").metrics["age"].tolist() == [0.0, 0.0, 3.0, 3.0]


def test_a_reset_draws_anew_and_restarts_the_counter_of_its_environments(env):
    manager = manager_of(env, 1.0, 1.0)
    manager.reset()
    manager.compute(dt=1.0)
    manager.reset(torch.tensor([3]))
    assert manager.get_command("pose").flatten().tolist() == [2.0, 2.0, 2.0, 3.0]
    assert manager.get_term("pose").command_counter.tolist() == [2, 2, 2, 1]
    env.calls.clear()
    manager.reset(slice(None))
    assert env.calls == [[0, 1, 2, 3]]


@pytest.mark.parametrize("is_prefetched", [False, True])
@pytest.mark.parametrize(
    ("interval_s", "drawn"),
    [
        (1.0, [0, 2]),
        (0.2, [0, 2, 3]),  # the timer of environment 3 runs for one step, the one after its reset
        (0.1, [0, 2, 3]),
    ],
)
def test_what_is_prefetched_is_what_would_be_drawn(env, prefetch, is_prefetched, interval_s, drawn):
    manager = manager_of(env, interval_s, interval_s)
    manager.reset()
    manager.get_term("pose").time_left[:] = torch.tensor([0.1, 0.3, 0.2, 0.1])
    env.calls.clear()
    if is_prefetched:
        prefetch(manager, 0.2, ended=torch.tensor([False, False, False, True]))
    manager.reset(torch.tensor([3]))
    manager.compute(dt=0.2)
    assert env.calls == [[3], "metrics", drawn, "update"]
    manager.get_term("pose").time_left[:] = torch.tensor([1.0, 0.1, 1.0, 1.0])
    manager.compute(dt=0.2)  # what was prefetched held for one step
    assert env.calls[-3:] == ["metrics", [1], "update"]


def test_without_terms_there_is_nothing_to_do(env):
    manager = CommandManager(None, env)
    manager.compute(0.1)
    assert manager.reset() == {}
    assert manager.active_terms == []


def test_an_unknown_command_is_reported_with_the_closest_name(env):
    cfg = CommandTermCfg(class_type=Numbered, resampling_time_range=(1.0, 1.0))
    manager = CommandManager({"object_pose": cfg}, env)
    with pytest.raises(KeyError, match="'object_pos' not found: did you mean"):
        manager.get_command("object_pos")


def test_viewers_and_tables_show_every_term(env):
    manager = manager_of(env, 1.0, 1.0)
    manager.reset()
    assert manager.get_active_iterable_terms(0) == [("pose", [1.0])]
    assert "Numbered" in str(manager)


class _OwnTimers(Numbered):
    """A class of one's own whose timers run twice as fast."""

    def compute(self, dt):
        self.time_left -= dt
        super().compute(dt)


def test_nothing_is_said_in_advance_of_a_class_that_changes_its_timers(env):
    cfg = CommandTermCfg(class_type=_OwnTimers, resampling_time_range=(1.0, 1.0))
    assert CommandManager({"pose": cfg}, env).masks(0.2, torch.zeros(4, dtype=torch.bool)) == {}


class _Replaced(Numbered):
    """A metric that is a new tensor at every step, as many in Isaac Lab are, and one that comes later."""

    def _update_metrics(self):
        self.metrics["age"] = torch.full((4,), 5.0)
        self.metrics.setdefault("late", torch.zeros(4)).add_(7.0)


def test_metrics_of_a_class_of_ones_own_may_be_replaced_and_added(env):
    manager = CommandManager({"pose": CommandTermCfg(class_type=_Replaced, resampling_time_range=(9.0, 9.0))}, env)
    manager.compute(dt=0.1)
    log = manager.reset(torch.tensor([0, 2]))
    assert {name: float(value) for name, value in log.items()} == {"Metrics/pose/age": 5.0, "Metrics/pose/late": 7.0}
    assert manager.get_term("pose").metrics["late"].tolist() == [0.0, 7.0, 0.0, 7.0]
    assert manager.reset(torch.tensor([], dtype=torch.long)) == {}


def test_a_command_needs_no_metrics(env):
    class Still(CommandTerm):
        command = torch.zeros(4, 1)

        def _resample_command(self, env_ids):
            pass

        def _update_command(self):
            pass

    manager = CommandManager({"pose": CommandTermCfg(class_type=Still, resampling_time_range=(1.0, 1.0))}, env)
    manager.compute(0.1)
    assert manager.reset() == {}
