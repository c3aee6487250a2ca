"""Fixtures of the tests of learning."""

import pytest
import torch

from lift_lab_rl.threads import use_one_torch_thread


@pytest.fixture
def one_torch_thread():
    """One thread of torch, as in a training on a CPU, so that results have the same bits on every machine."""
    before = torch.get_num_threads()
    use_one_torch_thread()
    yield
    torch.set_num_threads(before)
