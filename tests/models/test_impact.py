"""Contact laws: what an impact may never do, over random impacts."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from vr_envs.models.ball_on_bar import Spin
from vr_envs.models.impact import collide, collide_rough
from vr_envs.models.record import pack

speed = st.floats(-5.0, 5.0)
approach = st.floats(-5.0, -1e-9)
unit = st.floats(0.0, 1.0)
deviation = st.floats(-0.3, 0.3)


def energy(normal, tangent, surface_spin, inertia_ratio):
    """Twice the kinetic energy per mass in the bar's frame."""
    return normal**2 + tangent**2 + inertia_ratio * surface_spin**2


@given(approach, speed, speed, unit, unit, deviation)
def test_loss_law_never_makes_energy_and_always_leaves(normal, tangent, surface_spin, restitution, loss, angle):
    out = collide_rough(normal, tangent, surface_spin, restitution, loss, None, angle)
    assert energy(*out, 0.0) <= energy(normal, tangent, 0.0, 0.0) * (1 + 1e-14)
    assert out[0] >= 0.0
    assert out[2] == surface_spin


@given(approach, speed, speed, unit, st.sampled_from([2 / 5, 2 / 3, 1 / 2, 0.0]), deviation)
def test_gripping_ball_never_makes_energy_and_always_leaves(normal, tangent, spin, restitution, ratio, angle):
    out = collide_rough(normal, tangent, spin, restitution, 0.0, pack(Spin(inertia_ratio=ratio)), angle)
    assert energy(*out, ratio) <= energy(normal, tangent, spin, ratio) * (1 + 1e-14)
    assert out[0] >= 0.0


@given(approach, speed, speed, unit, st.sampled_from([2 / 5, 2 / 3, 1 / 2]))
def test_gripping_ball_keeps_angular_momentum_about_the_contact_and_stops_slipping(
    normal, tangent, spin, restitution, ratio
):
    n, t, s = collide(normal, tangent, spin, restitution, 0.0, pack(Spin(inertia_ratio=ratio)))
    assert n == -restitution * normal
    assert t + ratio * s == pytest.approx(tangent + ratio * spin, abs=1e-14)
    assert t - s == pytest.approx(0.0, abs=1e-14)


def test_a_deviated_normal_reflects_like_a_turned_mirror():
    angle, speed_in = 0.1, np.array([-2.0, 0.7])
    normal, tangent, _ = collide_rough(*speed_in, 0.0, 1.0, 0.0, None, angle)
    axis = np.array([math.cos(angle), math.sin(angle)])
    mirror = speed_in - 2 * (speed_in @ axis) * axis
    assert (normal, tangent) == pytest.approx(tuple(mirror), abs=1e-15)
