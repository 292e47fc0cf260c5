"""The lecture's recurrence for a spring on a wheel over terrain (3.89, 3.90), step by step, as it stands in the slides.

The lecture measures y downwards from the support; with m the mass, l the spring's natural length, lambda its modulus
and dt the step,

    y' = y + v dt,    e = y' - l + h,    a = g - lambda e / (l m),    v' = k_d v + a dt.

Here heights are up and taken from the levelled equilibrium, where lambda e / l = m g: zeta = y_eq - y and
w2 = lambda / (l m), so  zeta' = zeta + v dt,  a = push - w2 (zeta' - h),  v' = k_d v + a dt,  k_d = e^(-gamma dt).
In the slides h is "extra spring compression", got from the terrain's heights at t + dt and t. Two readings:

- A: h is the height of the ground since the start. The recurrence is then of first order in dt towards the motion of
  `terrain_ride` with absolute damping.
- B: h is the change of that height in this step, and is gone in the next. The push of the ground then is of the order
  of dt: the smaller the step, the less the mass feels of the road.

A step is stable where w dt < sqrt(2 (1 + k_d)), w = sqrt(w2).
"""

from __future__ import annotations

import math

from vr_envs.models.clock import equal_steps
from vr_envs.models.jit import kernel
from vr_envs.models.road import pass_knot, slope_of_road
from vr_envs.models.terrain import roll_undulation, undulation_ahead


@kernel
def roll(state, distance, undulation, road, profile, bumps, obstacle, wheel):
    """Move the wheel ahead by `distance` [m]; how much higher it stands then [m]."""
    rise = 0.0
    if undulation is not None:
        rise -= undulation_ahead(state, 0.0, undulation)
        roll_undulation(state, distance, undulation)
        rise += undulation_ahead(state, 0.0, undulation)
    if road is not None:
        left = distance
        while left >= state.to_knot:
            rise += slope_of_road(state, road) * state.to_knot
            left -= state.to_knot
            pass_knot(state, True, road, profile, bumps, obstacle, wheel)
        rise += slope_of_road(state, road) * left
        state.to_knot -= left
    return rise


@kernel
def drift(state, t, params, undulation, road, profile, bumps, obstacle, wheel):
    """Move the mass with its velocity over the time t [s], a step or a part of one; the rise of the ground in it."""
    rise = roll(state, params.speed * t, undulation, road, profile, bumps, obstacle, wheel)
    state.travel += state.velocity * t - rise
    state.climb += rise
    state.distance += params.speed * t
    return rise


@kernel
def kick(state, step, rise, gamma, w2, push, textbook):
    """Give the mass its new velocity at the end of a `step` [s] in which the ground rose by `rise` [m]."""
    stretch = state.travel + textbook.increments * (state.climb - rise)
    state.velocity = math.exp(-gamma * step) * state.velocity + (push - w2 * stretch) * step


@kernel
def step_of(params, textbook):
    """The step [s]: the control interval is a whole number of equal ones."""
    return params.dt / equal_steps(params.dt, textbook.step)
