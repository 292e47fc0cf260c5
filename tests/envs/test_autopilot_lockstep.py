"""The aircraft in lockstep gives the bytes of the aircraft row by row, whatever the rows are up to."""

import numpy as np
import pytest

from tests.envs.lockstep import both_ways, step_both
from vr_envs.envs.autopilot import AutopilotBatchEnv
from vr_envs.envs.storage import Plain

ROWS, STEPS, LIMIT = 43, 260, 150  # not whole blocks; every row starts afresh at least once


@pytest.mark.parametrize("scene", [{"base": "lecture", "stall_speed": 0.0}, {"base": "airliner", "stall_speed": 0.0}])
def test_lockstep_gives_the_same_bytes(scene):
    pair = both_ways(AutopilotBatchEnv, scene, ROWS, LIMIT)
    for env in pair:
        env.reset(seed=3)
    states = pair[0].get_state()
    states["time_to_refresh"][5] = 0.4  # never renewed at its control instants again, until its end
    states["steps"][[9, 20]] = 37, 90  # out of step with their neighbours
    states["speed"][[12, 30]] = 2.0, 0.0  # about to stand; standing
    states["altitude"][[13, 31]] = 40.0, 250.0  # in low turbulence
    states["turn_rate"][[14, 32]] = 1.9, -1.2  # half turns beyond the series
    for env in pair:
        env.set_state(states)
    rng = np.random.default_rng(0)
    odd, standing, lost, legs = 0, 0, 0, 0
    for k in range(STEPS):
        actions = rng.uniform(-1.0, 1.0, (ROWS, 3))
        if k % 40 == 0:
            actions = np.sign(actions)
        actions[12], actions[13] = (0.0, -1.0, 0.2), (-1.0, 0.0, 0.0)
        after = step_both(pair, actions)
        odd, standing = odd + (after["time_to_refresh"] > 0.0).sum(), standing + (after["speed"] == 0.0).sum()
        lost, legs = lost + after["lost"].sum(), max(legs, after["legs"].max())
    assert len(np.unique(after["steps"])) > 2 and standing > 3 and lost > 0 and legs > 1
    assert odd > 50 or scene["base"] == "lecture"  # which has nothing to renew


def test_rows_that_do_not_run_stay_as_they_are():
    pair = both_ways(AutopilotBatchEnv, "airliner", ROWS, None)
    for env in pair:
        env.reset(seed=4)
    rng = np.random.default_rng(1)
    live = rng.random(ROWS) < 0.6
    live[8:16], live[16:24] = False, True
    for k in range(150):  # long enough for new demands
        before = pair[0].get_state()
        actions = rng.uniform(-0.3, 0.3, (ROWS, 3))
        one, other = (env.world.step(actions, live, 100) for env in pair)
        for left, right in zip(one[1:], other[1:], strict=True):
            assert left.tobytes() == right.tobytes() and not left[~live].any()
        assert one.obs[live].tobytes() == other.obs[live].tobytes()
        after = pair[0].get_state()
        assert after.tobytes() == pair[1].get_state().tobytes()
        assert after[~live].tobytes() == before[~live].tobytes() and (after["steps"][live] == k + 1).all()


def test_what_cannot_go_in_lockstep_goes_row_by_row():
    for scene in ("airliner-rough", {"shear": True}, {"track": True}, {"base": "lecture", "sensing": True}):
        assert isinstance(AutopilotBatchEnv(ROWS, scene).world.storage, Plain)
    assert isinstance(AutopilotBatchEnv(8).world.storage, Plain)
