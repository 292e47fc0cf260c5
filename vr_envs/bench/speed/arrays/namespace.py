"""What an environment written for whole arrays needs of NumPy or of JAX.

A state is a dict of arrays whose last axis counts the rows. An environment is written once, against `Arrays.xp`. What
concerns few rows in a step (the end of an episode) is done by `Arrays.where`: in NumPy for those rows alone; in JAX,
whose shapes are fixed, for all rows, and not at all in a step where it concerns none.
"""

from __future__ import annotations

import functools
import math
import os
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

State = dict[str, Any]
_GAMMA = 0x9E3779B97F4A7C15
_MASK = (1 << 64) - 1
_NEXT_EPISODE = 1 << 60  # counter of the draw that becomes the next episode's key


class Arrays(NamedTuple):
    """A namespace of array functions.

    `where(mask, state, change)`: the state with `change(part of a state)` in the rows of the mask.
    `compiled(function)`: `function(state, actions)` as fast as the library makes it, its results ready when it returns.
    """

    name: str
    xp: Any
    where: Callable[[Any, State, Callable[[State], State]], State]
    compiled: Callable[[Callable[..., Any]], Callable[..., Any]]


def _where_numpy(mask: np.ndarray, state: State, change: Callable[[State], State]) -> State:
    rows = np.flatnonzero(mask)
    if rows.size:
        for name, values in change({name: values[..., rows] for name, values in state.items()}).items():
            state[name][..., rows] = values
    return state


NUMPY = Arrays("NumPy", np, _where_numpy, lambda function: function)


@functools.cache
def jax_arrays() -> Arrays:
    """JAX on the CPU in float64, compiled (`jax.jit`), in one thread, the state's memory given back to it."""
    os.environ["NPROC"] = "1"  # its pool of threads; more are no faster here, and take half as much CPU time again
    import jax  # pyright: ignore[reportMissingImports] (an extra of its own)

    jax.config.update("jax_enable_x64", True)  # before anything is made

    def where(mask: Any, state: State, change: Callable[[State], State]) -> State:
        def some(state: State) -> State:
            changed = change(state)
            return {name: jax.numpy.where(mask, changed[name], state[name]) for name in state}

        return jax.lax.cond(mask.any(), some, lambda state: state, state)

    def compiled(function: Callable[..., Any]) -> Callable[..., Any]:
        fast = jax.jit(function, donate_argnums=0)
        return lambda *arguments: jax.block_until_ready(fast(*arguments))

    return Arrays("JAX", jax.numpy, where, compiled)


def bits(xp: Any, key: Any, counter: Any) -> Any:
    """64 random bits of SplitMix64 (Steele, Lea, Flood 2014): draw number `counter` of the sequence of each key."""
    if isinstance(counter, int):
        step = np.uint64((counter + 1) * _GAMMA & _MASK)
    else:
        step = (counter.astype(xp.uint64) + np.uint64(1)) * np.uint64(_GAMMA)
    z = key + step
    z = (z ^ (z >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    z = (z ^ (z >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return z ^ (z >> np.uint64(31))


def uniform(xp: Any, key: Any, counter: Any) -> Any:
    """Uniform in the open interval (0, 1)."""
    return ((bits(xp, key, counter) >> np.uint64(12)).astype(xp.float64) + 0.5) * 2.0**-52


def normal_pair(xp: Any, key: Any, counter: Any) -> tuple[Any, Any]:
    """Two independent standard normal numbers (Box and Muller), of the draws 2 counter and 2 counter + 1."""
    radius = xp.sqrt(-2.0 * xp.log(uniform(xp, key, 2 * counter)))
    angle = 2.0 * math.pi * uniform(xp, key, 2 * counter + 1)
    return radius * xp.cos(angle), radius * xp.sin(angle)


def next_key(xp: Any, key: Any) -> Any:
    """The key of the episode after that of `key`."""
    return bits(xp, key, _NEXT_EPISODE)
