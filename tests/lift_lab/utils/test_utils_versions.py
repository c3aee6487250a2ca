"""Whether a tensor was written into."""

import torch

from lift_lab.utils.versions import version_of


def test_every_write_counts_also_through_a_view():
    tensor = torch.zeros(3)
    before = version_of(tensor)
    assert version_of(tensor) == before
    tensor[1:] += 1.0
    after = version_of(tensor)
    assert after is not None
    assert after != before
    with torch.inference_mode():
        tensor.zero_()
    assert version_of(tensor) != after


def test_nothing_is_counted_of_a_tensor_of_inference_mode():
    with torch.inference_mode():
        tensor = torch.zeros(3)
    assert version_of(tensor) is None
