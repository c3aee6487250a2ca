"""Ring buffers, delay lines, interpolation."""

import pytest
import torch

from lift_lab.utils import CircularBuffer, DelayBuffer, LinearInterpolation, TimestampedBuffer


def value(step: float, num_envs: int = 3) -> torch.Tensor:
    """(num_envs, 2): the step, and the step plus ten times the environment."""
    envs = torch.arange(num_envs)
    return torch.stack((torch.full((num_envs,), step), step + 10.0 * envs), dim=-1)


def test_the_buffer_holds_the_last_values_oldest_first():
    ring = CircularBuffer(3, 3, "cpu")
    for step in range(5):
        ring.append(value(step))
    assert ring.buffer.shape == (3, 3, 2)
    assert ring.buffer[:, :, 0].tolist() == [[2.0, 3.0, 4.0]] * 3
    assert ring.buffer[2, :, 1].tolist() == [22.0, 23.0, 24.0]
    assert ring.current_length.tolist() == [3, 3, 3]


def test_the_first_value_fills_the_history():
    ring = CircularBuffer(3, 3, "cpu")
    ring.append(value(7))
    assert ring.buffer[:, :, 0].tolist() == [[7.0] * 3] * 3
    assert ring.current_length.tolist() == [1, 1, 1]


@pytest.mark.parametrize("others_have_values", [True, False])
def test_an_entry_can_be_given_its_first_value_apart_from_the_others(others_have_values):
    delay = DelayBuffer(2, 3, "cpu")
    delay.set_time_lag(2)
    for step in range(5) if others_have_values else ():
        delay.compute(value(step))
    delay.reset(torch.tensor([1]))
    delay.fill(torch.tensor([[70.0, 71.0]]), torch.tensor([1]))
    late = [delay.compute(value(step))[:, 0].tolist() for step in (5, 6, 7)]
    others = [3.0, 4.0, 5.0] if others_have_values else [5.0, 5.0, 5.0]
    assert late == [[other, own, other] for other, own in zip(others, [70.0, 70.0, 5.0], strict=True)]


@pytest.mark.parametrize("ids", [[1], torch.tensor([1])])
def test_a_reset_environment_starts_anew_and_the_others_go_on(ids):
    ring = CircularBuffer(3, 3, "cpu")
    for step in range(4):
        ring.append(value(step))
    ring.reset(ids)
    assert ring.current_length.tolist() == [3, 0, 3]
    assert ring.buffer[1].abs().sum() == 0
    ring.append(value(4))
    assert ring.buffer[:, :, 0].tolist() == [[2.0, 3.0, 4.0], [4.0] * 3, [2.0, 3.0, 4.0]]
    ring.append(value(5))
    assert ring.buffer[1, :, 0].tolist() == [4.0, 4.0, 5.0]


def test_the_buffer_returned_is_a_copy_and_the_data_is_not_kept_by_reference():
    ring = CircularBuffer(2, 1, "cpu")
    data = torch.zeros(1, 1)
    ring.append(data)
    data += 1.0
    ring.buffer.fill_(5.0)
    assert ring.buffer.flatten().tolist() == [0.0, 0.0]


def test_reading_goes_back_from_the_latest_and_no_further_than_the_oldest():
    ring = CircularBuffer(3, 3, "cpu")
    for step in range(2):
        ring.append(value(step))
    assert ring[torch.tensor([0, 1, 2])][:, 0].tolist() == [1.0, 0.0, 0.0]


def test_any_shape_and_type_of_data_is_kept():
    ring = CircularBuffer(2, 3, "cpu")
    ring.append(torch.ones(3, dtype=torch.long))
    assert ring.buffer.dtype == torch.long
    images = CircularBuffer(2, 3, "cpu")
    images.append(torch.ones(3, 4, 5))
    images.reset([0])
    images.append(torch.zeros(3, 4, 5))
    assert images.buffer.shape == (3, 2, 4, 5)
    assert images.buffer[:, 0].mean(dim=(1, 2)).tolist() == [0.0, 1.0, 1.0]


