"""The curves of the last seconds."""

import math

import numpy as np
import torch


def curves(session):
    """Label -> values, oldest first, as the page has them."""
    session._show_figures()
    chart = session._plot.chart
    return {series["label"]: values for series, values in zip(chart.series, chart.data, strict=True)}


def test_actions_are_plotted_from_the_moment_when_they_are_chosen(env, session):
    values = torch.linspace(-1, 1, 6)
    given = iter(values)
    session._policy.act = lambda obs: next(given).expand(3, 8)
    session.run(2)
    session._post("plot", "actions")
    session.run(6)
    found = curves(session)
    dt = env.unwrapped.step_dt
    assert len(found) == 9
    for label in ("arm_action[0]", "arm_action[6]", "gripper_action"):
        np.testing.assert_allclose(found[label], values[2:], atol=1e-6)
    np.testing.assert_allclose(np.diff(found["time, s"]), dt, atol=1e-9)


def test_one_reward_term_of_the_selected_environment(env, session):
    inner = env.unwrapped
    session._post("plot_term", "reaching_object")
    session._post("env", 2)
    seen = []
    step = session._step

    def step_and_note(obs):
        obs = step(obs)
        hand, cube = inner.scene["ee_frame"].data.target_pos_w[2, 0], inner.scene["object"].data.root_pos_w[2]
        seen.append(1.0 - math.tanh(float((hand - cube).norm()) / 0.1))
        return obs

    session._step = step_and_note
    session.run(5)
    found = curves(session)
    assert list(found) == ["time, s", "reaching_object"]
    weight = inner.reward_manager.get_term_cfg("reaching_object").weight
    np.testing.assert_allclose(found["reaching_object"], np.array(seen) * weight, rtol=1e-4)


def test_the_last_ten_seconds_stay(env, session):
    session._plot.choose("actions", "gripper_action")
    inner = env.unwrapped
    for i in range(inner.max_episode_length * 3):
        inner.action_manager._action[0, 7] = i
        session._plot.record()
    found = curves(session)["gripper_action"]
    length = round(10.0 / inner.step_dt)
    np.testing.assert_array_equal(found, np.arange(inner.max_episode_length * 3)[-length:])


def test_a_metric_that_has_no_value_yet_leaves_a_gap(env, session):
    session.run(1)
    session._post("plot", "metrics")
    session.run(2)
    assert "all" not in session._panel.plot_term.options  # metrics have many units
    values = iter([float("nan"), 2.0, float("nan"), 4.0])
    session._plot._sources["metrics"] = lambda env_id: [(session._plot.term, [next(values)])]
    for _ in range(4):
        session._plot.record()
    found = list(curves(session).values())
    np.testing.assert_array_equal(found[1][-2:], [2.0, 4.0])
    assert np.isfinite(found).all()


def test_curves_of_another_environment_begin_anew(session):
    session.run(3)
    assert len(curves(session)["time, s"]) == 3
    session._post("env", 1)
    session._answer()
    assert not session._plot.chart.visible
    session.run(6)
    assert len(curves(session)["time, s"]) == 3
    assert session._plot.chart.visible


def test_off_costs_no_look_at_the_task(session):
    session._post("plot", "off")
    session.run(1)
    session._plot._sources = {}  # whoever asked one would fail
    session.run(3)
    assert session._plot.chart is None
    assert session._panel.plot_group.value == "off"


def test_observations_are_plotted_term_by_term(session):
    session.run(1)
    session._post("plot", "observations")
    session.run(4)
    assert "all" not in session._panel.plot_term.options
    first = session._panel.plot_term.options[0]
    assert list(curves(session))[1].startswith(first)
