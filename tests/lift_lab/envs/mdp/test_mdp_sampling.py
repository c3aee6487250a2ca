"""Samples from ranges of a configuration."""

import pytest
import torch

from lift_lab.envs.mdp.sampling import outside_unit_box, sample_offsets_outside
from lift_lab.utils.errors import ConfigError


def test_points_outside_a_box_are_spread_evenly():
    points = outside_unit_box(torch.rand(40_000, 2, generator=torch.Generator().manual_seed(1)) * 2 - 1, 1.5)
    m = points.abs().amax(1)
    assert m.min() >= 1.0 - 1e-6
    assert m.max() <= 1.5 + 1e-6
    # the part within 1.25 has (1.25^2 - 1) / (1.5^2 - 1) = 0.45 of the area; 5 deviations are 0.0125
    assert float((m < 1.25).float().mean()) == pytest.approx(0.45, abs=0.0125)


def test_offsets_lie_outside_their_ranges_about_the_same_middle():
    ranges = {"x": (1.0, 3.0), "z": (0.5, 0.5)}
    offsets = sample_offsets_outside(ranges, 2.0, torch.zeros(1000, 1), "ranges")
    x, y, z = offsets.unbind(1)
    assert ((x <= 1.0) | (x >= 3.0)).all()
    assert 0.0 <= x.min() < 0.1
    assert 3.9 < x.max() <= 4.0
    assert not y.any()
    assert (z == 0.5).all()
    with pytest.raises(ConfigError, match="ranges: no range of x, y and z has a width"):
        sample_offsets_outside({"z": (0.5, 0.5)}, 2.0, torch.zeros(1, 1), "ranges")
