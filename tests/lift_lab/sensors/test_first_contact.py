"""First contact and first air report each event once, at any physics step and number of them in a control step.

Environment p touches down in physics step p of a control step, so that one run has all phases. Expectations count whole
steps; the sensor adds float32 times.
"""

from collections.abc import Callable, Iterator
from typing import Literal

import pytest
import torch

import lift_lab.sim as sim_utils
from lift_lab.assets import AssetBaseCfg, RigidObject, RigidObjectCfg
from lift_lab.scene import InteractiveScene, InteractiveSceneCfg
from lift_lab.sensors import ContactSensor, ContactSensorCfg
from lift_lab.utils import configclass

MOST = 40
"""Environments, and the largest number of physics steps in a control step."""
RADIUS, WEIGHT = 0.1, 9.81
DECIMATIONS = (1, 2, 3, 5, 8, 13, 18, 23, 24, 29, 33, MOST)
TIME_STEPS = (0.001, 0.002, 0.0025, 0.004, 0.005, 1 / 60, 1 / 100, 1 / 120, 1 / 240)


@configclass
class _SceneCfg(InteractiveSceneCfg):
    ground: AssetBaseCfg = AssetBaseCfg(prim_path="/World/ground", spawn=sim_utils.GroundPlaneCfg())
    ball: RigidObjectCfg = RigidObjectCfg(
        prim_path="{ENV_REGEX_NS}/Ball",
        init_state=RigidObjectCfg.InitialStateCfg(pos=(0.0, 0.0, 1.0)),
        spawn=sim_utils.SphereCfg(
            radius=RADIUS,
            rigid_props=sim_utils.RigidBodyPropertiesCfg(),
            mass_props=sim_utils.MassPropertiesCfg(mass=1.0),
            collision_props=sim_utils.CollisionPropertiesCfg(),
        ),
    )
    contact: ContactSensorCfg = ContactSensorCfg(prim_path="{ENV_REGEX_NS}/Ball", track_air_time=True)


class _World:
    def __init__(self, engine: Literal["native", "warp"], num_envs: int = MOST, **contact):
        sim = sim_utils.SimulationCfg(dt=0.001, device="cpu", physics=engine, num_threads=1)
        self.sim = sim_utils.SimulationContext(sim)
        cfg = _SceneCfg(num_envs=num_envs, env_spacing=3.0)
        cfg.contact = cfg.contact.replace(**contact)
        self.scene = InteractiveScene(cfg)
        self.sim.reset()
        self.scene.update(0.0)
        self.sensor: ContactSensor = self.scene["contact"]
        self.ball: RigidObject = self.scene["ball"]

    def put(self, touching: torch.Tensor) -> None:
        """Move the balls of some environments 1 mm into the ground, and the others up."""
        state = self.ball.data.default_root_state.clone()
        state[:, :3] += self.scene.env_origins
        state[:, 2] = torch.where(touching, RADIUS - 0.001, 1.0)
        self.ball.write_root_state_to_sim(state)


@pytest.fixture
def world() -> Iterator[Callable[..., _World]]:
    made: list[_World] = []

    def make(*args, **options) -> _World:
        made.append(_World(*args, **options))
        return made[-1]

    yield make
    for one in made:
        one.sim.close()


