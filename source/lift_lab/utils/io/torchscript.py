"""Loading TorchScript models."""

from __future__ import annotations

from pathlib import Path

import torch

from ..errors import FileError


def load_torchscript_model(model_path: str | Path, device: str = "cpu") -> torch.jit.ScriptModule:
    """Load a model that ``torch.jit.save`` wrote, in evaluation mode.

    Raises:
        FileError: no such file.
    """
    if not Path(model_path).is_file():
        raise FileError(f"no TorchScript file '{model_path}'")
    return torch.jit.load(str(model_path), map_location=device).eval()
