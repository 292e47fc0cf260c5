"""The path of the centre of a wheel of finite radius: the upper envelope of circles about the profile.

A rigid disc of radius R that stands on the ground r(x), without overlap, has its centre at the height

    c(x) = max over |s| < R of  r(x + s) + sqrt(R^2 - s^2),

which is r + R on level ground; heights here are c - R. On a straight piece of slope p the maximum is where the circle
touches it, s = R p / sqrt(1 + p^2), or else at an end. The path is exact at the knots and straight between them by
definition; of an arc about an edge that leaves out h^2 / (8 R) at most, with h between the knots (1 mm for 0.05 m and
0.3 m). The tyre's force is taken to be vertical.
"""

from __future__ import annotations

import math

from vr_envs.models.jit import kernel
from vr_envs.models.road_options import RAW


@kernel
def wheel_reach(road, wheel):
    """How many knots on either side the wheel may touch, rounded up to a multiple of two."""
    return 2 * int(math.ceil(0.5 * wheel.radius / road.knot_spacing - 1e-9))


@kernel
def centre_height(raw, knot, reach, spacing, radius):
    """Height c - R of the wheel's centre at a knot; `raw` is a ring of heights of the profile at the knots."""
    height = raw[knot & (RAW - 1)]
    for side in (-1, 1):
        near, ground = 0.0, raw[knot & (RAW - 1)]
        for i in range(1, reach + 1):
            far, next_ground = i * spacing, raw[(knot + side * i) & (RAW - 1)]
            if max(ground, next_ground) > height:  # else the circle over this piece is lower
                slope = (next_ground - ground) / spacing  # away from the knot
                stretch = math.sqrt(1.0 + slope * slope)
                if near < radius * slope / stretch < far:
                    height = max(height, ground - slope * near + radius * slope * slope / (1.0 + stretch))
                if far < radius:
                    height = max(height, next_ground - far * far / (radius + math.sqrt(radius * radius - far * far)))
            near, ground = far, next_ground
    return height
