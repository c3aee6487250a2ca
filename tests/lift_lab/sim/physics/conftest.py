"""One small model with everything the engines must agree on, and one engine of each kind to run it."""

from __future__ import annotations

from collections.abc import Callable

import mujoco
import pytest
import torch

from lift_lab.sim.physics import Physics, make_physics

# A sliding box, a frictionless pendulum, a ball that touches nothing, two fingers that squeeze a block in the air,
# a mocap marker, and sensors of every stage.
XML = """
<mujoco>
  <option timestep="0.005" integrator="implicitfast" cone="pyramidal" iterations="20" ls_iterations="30"/>
  <default>
    <default class="finger">
      <joint type="slide" range="-0.05 0.05" damping="1" armature="0.1"/>
      <geom type="box" size="0.01 0.02 0.03" mass="0.05" contype="4" conaffinity="4" condim="4"
            friction="1 0.02 0.0001" solref="0.01 1"/>
    </default>
  </default>
  <worldbody>
    <geom name="floor" type="plane" size="5 5 0.1" contype="1" conaffinity="1" friction="0.5 0.005 0.0001"/>
    <body name="box" pos="0 0 0.3">
      <freejoint/>
      <geom name="box" type="box" size="0.1 0.1 0.03" mass="1" contype="1" conaffinity="1" condim="4"
            friction="0.5 0.005 0.0001" solref="0.01 1"/>
    </body>
    <body name="pendulum" pos="2 0 2">
      <joint name="pivot" type="hinge" axis="0 1 0"/>
      <inertial mass="2" pos="0 0 -0.5" diaginertia="0.02 0.02 0.001"/>
      <geom type="sphere" size="0.02" pos="0 0 -0.5" contype="0" conaffinity="0"/>
      <site name="tip" pos="0 0 -0.5"/>
    </body>
    <body name="ball" pos="-2 0 3">
      <freejoint/>
      <geom type="sphere" size="0.05" mass="0.5" contype="0" conaffinity="0"/>
      <site name="ball"/>
    </body>
    <body name="palm" pos="0 2 1">
      <body name="left" pos="0 0.035 0">
        <joint name="left" class="finger" axis="0 -1 0"/>
        <geom class="finger"/>
      </body>
      <body name="right" pos="0 -0.035 0">
        <joint name="right" class="finger" axis="0 1 0"/>
        <geom class="finger"/>
      </body>
    </body>
    <body name="block" pos="0 2 1">
      <freejoint/>
      <geom type="box" size="0.012 0.012 0.012" mass="0.1" contype="4" conaffinity="4" condim="4"
            friction="1 0.02 0.0001" solref="0.01 1"/>
    </body>
    <body name="marker" mocap="true" pos="0 0 1"/>
  </worldbody>
  <actuator>
    <position name="left" joint="left" kp="350" kv="10"/>
    <position name="right" joint="right" kp="350" kv="10"/>
  </actuator>
  <sensor>
    <framepos objtype="site" objname="tip"/>
    <framelinvel objtype="body" objname="ball"/>
    <accelerometer site="ball"/>
  </sensor>
</mujoco>
"""
NUM_ENVS = 4
CUDA = pytest.mark.skipif(not torch.cuda.is_available(), reason="needs a CUDA device")


@pytest.fixture
def spec() -> mujoco.MjSpec:
    """The shared model, to be changed and compiled."""
    return mujoco.MjSpec.from_string(XML)


@pytest.fixture(scope="session")
def model() -> mujoco.MjModel:
    return mujoco.MjModel.from_xml_string(XML)


@pytest.fixture(scope="session")
def make(model: mujoco.MjModel) -> Callable[..., Physics]:
    """Make another engine on the shared model: `make("native-cpu")`, with any option of make_physics."""

    def build(name: str, num_envs: int = NUM_ENVS, **options) -> Physics:
        kind, device = name.split("-")
        return make_physics(model, num_envs, "cuda:0" if device == "cuda" else device, kind, **options)

    return build


@pytest.fixture(scope="session", params=["native-cpu", "warp-cpu", pytest.param("warp-cuda", marks=CUDA)])
def engine(request: pytest.FixtureRequest) -> str:
    return request.param


@pytest.fixture(scope="session")
def shared(engine: str, make: Callable[..., Physics]) -> Physics:
    return make(engine)


@pytest.fixture
def physics(shared: Physics) -> Physics:
    """An engine in its default state. Do not randomise its model: others use it too."""
    shared.reset()
    shared.refresh()
    shared.health()
    return shared
