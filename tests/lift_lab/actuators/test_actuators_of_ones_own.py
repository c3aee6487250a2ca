"""Actuator classes of one's own in a scene, on both engines: what they resolve and compute is what the engine runs."""

from __future__ import annotations

import logging

import numpy as np
import pytest
import torch

import lift_lab.sim as sim_utils
from lift_lab.actuators import IdealPDActuator, IdealPDActuatorCfg, ImplicitActuator, ImplicitActuatorCfg
from lift_lab.assets import ArticulationCfg
from lift_lab.scene import InteractiveScene, InteractiveSceneCfg
from lift_lab.utils import configclass
from lift_lab.utils.buffers import DelayBuffer
from lift_lab.utils.errors import ConfigError

NUM_ENVS = 2


@configclass
class _SceneCfg(InteractiveSceneCfg):
    arm: ArticulationCfg | None = None


@pytest.fixture(scope="module")
def arm_file(tmp_path_factory, author_arm):
    return author_arm(tmp_path_factory.mktemp("usd") / "arm.usda", drives=True)


@pytest.fixture(params=["native", "warp"])
def start(request, arm_file):
    """Starts a scene of the arm with actuators; returns the simulation and the arm."""
    sims = []

    def start(debug_print=False, **actuators):
        sim = sim_utils.SimulationContext(sim_utils.SimulationCfg(device="cpu", physics=request.param, dt=0.002))
        arm = ArticulationCfg(
            prim_path="{ENV_REGEX_NS}/Arm",
            spawn=sim_utils.UsdFileCfg(usd_path=str(arm_file)),
            actuators=actuators,
            actuator_value_resolution_debug_print=debug_print,
        )
        scene = InteractiveScene(_SceneCfg(num_envs=NUM_ENVS, env_spacing=2.0, arm=arm))
        sim.reset()
        sims.append(sim)
        return sim, scene["arm"], scene

    yield start
    for sim in sims:
        sim.close()


def _efforts(sim, arm, position=0.0, pos=0.0, vel=0.0):
    arm.write_joint_state_to_sim(torch.full((NUM_ENVS, 2), pos), torch.full((NUM_ENVS, 2), vel))
    arm.set_joint_position_target(torch.full((NUM_ENVS, 2), position))
    arm.write_data_to_sim()
    sim.physics.forward()
    return sim.physics.field("qfrc_actuator").numpy()[:, arm._dof_ids]


class _Rated(ImplicitActuator):
    """Resolves gains from a natural frequency and a rating, as vendors' classes do."""

    def __init__(self, cfg, *args, **kwargs):
        super().__init__(cfg, *args, **kwargs)
        inertia = self._parse_joint_parameter(cfg.inertia, None)
        self.stiffness[:] = inertia * cfg.frequency**2
        self.damping[:] = 2.0 * inertia * cfg.frequency
        self.effort_limit_sim[:] = self.effort_limit[:] = 3.0
        self.velocity_limit_sim[:] = self.velocity_limit[:] = 4.5
        self.armature[:] = 0.25


@configclass
class _RatedCfg(ImplicitActuatorCfg):
    class_type: type = _Rated
    stiffness: float | None = None
    damping: float | None = None
    inertia: dict[str, float] | None = None
    frequency: float = 10.0


def test_what_an_implicit_class_resolves_is_reported_and_runs(start):
    cfg = _RatedCfg(joint_names_expr=[".*"], inertia={"shoulder": 0.2, "elbow": 0.1})
    sim, arm, _ = start(all=cfg)
    order = [arm.joint_names.index(name) for name in ("shoulder", "elbow")]
    data = arm.data
    for found, expected in (
        (data.joint_stiffness, [20.0, 10.0]),
        (data.default_joint_stiffness, [20.0, 10.0]),
        (data.joint_damping, [4.0, 2.0]),
        (data.joint_effort_limits, [3.0, 3.0]),
        (data.joint_vel_limits, [4.5, 4.5]),
        (data.joint_armature, [0.25, 0.25]),
    ):
        np.testing.assert_allclose(found[:, order], [expected] * NUM_ENVS, rtol=1e-6)
    law = np.array([20.0, 10.0]) * (0.05 - 0.01) - np.array([4.0, 2.0]) * 0.1
    np.testing.assert_allclose(_efforts(sim, arm, 0.05, 0.01, 0.1)[:, order], [law] * NUM_ENVS, rtol=1e-4)
    np.testing.assert_allclose(_efforts(sim, arm, 9.0), 3.0)  # the limit
    armature = sim.physics.randomizable("dof_armature").cpu().numpy()
    np.testing.assert_allclose(armature[:, arm._dof_ids], 0.25)


