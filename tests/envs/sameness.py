"""The registered ids, and what it means that two of their results are the same."""

import gymnasium as gym
import numpy as np

import vr_envs  # noqa: F401

IDS = sorted(id for id in gym.registry if id.startswith("vr_envs/"))


def same(a, b):
    """The same dtype, shape and bytes, through nested dicts and object arrays."""
    assert type(a) is type(b), (type(a), type(b))
    if isinstance(a, list | tuple):
        for left, right in zip(a, b, strict=True):
            same(left, right)
    elif isinstance(a, dict):
        assert a.keys() == b.keys(), (a.keys(), b.keys())
        for key in a:
            same(a[key], b[key])
    elif isinstance(a, np.ndarray):
        assert (a.dtype, a.shape) == (b.dtype, b.shape)
        if a.dtype == object:
            for left, right in zip(a, b, strict=True):
                same(left, right)
        else:
            assert a.tobytes() == b.tobytes()
    else:
        assert a == b
