"""What lies on a road besides its roughness: heights [m] at a distance [m] from the start of the road."""

from __future__ import annotations

import math

from vr_envs.models.jit import kernel
from vr_envs.models.lanes import any_lane, floor, to_int, where
from vr_envs.models.noise import uniform
from vr_envs.models.road_options import KERB, POTHOLE, RAMP, SAME_PLACE, WASHBOARD

_BUMP = 1 << 42  # first counter of the bumps' draws, three for each


@kernel
def profile_height(distance, profile):
    """Height of the measured profile over its first point; that of the last point goes on."""
    place = distance / profile.spacing
    left = int(place)
    if place >= profile.points - 1.0:
        height = profile.height[int(profile.points) - 1]
    else:
        height = profile.height[left] + (profile.height[left + 1] - profile.height[left]) * (place - left)
    return height - profile.height[0]


@kernel
def bump_height(key, distance, bumps):
    """Height of the bump or dip."""
    place = floor(distance / bumps.stretch)
    counter = _BUMP + 3 * to_int(place)
    # the whole bump lies within its stretch
    free = bumps.stretch - 2.0 * bumps.longest
    away = abs(distance - place * bumps.stretch - bumps.longest - free * uniform(key, counter))
    near, found = away < bumps.longest, 0.0 * away
    if any_lane(near):
        half = bumps.shortest + (bumps.longest - bumps.shortest) * uniform(key, counter + 1)
        side = 2.0 * uniform(key, counter + 2) - 1.0
        height = bumps.low + (bumps.high - bumps.low) * abs(side)
        found = where(near, math.copysign(height, side) * max(0.0, 1.0 - away / half), found)
    return found


@kernel
def obstacle_height(distance, obstacle):
    """Height of the obstacle."""
    along = distance - obstacle.first
    if along < -SAME_PLACE:
        return 0.0
    if obstacle.every > 0.0:
        along -= obstacle.every * math.floor((along + SAME_PLACE) / obstacle.every)
    along = max(0.0, along)
    if along >= obstacle.extent - SAME_PLACE:
        return 0.0
    if obstacle.form == KERB:
        return obstacle.height
    if obstacle.form == RAMP:
        return obstacle.height * min(1.0, along / obstacle.length, (obstacle.extent - along) / obstacle.length)
    if obstacle.form == WASHBOARD:
        return obstacle.height * math.sin(2.0 * math.pi * along / obstacle.pitch)
    arch = math.sin(math.pi * along / obstacle.length)
    return (-obstacle.height if obstacle.form == POTHOLE else obstacle.height) * arch * arch
