"""Contacts as the viewer shows them: the forces hold up the weights."""

import math

import mujoco
import numpy as np
import pytest

from lift_lab.visualizers import contacts_of, sum_by_pair
from lift_lab.visualizers.contact_layer import fitting_cm_per_n

G = 9.81
XML = f"""
<mujoco>
  <option timestep="0.002" gravity="0 0 -{G}"/>
  <worldbody>
    <geom name="floor" type="plane" size="5 5 .1"/>
    <body name="lower" pos="0 0 0.05"><freejoint/><geom type="box" size=".1 .1 .05" mass="3"/></body>
    <body name="upper" pos="0 0 0.15"><freejoint/><geom type="box" size=".05 .05 .05" mass="0.5"/></body>
    <body name="ramp" pos="3 0 0"><geom type="box" size="1 1 .1" euler="0 10 0"/></body>
    <body name="sled" pos="3 0 0.17" euler="0 10 0"><freejoint/><geom type="box" size=".1 .1 .06" mass="2"/></body>
    <body name="flying" pos="0 3 9"><freejoint/><geom type="sphere" size=".1" mass="7"/></body>
  </worldbody>
</mujoco>
"""


@pytest.fixture(scope="module")
def resting():
    """Pairs of names of bodies that touch -> contact points and force, once everything stands still."""
    model = mujoco.MjModel.from_xml_string(XML)
    data = mujoco.MjData(model)
    mujoco.mj_step(model, data, 300)
    mujoco.mj_forward(model, data)
    contacts = contacts_of(model, data)
    pairs = {(model.body(a).name, model.body(b).name): value for (a, b), value in sum_by_pair(contacts).items()}
    return pairs, contacts, model


def test_contact_forces_carry_the_weights(resting):
    pairs, contacts, model = resting
    assert set(pairs) == {("lower", "world"), ("upper", "lower"), ("sled", "ramp")}
    for pair, weight in ((("lower", "world"), 3.5 * G), (("upper", "lower"), 0.5 * G), (("sled", "ramp"), 2 * G)):
        count, force = pairs[pair]
        assert count == 4
        # friction takes part: on the ramp the normal forces alone would be cos(10 degrees) of it, and lean
        np.testing.assert_allclose(force, (0, 0, weight), rtol=0.02, atol=0.02 * weight)
    lowest = [contact.position for contact in contacts if contact.body_id == model.body("lower").id]
    np.testing.assert_allclose(np.abs(lowest)[:, :2], 0.1, atol=0.01)


def test_arrows_show_the_lightest_weight_at_25_cm():
    model = mujoco.MjModel.from_xml_string(XML)
    assert fitting_cm_per_n(model) * 0.5 * G == pytest.approx(25, rel=0.05)
    fixed = mujoco.MjModel.from_xml_string("<mujoco><worldbody><geom size='1'/></worldbody></mujoco>")
    assert math.isfinite(fitting_cm_per_n(fixed))