def _schedule(decimation: int) -> torch.Tensor:
    """Which environments touch the ground in which physics step, shape (4 control steps, num_envs).

    Each lands in its own step of the second control step and leaves one and a half control steps later.
    """
    step = torch.arange(4 * decimation)[:, None] - decimation
    phase = torch.arange(MOST) % decimation
    return (step >= phase) & (step < phase + decimation + (decimation + 1) // 2)


def _began_at_last(there: torch.Tensor, decimation: int, period: int = 1) -> torch.Tensor:
    """At the end of each control step: whether a state holds that began in it, as readings every `period` show it."""
    seen = there[period - 1 :: period].repeat_interleave(period, dim=0)  # the reading that is the latest one
    seen = torch.cat((torch.zeros_like(there[: period - 1]), seen))[: len(there)]
    before = torch.cat((torch.zeros_like(seen[:1]), seen[:-1]))
    starts = (seen & ~before).unflatten(0, (-1, decimation)).any(dim=1)
    return starts & seen[decimation - 1 :: decimation]


def _feel(sensor: ContactSensor, sensordata: torch.Tensor, touching: torch.Tensor) -> None:
    """Put a weight on the ground into what the sensor reads: (found, force in the contact's frame, normal)."""
    sensordata.zero_()
    first = sensor._net._columns[0, 0]
    sensordata[:, first[0]] = touching.float()
    sensordata[:, first[1]] = -WEIGHT * touching
    sensordata[:, first[6]] = touching.float()


@pytest.mark.parametrize("dt", TIME_STEPS)
def test_each_landing_and_each_start_is_reported_once_at_any_decimation(world, dt):
    sensor = world("native").sensor
    sensor._sensordata = sensordata = torch.zeros_like(sensor._sensordata)
    for decimation in DECIMATIONS:
        touching = _schedule(decimation)
        landed, left = [], []
        sensor.reset()
        for step, there in enumerate(touching, start=1):
            _feel(sensor, sensordata, there)
            sensor.update(dt)
            if step % decimation == 0:
                landed.append(sensor.compute_first_contact(dt * decimation)[:, 0])
                left.append(sensor.compute_first_air(dt * decimation)[:, 0])
        expected = _began_at_last(touching, decimation)
        assert expected.any(dim=0).all()
        torch.testing.assert_close(torch.stack(landed), expected, msg=f"{decimation=}")
        torch.testing.assert_close(torch.stack(left), _began_at_last(~touching, decimation), msg=f"{decimation=}")


@pytest.mark.parametrize("period", [2, 3, 11])
def test_with_an_update_period_an_event_counts_from_the_reading_that_shows_it(world, period):
    dt = 1 / 240
    sensor = world("native", update_period=period * dt, history_length=2).sensor
    sensor._sensordata = sensordata = torch.zeros_like(sensor._sensordata)
    for decimation in (1, 4, 23):
        touching = _schedule(decimation).repeat_interleave(period, dim=0)  # long enough to be read
        landed, left = [], []
        sensor.reset()
        for step, there in enumerate(touching, start=1):
            _feel(sensor, sensordata, there)
            sensor.update(dt)
            if step % decimation == 0:
                landed.append(sensor.compute_first_contact(dt * decimation)[:, 0])
                left.append(sensor.compute_first_air(dt * decimation)[:, 0])
        expected = _began_at_last(touching, decimation, period)
        assert expected.sum(dim=0).max() == 1
        torch.testing.assert_close(torch.stack(landed), expected, msg=f"{decimation=}")
        # before the first reading a body is neither in contact nor in the air
        in_air = torch.cat((touching[: period - 1].new_ones(period - 1, MOST), touching[period - 1 :]))
        expected = _began_at_last(~in_air, decimation, period)
        torch.testing.assert_close(torch.stack(left), expected, msg=f"{decimation=}")


@pytest.mark.parametrize("engine", ["native", "warp"])
@pytest.mark.parametrize("options", [{"history_length": 3}, {"update_period": 0.003}])
def test_balls_that_are_put_on_the_ground_are_reported_once_on_both_engines(world, engine, options):
    ours, decimation = world(engine, **options), 24
    period = 3 if "update_period" in options else 1
    touching = _schedule(decimation)
    landed = []
    for step, there in enumerate(touching, start=1):
        ours.put(there)
        ours.sim.step()
        ours.scene.update(0.001)
        if step % decimation == 0:
            landed.append(ours.sensor.compute_first_contact(0.001 * decimation)[:, 0])
    torch.testing.assert_close(torch.stack(landed), _began_at_last(touching, decimation, period))


@pytest.mark.parametrize("options", [{}, {"update_period": 0.002}])
def test_a_reset_forgets_a_landing_of_its_environments_only(world, options):
    ours = world("native", num_envs=2, **options)
    ours.put(torch.tensor([True, True]))
    for _ in range(4):
        ours.sim.step()
        ours.scene.update(0.001)
    assert ours.sensor.compute_first_contact(0.004).all()
    ours.scene.reset(torch.tensor([0]))
    ours.put(torch.tensor([True, True]))
    assert ours.sensor.compute_first_contact(0.004)[:, 0].tolist() == [False, True]
    for _ in range(4):
        ours.sim.step()
        ours.scene.update(0.001)
    # what touches the ground when an episode starts has landed in its first step
    assert ours.sensor.compute_first_contact(0.004)[:, 0].tolist() == [True, False]
    assert not ours.sensor.compute_first_air(0.004).any()
