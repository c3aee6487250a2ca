"""Actuator models as functions of targets and joint state, each against its own law written out."""

import numpy as np
import pytest
import torch
from torch import nn

from lift_lab.actuators import (
    ActuatorNetLSTMCfg,
    ActuatorNetMLPCfg,
    DCMotorCfg,
    DelayedPDActuatorCfg,
    IdealPDActuator,
    IdealPDActuatorCfg,
    RemotizedPDActuatorCfg,
)
from lift_lab.utils.errors import ConfigError
from lift_lab.utils.types import ArticulationActions

NUM_ENVS = 4
JOINTS = ["hip", "knee"]


def _make(cfg, num_envs=NUM_ENVS, **values):
    """The cfg's actuator with gains of 10 and 0 unless ``values`` say otherwise."""
    given = {"stiffness": 10.0, "damping": 0.0} | values
    return cfg.class_type(cfg, JOINTS, torch.arange(2), num_envs, "cpu", **given)


def _targets(position):
    position = torch.as_tensor(position, dtype=torch.float32).expand(NUM_ENVS, 2).clone()
    return ArticulationActions(position, torch.zeros(NUM_ENVS, 2), torch.zeros(NUM_ENVS, 2), torch.arange(2))


def _effort(actuator, position, joint_pos=0.0, joint_vel=0.0):
    state = (torch.as_tensor(x, dtype=torch.float32).expand(NUM_ENVS, 2).clone() for x in (joint_pos, joint_vel))
    return actuator.compute(_targets(position), *state).joint_efforts


def test_a_pd_actuator_adds_stiffness_damping_and_feed_forward_and_clips_the_sum():
    actuator = _make(
        IdealPDActuatorCfg(joint_names_expr=[".*"], stiffness=None, damping=None), damping=2.0, effort_limit=5.0
    )
    action = ArticulationActions(*(torch.full((NUM_ENVS, 2), x) for x in (0.5, 1.0, 0.25)))
    effort = actuator.compute(action, torch.tensor([[0.4, -0.4]]), torch.tensor([[0.5, 0.5]])).joint_efforts
    # 10 (0.5 - q) + 2 (1.0 - 0.5) + 0.25
    np.testing.assert_allclose(effort, [[2.25, 5.0]] * NUM_ENVS, rtol=1e-6)
    np.testing.assert_allclose(actuator.computed_effort, [[2.25, 10.25]] * NUM_ENVS, rtol=1e-6)


def test_an_actuator_of_ones_own_gets_isaac_labs_arguments():
    class Halved(IdealPDActuator):
        def __init__(self, cfg, *args, **kwargs):
            super().__init__(cfg, *args, **kwargs)
            self.calls = torch.zeros(self._num_envs, self.num_joints, device=self._device)

        def compute(self, control_action, joint_pos, joint_vel):
            self.calls += 1
            control_action = super().compute(control_action, joint_pos, joint_vel)
            control_action.joint_efforts = 0.5 * control_action.joint_efforts
            return control_action

    actuator = _make(IdealPDActuatorCfg(class_type=Halved, joint_names_expr=[".*"], stiffness=None, damping=None))
    np.testing.assert_allclose(_effort(actuator, 0.2), 1.0)
    assert (actuator.calls == 1).all()


@pytest.mark.parametrize(
    ("speed", "wanted", "given"),
    [
        (0.0, 100.0, 8.0),  # the effort limit
        (2.0, 100.0, 5.0),  # half the no-load speed, half the stall effort
        (4.0, 100.0, 0.0),  # the no-load speed
        (6.0, 100.0, -5.0),  # driven faster than that: braked along the same line
        (40.0, 100.0, -8.0),  # by the effort limit at most
        (-6.0, -100.0, 5.0),
        (-6.0, 100.0, 8.0),
    ],
)
def test_a_dc_motor_gives_what_lies_under_its_torque_speed_line(speed, wanted, given):
    cfg = DCMotorCfg(joint_names_expr=[".*"], stiffness=None, damping=None, saturation_effort=10.0)
    actuator = _make(cfg, effort_limit=8.0, velocity_limit=4.0)
    np.testing.assert_allclose(_effort(actuator, wanted / 10.0, joint_vel=speed), given, atol=1e-5)


