import itertools

import numpy as np
import pytest

from vr_envs.bench.speed import native as speed
from vr_envs.envs.ball_on_bar import BallOnBarBatchEnv


def test_rate_is_rows_times_calls_per_second_of_the_clock(toy, monkeypatch):
    # a clock that goes on by one second each time it is read: every timing lasts 1 s, for one call of step
    monkeypatch.setattr(speed.time, "process_time", itertools.count(0.0, 1.0).__next__)
    found = speed.measure(toy, 7, repeats=3, seconds=1.0)
    assert (found.env_id, found.actions, found.rows, found.repeats) == (toy, "full range", 7, 3)
    assert found.minimum == found.median == found.maximum == 7.0


def test_real_clock_gives_ordered_rates_for_every_pair(toy):
    found = speed.compare([toy], [1, 16], repeats=2)
    kinds = [(s.env_id, s.actions, s.rows) for s in found]
    assert kinds == [(toy, actions, rows) for actions in ("full range", "small") for rows in (1, 16)]
    assert all(s.impacts_per_step is None for s in found)
    assert all(0.0 < s.minimum <= s.median <= s.maximum for s in found)


@pytest.mark.parametrize(("rows", "repeats"), [(0, 1), (1, 0)])
def test_nothing_to_measure_is_refused(toy, rows, repeats):
    with pytest.raises(ValueError, match="at least 1"):
        speed.measure(toy, rows, repeats=repeats)


def test_unknown_actions_are_refused(toy):
    with pytest.raises(ValueError, match="full range, small"):
        speed.measure(toy, 1, "none")


@pytest.mark.parametrize(("actions", "size"), [("full range", 1.0), ("small", 0.1)])
def test_actions_fill_their_range(actions, size):
    drawn = speed.draw(actions, 100, 6)
    assert drawn.shape == (speed.ACTION_SETS, 100, 6) and drawn.dtype == np.float32
    assert 0.99 * size < drawn.max() <= np.float32(size) and 0.99 * size < -drawn.min() <= np.float32(size)
    assert np.abs(drawn).mean() == pytest.approx(0.5 * size, rel=0.02)


@pytest.mark.parametrize("rows", [1, 8])
def test_impacts_are_counted_over_all_episodes(rows):
    """Against the growth of the counter in the records, step by step; the limit makes episodes end in between."""
    actions = speed.draw("small", rows, 6)
    env, twin = (BallOnBarBatchEnv(rows, max_episode_steps=30) for _ in range(2))
    found = speed.impacts_per_step(env, actions, 75)
    twin.reset(seed=0)
    impacts = steps = 0
    for k in range(75):
        before = twin.get_state()
        twin.step(actions[k % len(actions)])
        after = twin.get_state()
        moved = after["steps"] > before["steps"]
        impacts += (after["impacts"] - before["impacts"])[moved].sum()
        steps += moved.sum()
    assert steps < 75 * rows
    assert found == pytest.approx(impacts / steps, rel=1e-13)
