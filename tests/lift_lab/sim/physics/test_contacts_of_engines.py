"""Contacts of one environment, from either engine."""

import numpy as np

from lift_lab.visualizers import contacts_of, sum_by_pair

G = 9.81


def test_contact_forces_carry_the_weights_on_every_engine(physics):
    model = physics.model
    physics.step(200)
    box = model.body("box").id
    physics.write("qpos", 1.0, [2], [2])  # lifted, in this environment only
    for env_id in (1, 2):
        pairs = sum_by_pair(contacts_of(model, physics.get_data(env_id)))
        assert ((box, 0) in pairs) == (env_id == 1)
    count, force = sum_by_pair(contacts_of(model, physics.get_data(1)))[box, 0]
    assert count == 4
    np.testing.assert_allclose(force, (0, 0, 1.0 * G), atol=0.02 * G)
