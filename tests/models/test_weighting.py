import numpy as np
import pytest

from vr_envs.models.weighting import INTERVAL, MEMORY, sampled_wk, weight, wk

# ISO 8041: magnitude of Wk at third-octave frequencies [Hz]
TABLE = {
    0.5: 0.4182, 1.0: 0.4825, 2.0: 0.5314, 4.0: 0.9672, 5.0: 1.0388, 6.3: 1.0544, 8.0: 1.0364, 10.0: 0.9884,
    15.915: 0.7718, 16.0: 0.7687, 31.5: 0.4048, 80.0: 0.1324,
}  # fmt: skip


def test_wk_is_the_table_of_the_standard():
    assert np.abs(wk(np.array(list(TABLE)))) == pytest.approx(list(TABLE.values()), abs=5e-5)


def test_wk_is_the_product_of_its_parts_and_real_in_time():
    """High-pass, low-pass, transition and step as ISO 8041 writes them; the step's gain at low frequency is not 1."""
    f = np.geomspace(0.01, 1000, 200)
    s, (w1, w2, w3, w4, w5, w6) = 2j * np.pi * f, 2 * np.pi * np.array([0.4, 100, 12.5, 12.5, 2.37, 3.35])
    high = 1 / (1 + np.sqrt(2) * w1 / s + (w1 / s) ** 2)
    low = 1 / (1 + np.sqrt(2) * s / w2 + (s / w2) ** 2)
    transition = (1 + s / w3) / (1 + s / (0.63 * w4) + (s / w4) ** 2)
    step = (1 + s / (0.91 * w5) + (s / w5) ** 2) / (1 + s / (0.91 * w6) + (s / w6) ** 2) * (w5 / w6) ** 2
    assert wk(f) == pytest.approx(high * low * transition * step, rel=1e-13)
    assert wk(-f) == pytest.approx(np.conj(wk(f)), rel=1e-13)
    assert float(np.abs(step[0])) == pytest.approx((2.37 / 3.35) ** 2, rel=1e-4)


def impulse_response(n):
    memory = np.zeros(MEMORY)
    return np.array([weight(memory, float(k == 0)) for k in range(n)])


def test_response_of_the_filter_is_that_of_its_impulse():
    n = 1 << 14
    f = np.fft.rfftfreq(n, INTERVAL)[1:]
    assert np.fft.rfft(impulse_response(n))[1:] == pytest.approx(sampled_wk(f), abs=1e-12)
    assert sampled_wk(f + 1 / INTERVAL) == pytest.approx(sampled_wk(f), rel=1e-9)


@pytest.mark.parametrize(("low", "high", "error"), [(0.02, 0.1, 5e-4), (0.1, 45.0, 0.01), (45.0, 50.0, 0.03)])
def test_averaging_and_filter_together_are_wk(low, high, error):
    f = np.linspace(low, high, 5000)
    magnitude = np.abs(sampled_wk(f)) * np.sinc(f * INTERVAL)
    assert np.abs(magnitude / np.abs(wk(f)) - 1).max() < error


@pytest.mark.parametrize("f", [0.5, 2.0, 5.0, 12.5, 25.0])
def test_rms_of_a_sine(f):
    """A sine's velocity, differenced once per interval, comes out with the rms that the standard gives."""
    t = np.arange(4001) * INTERVAL
    mean_acceleration = np.diff(-np.cos(2 * np.pi * f * t) / (2 * np.pi * f)) / INTERVAL
    memory = np.zeros(MEMORY)
    weighted = np.array([weight(memory, a) for a in mean_acceleration])
    assert np.sqrt(np.mean(weighted[2000:] ** 2)) == pytest.approx(abs(wk(f)) / np.sqrt(2), rel=0.01)


def test_constant_acceleration_is_not_felt():
    memory = np.zeros(MEMORY)
    assert abs([weight(memory, 1.0) for _ in range(4000)][-1]) < 1e-6
