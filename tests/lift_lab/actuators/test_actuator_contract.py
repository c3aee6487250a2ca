"""What Isaac Lab 2.3.2's actuator classes promise to those who make or derive them: values of config and file, limits.

Its own tests of ``ideal_pd``, ``implicit`` and ``dc_motor`` are the measure; those are written out here anew.
"""

from __future__ import annotations

import itertools

import pytest
import torch

from lift_lab.actuators import DCMotorCfg, IdealPDActuator, IdealPDActuatorCfg, ImplicitActuator, ImplicitActuatorCfg
from lift_lab.utils.errors import ConfigError
from lift_lab.utils.types import ArticulationActions

_OF_FILE = {"stiffness": 300, "damping": 20, "armature": 0.01, "friction": 0.02, "viscous_friction": 0.03}
_OF_CFG = {"stiffness": 200, "damping": 10, "armature": 0.2, "friction": 0.1, "viscous_friction": 0.4}


def _make(cfg, num_envs=2, num_joints=2, **of_file):
    """An actuator made directly, as Isaac Lab's tests make it: joint ids are a list, defaults are numbers."""
    return cfg.class_type(
        cfg,
        joint_names=[f"joint_{i}" for i in range(num_joints)],
        joint_ids=list(range(num_joints)),
        num_envs=num_envs,
        device="cpu",
        **of_file,
    )


def _assert_all(tensor, value, num_envs=2, num_joints=2):
    torch.testing.assert_close(tensor, torch.full((num_envs, num_joints), float(value)))


@pytest.mark.parametrize("kind", [IdealPDActuatorCfg, ImplicitActuatorCfg])
@pytest.mark.parametrize(("num_envs", "num_joints"), [(1, 1), (2, 3)])
@pytest.mark.parametrize("from_file", [False, True])
def test_values_are_the_configs_and_else_the_files(kind, num_envs, num_joints, from_file):
    given = dict.fromkeys(_OF_CFG) if from_file else _OF_CFG
    actuator = _make(kind(joint_names_expr=[".*"], **given), num_envs, num_joints, **_OF_FILE)
    assert actuator.is_implicit_model is (kind is ImplicitActuatorCfg)
    for name, value in (_OF_FILE if from_file else _OF_CFG).items():
        _assert_all(getattr(actuator, name), value, num_envs, num_joints)
    for name in ("computed_effort", "applied_effort", "dynamic_friction"):
        _assert_all(getattr(actuator, name), 0.0, num_envs, num_joints)
    no_limit = float("inf")
    for name in ("effort_limit", "velocity_limit", "velocity_limit_sim"):
        _assert_all(getattr(actuator, name), no_limit, num_envs, num_joints)
    in_engine = no_limit if actuator.is_implicit_model else actuator._DEFAULT_MAX_EFFORT_SIM
    _assert_all(actuator.effort_limit_sim, in_engine, num_envs, num_joints)


@pytest.mark.parametrize(
    ("limit", "limit_sim", "expected", "expected_sim"),
    [(None, None, 5000, 1e9), (300, None, 300, 1e9), (None, 400, 5000, 400), (300, 400, 300, 400)],
)
def test_effort_limits_of_an_explicit_model_are_two(limit, limit_sim, expected, expected_sim):
    cfg = IdealPDActuatorCfg(
        joint_names_expr=[".*"], stiffness=200, damping=10, effort_limit=limit, effort_limit_sim=limit_sim
    )
    actuator = _make(cfg, effort_limit=5000)
    _assert_all(actuator.effort_limit, expected)
    _assert_all(actuator.effort_limit_sim, expected_sim)


@pytest.mark.parametrize(
    ("limit", "limit_sim", "expected", "expected_sim"),
    [(None, None, 1000, 1000), (300, None, 300, 1000), (None, 400, 400, 400), (300, 400, 300, 400)],
)
def test_velocity_limits_of_an_explicit_model_are_two(limit, limit_sim, expected, expected_sim):
    cfg = IdealPDActuatorCfg(
        joint_names_expr=[".*"], stiffness=200, damping=10, velocity_limit=limit, velocity_limit_sim=limit_sim
    )
    actuator = _make(cfg, velocity_limit=1000)
    _assert_all(actuator.velocity_limit, expected)
    _assert_all(actuator.velocity_limit_sim, expected_sim)


