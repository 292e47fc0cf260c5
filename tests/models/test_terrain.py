import math

import numpy as np
import pytest

from vr_envs.models.record import dtype_of, pack
from vr_envs.models.terrain import WAVES, Undulation, roll_undulation, start_undulation, undulation_ahead, wave
from vr_envs.models.terrain_ride import State


def test_rolling_over_sines():
    record = pack(Undulation())
    state = np.zeros(1, dtype_of(State))[0]
    state["key"] = 1
    start_undulation(state)
    phases = np.arctan2(state["wave_sin"], state["wave_cos"])
    for step in range(1, 1001):
        roll_undulation(state, 0.2, record)
        if step % 250 == 0:
            terms = [wave(i, record) for i in range(WAVES)]
            expected = sum(a * math.sin(k * (0.2 * step + 1.7) + p) for (a, k), p in zip(terms, phases, strict=True))
            assert undulation_ahead(state, 1.7, record) == pytest.approx(expected, abs=1e-14)
    assert wave(0, record) == pytest.approx((0.04, 2 * math.pi / 40))
