"""Whether a tensor was written into since somebody last looked."""

from __future__ import annotations

import torch


def version_of(tensor: torch.Tensor) -> int | None:
    """How often a tensor, or what it is a part of, was written into; None where torch does not count it."""
    return None if tensor.is_inference() else tensor._version
