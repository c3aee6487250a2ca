"""A value with the time at which it was computed."""

from __future__ import annotations

from dataclasses import dataclass

import torch


@dataclass
class TimestampedBuffer:
    """A tensor that is computed when first asked for at a time, and then kept."""

    data: torch.Tensor | None = None
    """The value; None before the first update."""
    timestamp: float = -1.0
    """Time of the last update in s; -1 before the first."""
