"""The ride in lockstep gives the bytes of the ride row by row, whatever the rows are up to."""

import numpy as np
import pytest

from tests.envs.lockstep import both_ways, step_both
from vr_envs.envs.storage import Plain
from vr_envs.envs.terrain_ride import TerrainRideBatchEnv

ROWS, STEPS, LIMIT = 43, 300, 110  # not whole blocks; every row starts afresh at least twice


@pytest.mark.parametrize("scene", ["lecture", "road"])
def test_lockstep_gives_the_same_bytes(scene):
    pair = both_ways(TerrainRideBatchEnv, scene, ROWS, LIMIT)
    for env in pair:
        env.reset(seed=3)
    states = pair[0].get_state()
    states["time_to_tick"][5], states["tick_velocity"][5] = 0.004, 0.1  # never at a tick again, until its end
    states["steps"][[9, 20]] = 37, 90  # out of step with their neighbours
    states["travel"][[14, 30]] = 0.079, -0.0799
    states["velocity"][[14, 30]] = 0.9, -0.9
    for env in pair:
        env.set_state(states)
    rng = np.random.default_rng(0)
    touches, between = 0, 0
    for k in range(STEPS):
        actions = rng.uniform(-1.0, 1.0, (ROWS, 2))
        if k % 50 == 0:
            actions = np.sign(actions)
        after = step_both(pair, actions)
        touches, between = touches + after["touches"].sum(), between + (after["time_to_tick"] > 0.0).sum()
    assert len(np.unique(after["steps"])) > 2 and between > 50
    assert touches > 0 or scene == "lecture"


def test_what_cannot_go_in_lockstep_goes_row_by_row():
    for scene in ("quarter-car", "journey", {"undulation": True, "stop": None}, {"obstacle": True}):
        assert isinstance(TerrainRideBatchEnv(ROWS, scene).world.storage, Plain)
