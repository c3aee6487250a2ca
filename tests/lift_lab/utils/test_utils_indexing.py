"""Filling rows of buffers."""

import pytest
import torch

from lift_lab.utils.indexing import fill_rows


@pytest.mark.parametrize("rows", [torch.tensor([2, 0]), [0, 2], slice(0, 3, 2)])
def test_rows_are_filled_however_they_are_named(rows):
    buffer = torch.ones(4, 2)
    fill_rows(buffer, rows, 0.0)
    assert buffer.tolist() == [[0.0, 0.0], [1.0, 1.0], [0.0, 0.0], [1.0, 1.0]]


@pytest.mark.parametrize("rows", [torch.tensor([2, 0]), [0, 2], slice(0, 3, 2)])
def test_rows_may_be_another_dimension_than_the_first(rows):
    buffer = torch.ones(2, 4)
    fill_rows(buffer, rows, 0.0, dim=1)
    assert buffer.tolist() == [[0.0, 1.0, 0.0, 1.0]] * 2


def test_no_rows_are_filled_where_none_are_named_and_all_where_nothing_is_said():
    flags = torch.zeros(3, dtype=torch.bool)
    fill_rows(flags, torch.tensor([], dtype=torch.long), True)
    assert not flags.any()
    fill_rows(flags, None, True)
    assert flags.all()
