import numpy as np
import pytest

from vr_envs.models.weighting import INTERVAL, MEMORY, weight


def wk(f):
    """|Wk| of ISO 2631-1 from its analogue definition."""
    s, (w1, w2, w3, w4, w5, w6) = 2j * np.pi * f, 2 * np.pi * np.array([0.4, 100, 12.5, 12.5, 2.37, 3.35])
    high = 1 / (1 + np.sqrt(2) * w1 / s + (w1 / s) ** 2)
    low = 1 / (1 + np.sqrt(2) * s / w2 + (s / w2) ** 2)
    transition = (1 + s / w3) / (1 + s / (0.63 * w4) + (s / w4) ** 2)
    step = (1 + s / (0.91 * w5) + (s / w5) ** 2) / (1 + s / (0.91 * w6) + (s / w6) ** 2) * (w5 / w6) ** 2
    return abs(high * low * transition * step)


def test_reference_is_the_table_of_the_standard():
    f = np.array([0.5, 1, 2, 4, 8, 10, 16, 31.5])
    table = np.array([0.4182, 0.4825, 0.5314, 0.9672, 1.0364, 0.9884, 0.7687, 0.4048])
    assert np.allclose(wk(f), table, atol=6e-5)


def impulse_response(n):
    memory = np.zeros(MEMORY)
    return np.array([weight(memory, float(k == 0)) for k in range(n)])


def test_averaging_and_filter_together_are_wk():
    n = 1 << 14
    f = np.fft.rfftfreq(n, INTERVAL)
    band = (f > 0.1) & (f < 45)
    magnitude = abs(np.fft.rfft(impulse_response(n))) * np.sinc(f * INTERVAL)
    assert np.abs(magnitude[band] / wk(f[band]) - 1).max() < 0.01


@pytest.mark.parametrize("f", [0.5, 2.0, 5.0, 12.5, 25.0])
def test_rms_of_a_sine(f):
    """A sine's velocity, differenced once per interval, comes out with the rms that the standard gives."""
    t = np.arange(4001) * INTERVAL
    mean_acceleration = np.diff(-np.cos(2 * np.pi * f * t) / (2 * np.pi * f)) / INTERVAL
    memory = np.zeros(MEMORY)
    weighted = np.array([weight(memory, a) for a in mean_acceleration])
    assert np.sqrt(np.mean(weighted[2000:] ** 2)) == pytest.approx(wk(f) / np.sqrt(2), rel=0.01)


def test_constant_acceleration_is_not_felt():
    memory = np.zeros(MEMORY)
    assert abs([weight(memory, 1.0) for _ in range(4000)][-1]) < 1e-6
