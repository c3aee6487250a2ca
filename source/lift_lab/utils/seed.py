"""Seeding of every random generator in use."""

from __future__ import annotations

import os
import random

import numpy as np
import torch

from .errors import ConfigError


def configure_seed(seed: int | None, torch_deterministic: bool = False) -> int:
    """Seed ``random``, numpy and torch (all devices).

    Args:
        seed: the seed. None or -1 draws one (42 if ``torch_deterministic``).
        torch_deterministic: whether torch may use deterministic algorithms only, at some cost.

    Returns:
        The seed.

    Raises:
        ConfigError: the seed is outside of what numpy takes.
    """
    if seed is None or seed == -1:
        seed = 42 if torch_deterministic else random.randint(0, 10000)
    seed = int(seed)
    if not 0 <= seed < 2**32:
        raise ConfigError(f"seed {seed} is not within [0, {2**32 - 1}]; -1 draws one")
    random.seed(seed)
    np.random.seed(seed)  # noqa: NPY002
    torch.manual_seed(seed)
    if torch_deterministic:
        os.environ["CUBLAS_WORKSPACE_CONFIG"] = ":4096:8"  # asked for by cuBLAS
    if torch.are_deterministic_algorithms_enabled() != torch_deterministic:
        torch.use_deterministic_algorithms(torch_deterministic)  # the call itself imports torch's compiler, for seconds
    return seed
