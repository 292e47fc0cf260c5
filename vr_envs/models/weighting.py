"""Frequency weighting Wk of ISO 2631-1 (vertical vibration of a seated person): exact, and as a filter at 100 Hz.

`wk` is the standard's response, a product of four second-order parts with the corner frequencies that ISO 8041 gives.

The filter's input is the mean acceleration of each interval of `INTERVAL` seconds, as a velocity difference gives it.
The mean over an interval is itself a low-pass, sin(pi f T)/(pi f T), which the filter makes good: averaging and filter
together have the magnitude of Wk within 1 % from 0.1 to 45 Hz. From there to 50 Hz, the most that 100 Hz can tell, they
stay within 3 %, and what the acceleration has beyond that is taken for lower frequencies. The coefficients were found
by least squares on the logarithm of the magnitude, in the form that Wk has: high-pass of order 2, transition, upward
step.
"""

from __future__ import annotations

import numpy as np

from vr_envs.models.jit import kernel

INTERVAL = 0.01  # s
# Corner frequencies [Hz] and quality factors of Wk: band limits (Butterworth), transition, upward step.
_LOW, _HIGH = 0.4, 100.0
_TRANSITION, _TRANSITION_Q = 12.5, 0.63
_STEP_UP, _STEP_DOWN, _STEP_Q = 2.37, 3.35, 0.91

MEMORY = 6  # numbers that the filter remembers; zeros are a start from rest

# Denominators (1 + d1/z + d2/z^2) of the three sections; numerators (1 - 1/z)^2, (1 + n1/z + n2/z^2), gain (1 + n/z)
_HIGH_1, _HIGH_2 = -1.964392, 0.965014
_STEP_1, _STEP_2, _STEP_N1, _STEP_N2 = -1.749913, 0.789468, -1.828973, 0.849081
_TURN_1, _TURN_2, _TURN_N, _GAIN = -0.906529, 0.268114, -0.396527, 0.580787


def wk(frequency: np.ndarray | float) -> np.ndarray:
    """Complex response of Wk at `frequency` [Hz], any shape, positive; its magnitude is the standard's table."""
    jf = 1j * np.asarray(frequency, float)
    band = jf**2 / (jf**2 + np.sqrt(2.0) * _LOW * jf + _LOW**2) / (1.0 + np.sqrt(2.0) * jf / _HIGH + (jf / _HIGH) ** 2)
    transition = (1.0 + jf / _TRANSITION) / (1.0 + jf / (_TRANSITION_Q * _TRANSITION) + (jf / _TRANSITION) ** 2)
    step = (_STEP_UP**2 + _STEP_UP / _STEP_Q * jf + jf**2) / (_STEP_DOWN**2 + _STEP_DOWN / _STEP_Q * jf + jf**2)
    return band * transition * step


def sampled_wk(frequency: np.ndarray | float) -> np.ndarray:
    """Complex response of the filter alone at `frequency` [Hz], any shape; it repeats itself every 100 Hz."""
    back = np.exp(-2j * np.pi * np.asarray(frequency, float) * INTERVAL)
    high = (1.0 - back) ** 2 / (1.0 + _HIGH_1 * back + _HIGH_2 * back**2)
    step = (1.0 + _STEP_N1 * back + _STEP_N2 * back**2) / (1.0 + _STEP_1 * back + _STEP_2 * back**2)
    return _GAIN * high * step * (1.0 + _TURN_N * back) / (1.0 + _TURN_1 * back + _TURN_2 * back**2)


@kernel
def weight(memory, acceleration):
    """Weighted acceleration [m/s^2] after one more interval of mean `acceleration`; `memory` has `MEMORY` numbers."""
    high = acceleration + memory[0]
    memory[0] = memory[1] - 2.0 * acceleration - _HIGH_1 * high
    memory[1] = acceleration - _HIGH_2 * high
    step = high + memory[2]
    memory[2] = memory[3] + _STEP_N1 * high - _STEP_1 * step
    memory[3] = _STEP_N2 * high - _STEP_2 * step
    turn = step + memory[4]
    memory[4] = memory[5] + _TURN_N * step - _TURN_1 * turn
    memory[5] = -_TURN_2 * turn
    return _GAIN * turn
