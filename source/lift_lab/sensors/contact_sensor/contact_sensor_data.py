"""Readings of a contact sensor."""

from __future__ import annotations

from dataclasses import dataclass

import torch

from lift_lab.utils.attributes import EntityData


@dataclass
class ContactSensorData(EntityData):
    """Readings, with Isaac Lab's names. N environments, B bodies of the sensor, M filters, T entries of history.

    Forces act on the sensor's bodies. Fields that the config does not ask for are None.
    """

    net_forces_w: torch.Tensor
    """Sum of the normal contact forces on each body in N, shape (N, B, 3)."""
    net_forces_w_history: torch.Tensor
    """Past values, the latest first, shape (N, T, B, 3); T is 1 where no history is asked for."""
    force_matrix_w: torch.Tensor | None = None
    """Normal contact forces between each body and each filter in N, shape (N, B, M, 3)."""
    force_matrix_w_history: torch.Tensor | None = None
    """Past values, the latest first, shape (N, T, B, M, 3)."""
    friction_forces_w: torch.Tensor | None = None
    """Sum of the tangential contact forces between each body and each filter in N, shape (N, B, M, 3)."""
    contact_pos_w: torch.Tensor | None = None
    """Mean position of the contacts between each body and each filter in m; NaN without contact. Shape (N, B, M, 3)."""
    pos_w: torch.Tensor | None = None
    """Positions of the bodies in m, shape (N, B, 3)."""
    quat_w: torch.Tensor | None = None
    """Orientations of the bodies (w, x, y, z), shape (N, B, 4)."""
    current_air_time: torch.Tensor | None = None
    """Time in s since the body lost contact, 0 in contact. Shape (N, B)."""
    last_air_time: torch.Tensor | None = None
    """Time in s that the body was in the air before its last contact, shape (N, B)."""
    current_contact_time: torch.Tensor | None = None
    """Time in s since the body touched something, 0 in the air. Shape (N, B)."""
    last_contact_time: torch.Tensor | None = None
    """Time in s that the body was in contact before it last left, shape (N, B)."""
