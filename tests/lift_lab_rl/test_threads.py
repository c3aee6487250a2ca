"""Work on threads: every part is done once, and results come in order."""

import pytest

from lift_lab_rl.threads import WorkerPool, split_evenly


def test_spans_cover_everything_once():
    for total, size in ((1, 100), (6144, 1536), (1000, 300), (7, 2)):
        bounds = split_evenly(total, size)
        assert [k for first, last in bounds for k in range(first, last)] == list(range(total))


def test_a_pool_keeps_the_order_of_parts_and_passes_errors_on():
    pool = WorkerPool(3)
    assert pool.map(lambda k: k * k, 20) == [k * k for k in range(20)]

    def fail(k):
        if k == 5:
            raise RuntimeError("part 5")

    with pytest.raises(RuntimeError, match="part 5"):
        pool.map(fail, 20)
    pool.close()
