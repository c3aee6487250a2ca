"""The contacts of one environment: where bodies touch, and with which force."""

from __future__ import annotations

from dataclasses import dataclass

import mujoco
import numpy as np


@dataclass
class Contact:
    """One contact point and the force there."""

    body_id: int
    """Body that the force acts on, of the compiled model."""
    other_id: int
    """Body that exerts it. Where one of the two cannot move, it is this one."""
    position: np.ndarray
    """Contact point in m, without the environment's origin, shape (3,)."""
    force: np.ndarray
    """Normal force and friction together, in the world frame in N, shape (3,)."""


def contacts_of(model: mujoco.MjModel, data: mujoco.MjData) -> list[Contact]:
    """Return the contacts that carry a force or could.

    Contacts that MuJoCo detects at a distance, beyond the gap of the geoms, are left out.

    Args:
        model: the compiled model.
        data: a state with everything computed (:meth:`lift_lab.sim.physics.base.Physics.get_data`).
    """
    found, wrench = [], np.zeros(6)
    for i in range(data.ncon):
        contact = data.contact[i]
        if contact.efc_address < 0 or min(contact.geom) < 0:
            continue
        mujoco.mj_contactForce(model, data, i, wrench)
        # the rows of the frame are the normal, from the first geom to the second, and two tangents; the force is
        # what the first geom does to the second
        force = contact.frame.reshape(3, 3).T @ wrench[:3]
        other_id, body_id = (int(model.geom_bodyid[geom]) for geom in contact.geom)
        if model.body_weldid[body_id] == 0:
            body_id, other_id, force = other_id, body_id, -force
        found.append(Contact(body_id, other_id, contact.pos.copy(), force))
    return found


def sum_by_pair(contacts: list[Contact]) -> dict[tuple[int, int], tuple[int, np.ndarray]]:
    """Return the number of contact points and the sum of their forces in N for each pair of bodies.

    Keys are (body that the force acts on, the other body), each pair in one order only.
    """
    pairs: dict[tuple[int, int], tuple[int, np.ndarray]] = {}
    for contact in contacts:
        key, force = (contact.body_id, contact.other_id), contact.force
        if (contact.other_id, contact.body_id) in pairs:
            key, force = (contact.other_id, contact.body_id), -force
        count, total = pairs.get(key, (0, np.zeros(3)))
        pairs[key] = (count + 1, total + force)
    return pairs
