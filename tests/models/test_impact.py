"""Contact laws: what an impact may never do, over random impacts."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from vr_envs.models.ball_options import Friction, Softening, Spin
from vr_envs.models.impact import collide, collide_rough, softened
from vr_envs.models.record import pack

speed = st.floats(-5.0, 5.0)
approach = st.floats(-5.0, -1e-9)
unit = st.floats(0.0, 1.0)
deviation = st.floats(-0.3, 0.3)
ratios = st.sampled_from([2 / 5, 2 / 3, 1 / 2, 0.0])


def energy(normal, tangent, surface_spin, inertia_ratio):
    """Twice the kinetic energy per mass in the bar's frame."""
    return normal**2 + tangent**2 + inertia_ratio * surface_spin**2


friction = st.none() | st.builds(Friction, st.floats(0.0, 3.0), unit)


def packed(option):
    return None if option is None else pack(option)


@given(approach, speed, speed, unit, unit, friction, deviation)
def test_loss_law_never_makes_energy_and_always_leaves(normal, tangent, surface_spin, restitution, loss, limit, angle):
    out = collide_rough(normal, tangent, surface_spin, restitution, loss, None, packed(limit), angle)
    assert energy(*out, 0.0) <= energy(normal, tangent, 0.0, 0.0) * (1 + 1e-14)
    assert out[0] >= 0.0
    assert out[2] == surface_spin


@given(approach, speed, speed, unit, ratios, friction, deviation)
def test_gripping_ball_never_makes_energy_and_always_leaves(normal, tangent, spin, restitution, ratio, limit, angle):
    out = collide_rough(normal, tangent, spin, restitution, 0.0, pack(Spin(inertia_ratio=ratio)), packed(limit), angle)
    assert energy(*out, ratio) <= energy(normal, tangent, spin, ratio) * (1 + 1e-14)
    assert out[0] >= 0.0


@given(approach, speed, speed, unit, ratios, friction)
def test_gripping_ball_keeps_angular_momentum_about_the_contact_and_stops_slipping(
    normal, tangent, spin, restitution, ratio, limit
):
    n, t, s = collide(normal, tangent, spin, restitution, 0.0, pack(Spin(inertia_ratio=ratio)), packed(limit))
    assert n == -restitution * normal
    assert t + ratio * s == pytest.approx(tangent + ratio * spin, abs=1e-14)
    regained = 0.0 if limit is None else limit.restitution
    impulse, largest = abs(t - tangent), math.inf if limit is None else limit.coefficient * (1 + restitution) * -normal
    assert impulse <= largest * (1 + 1e-13) + 1e-14
    if impulse < largest * (1 - 1e-12):
        assert t - s == pytest.approx(-regained * (tangent - spin), abs=1e-13)  # it grips
    else:
        assert (t - s) * (tangent - spin) >= -regained * (tangent - spin) ** 2 - 1e-12  # it slides, or just grips
    assert (t - tangent) * (tangent - spin) <= 0.0  # the impulse opposes the slip


@given(approach, st.floats(0.01, 10.0), st.floats(0.0, 1.0))
def test_softening_falls_with_the_speed_from_the_full_restitution(normal, speed, exponent):
    record = pack(Softening(speed, exponent))
    assert softened(0.8, -1e-300, record) == 0.8
    assert softened(0.8, normal, record) == pytest.approx(0.8 * (1 - normal / speed) ** -exponent, rel=1e-14)
    assert softened(0.8, 2 * normal, record) <= softened(0.8, normal, record)


def test_a_deviated_normal_reflects_like_a_turned_mirror():
    angle, speed_in = 0.1, np.array([-2.0, 0.7])
    normal, tangent, _ = collide_rough(*speed_in, 0.0, 1.0, 0.0, None, None, angle)
    axis = np.array([math.cos(angle), math.sin(angle)])
    mirror = speed_in - 2 * (speed_in @ axis) * axis
    assert (normal, tangent) == pytest.approx(tuple(mirror), abs=1e-15)