@pytest.mark.parametrize("kind", ["effort", "velocity"])
@pytest.mark.parametrize(("limit", "limit_sim"), list(itertools.product((None, 300, 200), (None, 400, 200))))
def test_limits_of_an_implicit_model_are_one(kind, limit, limit_sim):
    cfg = ImplicitActuatorCfg(joint_names_expr=[".*"], stiffness=200, damping=10)
    setattr(cfg, f"{kind}_limit", limit)
    setattr(cfg, f"{kind}_limit_sim", limit_sim)
    if limit and limit_sim and limit != limit_sim:
        with pytest.raises(ConfigError, match=rf"{kind}_limit {limit} and {kind}_limit_sim {limit_sim} differ"):
            _make(cfg, **{f"{kind}_limit": 5000})
        return
    actuator = _make(cfg, **{f"{kind}_limit": 5000})
    # a velocity limit without _sim does not count, as in Isaac Lab
    merged = limit_sim if kind == "velocity" else limit_sim or limit
    assert getattr(cfg, f"{kind}_limit") == getattr(cfg, f"{kind}_limit_sim") == merged
    for name in (f"{kind}_limit", f"{kind}_limit_sim"):
        _assert_all(getattr(actuator, name), merged or 5000)


@pytest.mark.parametrize("limit", [None, 300.0])
def test_an_ideal_pd_actuator_turns_the_action_that_it_is_given_into_efforts(limit):
    cfg = IdealPDActuatorCfg(joint_names_expr=[".*"], stiffness=200, damping=10, effort_limit=limit)
    actuator = _make(cfg)
    action = ArticulationActions(*(torch.full((2, 2), x) for x in (10.0, 0.1, 1.0)))
    result = actuator.compute(action, torch.full((2, 2), 1.0), torch.full((2, 2), -0.1))
    asked = 200 * (10.0 - 1.0) + 10 * (0.1 + 0.1) + 1.0
    _assert_all(actuator.computed_effort, asked)
    _assert_all(actuator.applied_effort, asked if limit is None else limit)
    assert result is action  # a sub-class may return the action instead of super().compute(action, ...)
    torch.testing.assert_close(action.joint_efforts, actuator.applied_effort)
    assert action.joint_positions is None
    assert action.joint_velocities is None


def test_an_implicit_actuator_notes_its_effort_and_hands_on_the_targets():
    actuator = _make(ImplicitActuatorCfg(joint_names_expr=[".*"], stiffness=50, damping=2, effort_limit_sim=7.0))
    targets = [torch.full((2, 2), x) for x in (0.3, 0.5, 0.25)]
    action = ArticulationActions(*targets)
    assert actuator.compute(action, torch.zeros(2, 2), torch.zeros(2, 2)) is action
    assert action.joint_positions is targets[0]
    assert action.joint_efforts is targets[2]
    _assert_all(actuator.computed_effort, 50 * 0.3 + 2 * 0.5 + 0.25)
    _assert_all(actuator.applied_effort, 7.0)


@pytest.mark.parametrize("speed", [-110.0, -90.0, -70.0, -50.0, -40.0, -10.0, 0.0, 10.0, 40.0, 50.0, 70.0, 90.0, 110.0])
@pytest.mark.parametrize("effort", [-120.0, -70.0, -30.0, -10.0, 20.0, 80.0, 120.0])
def test_a_dc_motor_clips_in_all_four_quadrants(speed, effort):
    limit, stall, no_load = 60.0, 100.0, 50.0
    cfg = DCMotorCfg(
        joint_names_expr=[".*"],
        stiffness=200,
        damping=10,
        effort_limit=limit,
        velocity_limit=no_load,
        saturation_effort=stall,
    )
    actuator = _make(cfg)
    actuator._joint_vel[:] = speed
    clipped = actuator._clip_effort(torch.full((2, 2), effort))
    # beyond the speeds at which the line meets the effort limit, that limit
    corner = no_load * (1 + limit / stall)
    ratio = max(-corner, min(corner, speed)) / no_load
    low, high = max(stall * (-1 - ratio), -limit), min(stall * (1 - ratio), limit)
    _assert_all(clipped, min(max(effort, low), high))