def test_a_delayed_actuator_follows_the_targets_of_some_steps_ago():
    cfg = DelayedPDActuatorCfg(joint_names_expr=[".*"], stiffness=None, damping=None, min_delay=2, max_delay=2)
    actuator = _make(cfg)
    actuator.reset(None)
    efforts = [float(_effort(actuator, target)[0, 0]) for target in (0.1, 0.2, 0.3, 0.4)]
    # until there are targets as old as the lag, the oldest
    np.testing.assert_allclose(efforts, [1.0, 1.0, 1.0, 2.0], rtol=1e-6)


def test_velocity_and_effort_targets_are_as_late_as_positions():
    cfg = DelayedPDActuatorCfg(joint_names_expr=[".*"], stiffness=None, damping=None, min_delay=2, max_delay=2)
    actuator = _make(cfg, damping=2.0)
    actuator.reset(None)
    still, efforts = torch.zeros(NUM_ENVS, 2), []
    for step in range(1, 5):
        action = ArticulationActions(*(torch.full((NUM_ENVS, 2), scale * step) for scale in (0.1, 1.0, 100.0)))
        efforts.append(float(actuator.compute(action, still, still).joint_efforts[0, 0]))
    # 10 * 0.1 + 2 * 1 + 100 of the step that is followed
    np.testing.assert_allclose(efforts, [103.0, 103.0, 103.0, 206.0], rtol=1e-6)


def test_lags_are_drawn_between_their_bounds_for_each_environment():
    torch.manual_seed(2)
    cfg = DelayedPDActuatorCfg(joint_names_expr=[".*"], stiffness=None, damping=None, min_delay=1, max_delay=3)
    actuator = _make(cfg, num_envs=200)
    actuator.reset(slice(None))
    lags = actuator.positions_delay_buffer.time_lags
    assert sorted(lags.unique().tolist()) == [1, 2, 3]
    assert torch.equal(lags, actuator.efforts_delay_buffer.time_lags)


def test_a_partial_reset_of_a_delayed_actuator_leaves_the_others_lag_and_targets_alone():
    cfg = DelayedPDActuatorCfg(joint_names_expr=[".*"], stiffness=None, damping=None, min_delay=2, max_delay=2)
    actuator = _make(cfg)
    actuator.reset(None)
    for target in (0.1, 0.2):
        _effort(actuator, target)
    actuator.reset(torch.tensor([1]))
    effort = _effort(actuator, 0.9)[:, 0]
    np.testing.assert_allclose(effort, [1.0, 9.0, 1.0, 1.0], rtol=1e-6)


def test_delays_that_are_no_range_are_refused():
    with pytest.raises(ConfigError, match="min_delay must lie between 0 and max_delay 1, got 2"):
        _make(DelayedPDActuatorCfg(joint_names_expr=[".*"], stiffness=None, damping=None, min_delay=2, max_delay=1))


def test_a_remotized_actuator_interpolates_its_effort_limit_over_the_angle():
    cfg = RemotizedPDActuatorCfg(
        joint_names_expr=[".*"],
        stiffness=None,
        damping=None,
        joint_parameter_lookup=[[-1.0, 1.0, 2.0], [0.0, 1.0, 4.0], [1.0, 1.0, 10.0]],
    )
    actuator = _make(cfg, effort_limit=1.0)  # does not apply
    actuator.reset(None)
    angles = torch.tensor([[-2.0, -0.5], [0.0, 0.5], [1.0, 7.0], [0.25, -1.0]])
    effort = actuator.compute(_targets(100.0), angles, torch.zeros(NUM_ENVS, 2)).joint_efforts
    expected = np.interp(angles, [-1.0, 0.0, 1.0], [2.0, 4.0, 10.0])
    np.testing.assert_allclose(effort, expected, rtol=1e-6)
    torch.testing.assert_close(actuator.applied_effort, effort)


