"""Advantage clipping cuts advantages off and normalises them again, from its first iteration on."""

import pytest
import torch

from lift_lab.utils.errors import ConfigError
from lift_lab_rl.rsl_rl.advantages import AdvantageClip


@pytest.fixture
def advantages():
    """Normalised advantages of a rollout in which one step in a hundred loses a lot."""
    generator = torch.Generator().manual_seed(2)
    values = torch.randn(24, 64, 1, generator=generator)
    values -= 50.0 * (torch.rand(24, 64, 1, generator=generator) < 0.01)
    return (values - values.mean()) / values.std()


def test_advantages_are_cut_off_at_a_number_of_standard_deviations(advantages):
    assert advantages.abs().max() > 5.0  # the losses
    clipped = AdvantageClip(0.5)(advantages, 0)
    expected = advantages.double().clip(-0.5, 0.5)
    expected = (expected - expected.mean()) / expected.std()
    torch.testing.assert_close(clipped.double(), expected, atol=1e-5, rtol=1e-5)
    torch.testing.assert_close(AdvantageClip(1000.0)(advantages, 0), advantages, atol=1e-5, rtol=1e-5)


def test_clipping_begins_when_it_should_and_is_off_without_a_limit(advantages):
    clip = AdvantageClip(0.5, start=2)
    assert [clip(advantages, k) is advantages for k in range(4)] == [True, True, False, False]
    assert AdvantageClip(None)(advantages, 9) is advantages


@pytest.mark.parametrize("limit", [0.0, -1.0, float("nan"), float("inf")])
def test_a_limit_that_leaves_nothing_of_an_advantage_is_refused(limit):
    with pytest.raises(ConfigError, match="advantage_clip is"):
        AdvantageClip(limit)