class _Curve(IdealPDActuator):
    """An effort limit of its own that falls with speed, from parameters of its config."""

    def __init__(self, cfg, *args, **kwargs):
        super().__init__(cfg, *args, **kwargs)
        self._joint_vel = torch.zeros_like(self.computed_effort)
        self._peak = self._parse_joint_parameter(cfg.peak, 1e9)
        self._knee = self._parse_joint_parameter(cfg.knee, cfg.peak)

    def compute(self, control_action, joint_pos, joint_vel):
        self._joint_vel[:] = joint_vel
        super().compute(control_action, joint_pos, joint_vel)
        return control_action

    def _clip_effort(self, effort):
        limit = torch.where(self._joint_vel.abs() > 1.0, self._knee, self._peak)
        return effort.clamp(-limit, limit)


@configclass
class _CurveCfg(IdealPDActuatorCfg):
    class_type: type = _Curve
    peak: float = 8.0
    knee: dict[str, float] | float | None = None


def test_an_explicit_class_clips_by_parameters_of_its_own(start):
    cfg = _CurveCfg(joint_names_expr=[".*"], stiffness=100.0, damping=0.0, knee={".*": 2.0})
    sim, arm, _ = start(all=cfg)
    np.testing.assert_allclose(_efforts(sim, arm, 1.0), 8.0)
    np.testing.assert_allclose(_efforts(sim, arm, 1.0, vel=1.5), 2.0)
    np.testing.assert_allclose(arm.data.applied_torque, 2.0)
    np.testing.assert_allclose(arm.data.computed_torque, 100.0)


class _LateTargets(ImplicitActuator):
    """An implicit drive whose position targets arrive two physics steps late."""

    def __init__(self, cfg, *args, **kwargs):
        super().__init__(cfg, *args, **kwargs)
        self.buffer = DelayBuffer(2, self._num_envs, device=self._device)
        self.buffer.set_time_lag(2)

    def reset(self, env_ids):
        self.buffer.reset(env_ids)

    def compute(self, control_action, joint_pos, joint_vel):
        control_action.joint_positions = self.buffer.compute(control_action.joint_positions)
        return super().compute(control_action, joint_pos, joint_vel)


def test_an_implicit_class_that_computes_is_followed_by_the_engine(start):
    cfg = ImplicitActuatorCfg(class_type=_LateTargets, joint_names_expr=["shoulder"], stiffness=50.0, damping=5.0)
    other = ImplicitActuatorCfg(joint_names_expr=["elbow"], stiffness=20.0, damping=0.0)
    sim, arm, scene = start(late=cfg, other=other)
    assert scene.substep_entities == ["arm"]
    shoulder, elbow = (arm.joint_names.index(name) for name in ("shoulder", "elbow"))
    arm.reset()
    efforts = [_efforts(sim, arm, target) for target in (0.1, 0.2, 0.3, 0.4)]
    # the oldest target until there are two more
    np.testing.assert_allclose([e[0, shoulder] for e in efforts], [5.0, 5.0, 5.0, 10.0], rtol=1e-5)
    np.testing.assert_allclose([e[0, elbow] for e in efforts], [2.0, 4.0, 6.0, 8.0], rtol=1e-5)
    np.testing.assert_allclose(arm.data.computed_torque[:, shoulder], 10.0, rtol=1e-5)


class _NoTargets(ImplicitActuator):
    def compute(self, control_action, joint_pos, joint_vel):
        control_action = super().compute(control_action, joint_pos, joint_vel)
        control_action.joint_positions = None
        return control_action


def test_an_implicit_class_without_targets_is_named(start):
    cfg = ImplicitActuatorCfg(class_type=_NoTargets, joint_names_expr=[".*"], stiffness=50.0, damping=5.0)
    with pytest.raises(ConfigError, match=r"_NoTargets\.compute must return joint_positions"):
        start(all=cfg)


def test_where_values_come_from_is_logged_on_request(start, caplog):
    with caplog.at_level(logging.WARNING, "lift_lab.assets.articulation.articulation"):
        start(debug_print=True, all=ImplicitActuatorCfg(joint_names_expr=[".*"], stiffness=None, damping=9.0))
    lines = [
        f"scene.arm.actuators['all'].{text}"
        for text in (
            "stiffness of 'elbow': file 30, config Not Specified, used 30",
            "damping of 'elbow': file 3, config 9, used 9",
        )
    ]
    assert set(lines) <= set(caplog.messages)
