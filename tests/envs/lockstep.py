"""The same batch in lockstep and row by row."""

from vr_envs.envs.rows import rows_of
from vr_envs.envs.storage import Blocks, Plain


def both_ways(cls, scene, rows, limit):
    """Two batches of a class in a scene, the first in lockstep, the second row by row."""
    pair = [cls(rows, scene, max_episode_steps=limit) for _ in range(2)]
    world = pair[1].world
    assert isinstance(world.storage, Blocks)
    world.rows, world.storage = rows_of(cls.task), Plain(world.storage.dtype, rows)
    return pair


def step_both(pair, actions):
    """Step both; every result and every record has to have the same bytes. Returns the records."""
    one, other = (env.step(actions) for env in pair)
    for left, right in zip(one[:4], other[:4], strict=True):
        assert left.tobytes() == right.tobytes()
    after = pair[0].get_state()
    assert after.tobytes() == pair[1].get_state().tobytes()
    return after