@pytest.mark.parametrize(
    ("missing", "name"), [("saturation_effort", "saturation"), ("velocity_limit", "no-load speed")]
)
def test_a_dc_motor_needs_its_line(missing, name):
    values = {"saturation_effort": 10.0, "velocity_limit": 5.0} | {missing: None}
    with pytest.raises(ConfigError, match=name):
        _make(DCMotorCfg(joint_names_expr=[".*"], stiffness=1, damping=1, **values))


# -- parameters of one's own


@pytest.fixture
def actuator():
    return _make(IdealPDActuatorCfg(joint_names_expr=[".*"], stiffness=1, damping=1), num_joints=3)


def test_a_parameter_is_a_number_or_numbers_by_pattern_over_a_default(actuator):
    parse = actuator._parse_joint_parameter
    torch.testing.assert_close(parse(4, None), torch.full((2, 3), 4.0))
    torch.testing.assert_close(parse(None, 5), torch.full((2, 3), 5.0))
    default = torch.arange(6, dtype=torch.float32).view(2, 3)
    torch.testing.assert_close(parse(None, default), default)
    assert parse(None, default).data_ptr() != default.data_ptr()
    by_name = parse({"joint_[01]": 7, "joint_2": 8.5}, None)
    torch.testing.assert_close(by_name, torch.tensor([[7.0, 7.0, 8.5]] * 2))
    # joints that no pattern names keep the default, or are zero where there is none
    torch.testing.assert_close(parse({"joint_1": 7}, default)[:, [0, 2]], default[:, [0, 2]])
    torch.testing.assert_close(parse({"joint_1": 7}, None), torch.tensor([[0.0, 7.0, 0.0]] * 2))


@pytest.mark.parametrize(
    ("arguments", "error", "message"),
    [
        ((None, None), ConfigError, "has no default"),
        (("5", None), TypeError, "must be a number or a dict, got '5'"),
        ((None, "5"), TypeError, "must be a number or a tensor, got '5'"),
        ((None, torch.zeros(3)), ConfigError, r"has shape \(3,\), expected \(2, 3\)"),
        (({"elbow": 1.0}, None), ConfigError, "elbow"),
    ],
)
def test_a_parameter_that_cannot_be_parsed_is_refused(actuator, arguments, error, message):
    with pytest.raises(error, match=message):
        actuator._parse_joint_parameter(*arguments)


def test_the_resolution_table_holds_what_the_config_leaves_or_changes():
    cfg = ImplicitActuatorCfg(joint_names_expr=[".*"], stiffness={"joint_0": 9.0}, damping=20.0)
    table = _make(cfg, **_OF_FILE).joint_property_resolution_table
    assert table["stiffness"] == [["joint_0", 0, 300.0, 9.0, 9.0], ["joint_1", 1, 300.0, 300.0, 300.0]]
    assert "damping" not in table  # the file's own
    assert table["armature"][1][3:] == ["Not Specified", pytest.approx(0.01)]


def test_limits_are_there_to_be_overridden():
    for kind in (IdealPDActuator, ImplicitActuator):
        assert all(hasattr(kind, name) for name in ("_parse_joint_parameter", "effort_limit_sim", "velocity_limit_sim"))
    text = str(_make(ImplicitActuatorCfg(joint_names_expr=[".*"], stiffness=1, damping=1)))
    assert text == "ImplicitActuator (implicit) of 2 joints: joint_0, joint_1"
