"""Works in processes of their own: results in order, and a failure that names its work."""

import pytest

from vr_envs.bench.ahead import side_by_side


def test_results_come_in_the_order_of_the_works():
    assert side_by_side(abs, [-3, 2, -1]) == [3, 2, 1]
    assert side_by_side(abs, []) == []


def test_a_work_that_fails_is_named():
    with pytest.raises(RuntimeError, match="seven: ValueError"):
        side_by_side(int, ["1", "seven", "2"])
