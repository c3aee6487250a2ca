"""Estimates of the contacts and constraints of one environment, for engines that allocate memory at the start."""

from __future__ import annotations

import mujoco
import numpy as np

from .base import silence


def estimate_sizes(model: mujoco.MjModel) -> tuple[int, int]:
    """Estimate the largest number of contacts and constraint rows of one environment.

    The contacts are twice those of the default state plus 48. The rows are for all of these contacts and for every
    equality, friction loss and limit.
    """
    data = mujoco.MjData(model)
    silence(data)
    mujoco.mj_forward(model, data)
    contacts = _round_up(2 * data.ncon + 48, 16)
    dim = int(max(model.geom_condim.max(initial=1), model.pair_dim.max(initial=1)))
    pyramidal = model.opt.cone == mujoco.mjtCone.mjCONE_PYRAMIDAL
    rows_per_contact = 2 * (dim - 1) if pyramidal and dim > 1 else dim
    limits = int(np.count_nonzero(model.jnt_limited) + np.count_nonzero(model.tendon_limited))
    return contacts, _round_up(data.ne + model.nv + model.ntendon + limits + rows_per_contact * contacts, 16)


def _round_up(value: int, multiple: int) -> int:
    return -(-value // multiple) * multiple
