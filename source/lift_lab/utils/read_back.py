"""Answers that the host needs of a device before it can go on, asked together: each question makes it wait."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import torch


def where_true(masks: Sequence[torch.Tensor]) -> list[torch.Tensor]:
    """Where each mask is true; the host waits for the device once.

    Args:
        masks: bool tensors of one shape (n,) on one device.

    Returns:
        For each mask its indices, ascending, as a LongTensor on that device.
    """
    device = masks[0].device
    rows = torch.stack(list(masks)).cpu().numpy()
    return [torch.from_numpy(np.flatnonzero(row)).to(device, non_blocking=True) for row in rows]
