"""First root of a smooth function, certified: no sampling, no missed root."""

from __future__ import annotations

import math

from vr_envs.models.jit import kernel

TIME_RESOLUTION = 1e-17  # s, about a unit in the last place of a base cycle's time
MAX_MARCH = 1000  # steps; the most seen over grazing launches is about 150
UNDECIDED = -1.0  # s, in place of a time: the search did not end


@kernel
def free_step(value, slope, curvature):
    """Largest step h over which value + slope h - curvature h^2 / 2 >= 0.

    With `curvature` >= max(-f''), f has no root within h of a point where f = value > 0 and f' = slope. Repeated
    steps converge to the first root from the left, quadratically where it is transversal.
    """
    root = math.sqrt(slope * slope + 2.0 * curvature * value)
    if slope > 0.0:
        return (slope + root) / curvature
    return 2.0 * value / (root - slope)  # the same number without cancellation


@kernel
def converged(time, step):
    """Whether a step (s) no longer moves `time` (s): the root has been reached to rounding."""
    return step < TIME_RESOLUTION or time + step == time


@kernel
def certified_step(value, slope, second, jerk, curvature):
    """A root-free step that uses f'' = `second` here and a bound `jerk` on its rate of change, if that goes further.

    Falling away (second < 0): -f'' <= -second + jerk h over the next h. With h the step that the present curvature
    alone would allow, the step for that bound is no longer than h, so it is certified; convergence is nearly cubic.
    Opening (second > 0): f >= value + slope h + second h^2/2 - jerk h^3/6, and f is convex up to second / jerk.
    """
    step = free_step(value, slope, curvature)
    if second < 0.0:
        local = jerk * free_step(value, slope, -second) - second
        if local < curvature:
            step = free_step(value, slope, local)
    elif slope >= 0.0:
        step = max(step, 1.5 / jerk * (second + math.sqrt(second * second + 8.0 / 3.0 * jerk * slope)))
    elif second > 0.0:
        step = max(step, min(second / jerk, -value / slope))
    return step