class _Mlp(nn.Module):
    """A sum of its inputs with known weights: error now, error 2 steps ago, velocity now, velocity 2 steps ago."""

    def forward(self, x: torch.Tensor) -> torch.Tensor:
        return x @ torch.tensor([1.0, 10.0, 100.0, 1000.0])


@pytest.fixture
def mlp_file(tmp_path):
    path = str(tmp_path / "mlp.pt")
    torch.jit.script(_Mlp()).save(path)
    return path


def _mlp(path, order):
    return ActuatorNetMLPCfg(
        joint_names_expr=[".*"],
        saturation_effort=1e9,
        velocity_limit=1e9,
        network_file=path,
        pos_scale=2.0,
        vel_scale=0.5,
        torque_scale=3.0,
        input_order=order,
        input_idx=[0, 2],
    )


@pytest.mark.parametrize(("order", "weights"), [("pos_vel", (1, 10, 100, 1000)), ("vel_pos", (100, 1000, 1, 10))])
def test_a_network_sees_scaled_errors_and_velocities_now_and_before(mlp_file, order, weights):
    actuator = _make(_mlp(mlp_file, order))
    errors, speeds = [0.1, 0.2, 0.3], [1.0, 2.0, 3.0]
    for error, speed in zip(errors, speeds, strict=True):
        effort = _effort(actuator, 1.0 + error, joint_pos=1.0, joint_vel=speed)
    inputs = (2.0 * errors[2], 2.0 * errors[0], 0.5 * speeds[2], 0.5 * speeds[0])
    np.testing.assert_allclose(effort, 3.0 * np.dot(weights, inputs), rtol=1e-4)


def test_a_partial_reset_empties_the_networks_history_of_those_environments_alone(mlp_file):
    actuator = _make(_mlp(mlp_file, "pos_vel"))
    for _ in range(2):
        _effort(actuator, 0.1, joint_vel=1.0)
    actuator.reset(torch.tensor([2]))
    effort = _effort(actuator, 0.1, joint_vel=1.0)[:, 0]
    full, fresh = 3.0 * (0.2 * 11 + 0.5 * 1100), 3.0 * (0.2 * 1 + 0.5 * 100)
    np.testing.assert_allclose(effort, [full, full, fresh, full], rtol=1e-5)


def test_an_input_order_that_does_not_exist_is_refused(mlp_file):
    with pytest.raises(ConfigError, match="input_order must be pos_vel or vel_pos, not 'pos'"):
        _make(_mlp(mlp_file, "pos"))


class _Lstm(nn.Module):
    def __init__(self):
        super().__init__()
        self.lstm = nn.LSTM(2, 5, num_layers=2, batch_first=True)
        self.head = nn.Linear(5, 1)

    def forward(
        self, x: torch.Tensor, state: tuple[torch.Tensor, torch.Tensor]
    ) -> tuple[torch.Tensor, tuple[torch.Tensor, torch.Tensor]]:
        y, state = self.lstm(x, state)
        return self.head(y[:, -1]), state


def test_a_recurrent_network_keeps_its_state_for_each_joint_until_reset(tmp_path):
    torch.manual_seed(0)
    network = _Lstm().eval()
    path = str(tmp_path / "lstm.pt")
    torch.jit.script(network).save(path)
    cfg = ActuatorNetLSTMCfg(joint_names_expr=[".*"], saturation_effort=1e9, velocity_limit=1e9, network_file=path)
    actuator = _make(cfg)
    for error in (0.1, 0.4):
        _effort(actuator, error, joint_vel=0.2)
    actuator.reset(torch.tensor([3]))
    effort = _effort(actuator, -0.3, joint_vel=0.2)
    with torch.no_grad():
        inputs = torch.tensor([[[0.1, 0.2], [0.4, 0.2], [-0.3, 0.2]]])
        empty = torch.zeros(2, 1, 5)
        after_all = network(inputs, (empty, empty))[0].item()
        after_reset = network(inputs[:, 2:], (empty, empty))[0].item()
    np.testing.assert_allclose(effort[:3], after_all, rtol=1e-5)
    np.testing.assert_allclose(effort[3], after_reset, rtol=1e-5)
