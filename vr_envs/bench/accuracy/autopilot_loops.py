"""What else flies the aircraft: compiled loops of steps.

They share with the exact model what is not integrated, the limits of the rates and what an action commands, and have
the differential equations written out anew. All are restarted at every control instant, where the commands jump; some
also at the corners: the instants, known beforehand, from which the limit of a rate's change acts no longer.
"""

from __future__ import annotations

import math

from vr_envs.models.autopilot_limits import commanded_rates, renew_limits
from vr_envs.models.clock import equal_steps
from vr_envs.models.jit import kernel


@kernel
def _bend(rate, goal, slew, time_constant):
    """Rate of change of a rate that follows its command."""
    return min(slew, max(-slew, (goal - rate) / time_constant))


@kernel
def air_of(wind, shear):
    """What the air's motion is made of, with zeros for what there is not.

    The wind's velocity (x, z) [m/s], the gradient of the wind with the height [1/s], and the unit vector (x, z) against
    that.
    """
    x = z = gradient = east = north = 0.0
    if wind is not None:
        x, z = -wind.speed * math.sin(wind.origin), -wind.speed * math.cos(wind.origin)
    if shear is not None:
        gradient, east, north = shear.gradient, math.sin(shear.origin), math.cos(shear.origin)
    return x, z, gradient, east, north


@kernel
def bends(y, goals, slews, lags):
    """Time derivatives of the three rates, which follow what they are commanded to be."""
    return (
        _bend(y[0], goals[0], slews[0], lags.vertical),
        _bend(y[1], goals[1], slews[1], lags.along),
        _bend(y[2], goals[2], slews[2], lags.turn),
    )


@kernel
def gain_of(rates, sine, cosine, shear, air):
    """Time derivative of the airspeed, from sine and cosine of the heading."""
    gain = rates[1]
    if shear is not None:
        gain += air[2] * rates[0] * (cosine * air[4] + sine * air[3])
    return gain


@kernel
def course_of(altitude, speed, sine, cosine, wind, shear, air):
    """Time derivatives of x and z, from sine and cosine of the heading."""
    x, z = speed * sine, speed * cosine
    if wind is not None:
        x, z = x + air[0], z + air[1]
    if shear is not None:
        lost = air[2] * altitude
        x, z = x - lost * air[3], z - lost * air[4]
    return x, z


@kernel
def slopes(y, goals, slews, lags, wind, shear, air):
    """Time derivatives of y: climb rate, acceleration, turn rate, altitude, airspeed, heading, x, z.

    `goals`: what the three rates are commanded to be; `slews`: the largest changes of them per second; `air`: as
    `air_of` gives it.
    """
    first = second = third = 0.0
    if lags is not None:
        first, second, third = bends(y, goals, slews, lags)
    sine, cosine = math.sin(y[5]), math.cos(y[5])
    x, z = course_of(y[3], y[4], sine, cosine, wind, shear, air)
    return first, second, third, y[0], gain_of(y, sine, cosine, shear, air), y[2], x, z


@kernel
def _moved(y, h, k, lags):
    """y + h k; the rates change with lags only."""
    rates = y[0], y[1], y[2]
    if lags is not None:
        rates = y[0] + h * k[0], y[1] + h * k[1], y[2] + h * k[2]
    return (
        *rates, y[3] + h * k[3], y[4] + h * k[4], y[5] + h * k[5], y[6] + h * k[6], y[7] + h * k[7],
    )  # fmt: skip


@kernel
def euler(y, h, goals, slews, lags, wind, shear, air):
    """One step of the semi-implicit Euler rule: the new rates move what they are the rates of."""
    rates = y[0], y[1], y[2]
    if lags is not None:
        k = bends(y, goals, slews, lags)
        rates = y[0] + h * k[0], y[1] + h * k[1], y[2] + h * k[2]
    gain = rates[1]
    if shear is not None:
        gain = gain_of(rates, math.sin(y[5]), math.cos(y[5]), shear, air)
    ahead = (*rates, y[3] + h * rates[0], y[4] + h * gain, y[5] + h * rates[2])
    x, z = course_of(ahead[3], ahead[4], math.sin(ahead[5]), math.cos(ahead[5]), wind, shear, air)
    return (*ahead, y[6] + h * x, y[7] + h * z)


@kernel
def runge_kutta(y, h, goals, slews, lags, wind, shear, air):
    """One step of the classical Runge-Kutta rule of order 4."""
    a = slopes(y, goals, slews, lags, wind, shear, air)
    b = slopes(_moved(y, 0.5 * h, a, lags), goals, slews, lags, wind, shear, air)
    c = slopes(_moved(y, 0.5 * h, b, lags), goals, slews, lags, wind, shear, air)
    d = slopes(_moved(y, h, c, lags), goals, slews, lags, wind, shear, air)
    y = _moved(_moved(y, h / 6.0, a, lags), h / 3.0, b, lags)
    return _moved(_moved(y, h / 3.0, c, lags), h / 6.0, d, lags)


@kernel
def corner_times(y, goals, slews, lags):
    """When the limits of the three rates' changes cease to act [s]; not positive where they do not."""
    if lags is None:
        return 0.0, 0.0, 0.0
    return (
        abs(goals[0] - y[0]) / slews[0] - lags.vertical,
        abs(goals[1] - y[1]) / slews[1] - lags.along,
        abs(goals[2] - y[2]) / slews[2] - lags.turn,
    )


@kernel
def commands(state, action, params, envelope, energy, lags):
    """What is held over an interval: the rates commanded, and the largest changes of the rates per second."""
    renew_limits(state, params, envelope, energy)
    vertical_speed, acceleration, turn_rate, turn = commanded_rates(state, action, params, envelope, energy)
    if lags is None:
        return (vertical_speed, acceleration, turn_rate), (0.0, 0.0, 0.0)
    return (vertical_speed, acceleration, turn_rate), (lags.vertical_slew, lags.jerk, turn / lags.roll_in)


@kernel
def state_of(state, goals, lags):
    """y of a record: as `slopes` has it."""
    rates = state.vertical_speed, state.acceleration, state.turn_rate
    if lags is None:
        rates = goals
    return (*rates, state.altitude, state.speed, state.heading, state.x, state.z)


@kernel
def write_state(state, y):
    """Put y into a record."""
    state.vertical_speed, state.acceleration, state.turn_rate = y[0], y[1], y[2]
    state.altitude, state.speed, state.heading, state.x, state.z = y[3], y[4], y[5], y[6], y[7]


@kernel
def advance_in_steps(state, action, params, envelope, energy, lags, wind, shear, order, step, located):
    """Move a state over a control interval in equal steps of at most `step` [s], from corner to corner if `located`.

    `order`: 1 is Euler's rule, else that of Runge and Kutta.
    """
    goals, slews = commands(state, action, params, envelope, energy, lags)
    y, air = state_of(state, goals, lags), air_of(wind, shear)
    begin, corners = 0.0, corner_times(y, goals, slews, lags)
    while begin < params.dt:
        end = params.dt
        if located:
            for corner in corners:
                if begin < corner < end:
                    end = corner
        steps = equal_steps(end - begin, step)
        h = (end - begin) / steps
        if order == 1:
            for _ in range(steps):
                y = euler(y, h, goals, slews, lags, wind, shear, air)
        else:
            for _ in range(steps):
                y = runge_kutta(y, h, goals, slews, lags, wind, shear, air)
        begin = end
    write_state(state, y)