def test_misuse_of_the_ring_is_refused():
    with pytest.raises(ValueError, match="at least 1"):
        CircularBuffer(0, 3, "cpu")
    ring = CircularBuffer(2, 3, "cpu")
    with pytest.raises(RuntimeError, match="nothing was appended"):
        _ = ring.buffer
    with pytest.raises(ValueError, match="batch of 3, got 2"):
        ring.append(torch.zeros(2, 1))
    with pytest.raises(RuntimeError, match="empty"):
        _ = ring[torch.zeros(3)]
    ring.append(torch.zeros(3, 1))
    ring.reset([1])
    with pytest.raises(RuntimeError, match="empty"):
        _ = ring[torch.zeros(3)]
    with pytest.raises(ValueError, match="3 keys, got 2"):
        _ = ring[torch.zeros(2)]


def test_a_delay_line_returns_the_value_of_some_steps_ago():
    delay = DelayBuffer(2, 3, "cpu")
    assert delay.compute(value(0))[:, 0].tolist() == [0.0] * 3
    delay.set_time_lag(torch.tensor([0, 1, 2]))
    assert (delay.min_time_lag, delay.max_time_lag) == (0, 2)
    for step in range(1, 4):
        out = delay.compute(value(step))
    assert out[:, 0].tolist() == [3.0, 2.0, 1.0]


def test_a_delay_line_has_only_its_oldest_value_after_a_reset():
    delay = DelayBuffer(2, 2, "cpu")
    delay.set_time_lag(2)
    for step in range(4):
        delay.compute(value(step, 2))
    delay.reset([0])
    assert delay.compute(value(4, 2))[:, 0].tolist() == [4.0, 2.0]
    assert delay.compute(value(5, 2))[:, 0].tolist() == [4.0, 3.0]


def test_a_lag_may_be_set_for_some_environments():
    delay = DelayBuffer(3, 3, "cpu")
    delay.set_time_lag(3, [1])
    delay.set_time_lag(torch.tensor([1, 2]), torch.tensor([0, 2]))
    assert delay.time_lags.tolist() == [1, 3, 2]


def test_a_lag_that_cannot_be_kept_is_refused_and_changes_nothing():
    delay = DelayBuffer(1, 2, "cpu")
    for lag in (-1, 2, torch.tensor([0, 2])):
        with pytest.raises(ValueError, match="between 0 and the history length 1"):
            delay.set_time_lag(lag)
    for lag in (1.0, torch.tensor([1.0, 0.0])):
        with pytest.raises(TypeError, match="time_lag must be"):
            delay.set_time_lag(lag)  # type: ignore[arg-type]
    assert delay.time_lags.tolist() == [0, 0]


def test_a_timestamped_buffer_is_empty_at_first():
    buffer = TimestampedBuffer()
    assert buffer.data is None
    assert buffer.timestamp == -1.0


def test_interpolation_is_linear_between_samples_and_constant_beyond():
    function = LinearInterpolation(torch.tensor([0.0, 1.0, 3.0]), torch.tensor([0.0, 10.0, 0.0]), "cpu")
    q = torch.tensor([[-1.0, 0.0, 0.5], [1.0, 2.0, 4.0]])
    assert function.compute(q).tolist() == [[0.0, 0.0, 5.0], [10.0, 5.0, 0.0]]


def test_a_step_in_the_samples_is_kept():
    function = LinearInterpolation(torch.tensor([0.0, 1.0, 1.0, 2.0]), torch.tensor([0.0, 0.0, 5.0, 5.0]), "cpu")
    assert function.compute(torch.tensor([0.5, 1.5])).tolist() == [0.0, 5.0]


@pytest.mark.parametrize(
    ("x", "y", "message"),
    [([], [], "no samples"), ([0.0, 1.0], [0.0], "2 samples of x but 1 of y"), ([1.0, 0.0], [0.0, 0.0], "must ascend")],
)
def test_samples_without_sense_are_refused(x, y, message):
    with pytest.raises(ValueError, match=message):
        LinearInterpolation(torch.tensor(x), torch.tensor(y), "cpu")
