"""Whole episodes of every kind of vehicle against an independent integrator, at control intervals from 1 ms to 10 s."""

import dataclasses

import numpy as np
import pytest

from tests.models.ride_reference import Reference, drive_ticks, seen
from vr_envs.models.cruise import commanded_speed
from vr_envs.models.record import dtype_of, pack
from vr_envs.models.ride_options import ActuatorLag, Cruise, Tyre
from vr_envs.models.road import RING, place_on_road, start_road
from vr_envs.models.road_options import Bumps, Road
from vr_envs.models.terrain import Undulation, start_undulation
from vr_envs.models.terrain_ride import Params, State, advance, rest, suspension
from vr_envs.models.travel_stop import TravelStop

TICKS = 1000
OPTIONS = (
    "undulation", "road", "profile", "bumps", "obstacle", "wheel", "tyre", "stop", "lag", "cruise", "textbook",
    "metrics",
)  # fmt: skip
SCENES = {
    "quarter-car": {
        "road": Road(iso_class="D"), "bumps": Bumps(), "tyre": Tyre(), "stop": TravelStop(), "lag": ActuatorLag(),
    },
    "journey": {
        "road": Road(iso_class="E", knot_spacing=0.13), "tyre": Tyre(), "stop": TravelStop(), "lag": ActuatorLag(),
        "cruise": Cruise(),
    },
    "sines": {
        "undulation": Undulation(amplitude=0.08, wavelength=15.0), "tyre": Tyre(), "stop": TravelStop(),
        "cruise": Cruise(),
    },
    # a soft ride: nothing but the tyre's hysteresis-free spring holds the hub, so that larger bounces are chaotic
    "absolute": {
        "undulation": Undulation(amplitude=0.01, wavelength=20.0), "tyre": Tyre(), "stop": TravelStop(),
        "cruise": Cruise(),
    },
    "follower": {"road": Road(iso_class="D"), "stop": TravelStop(), "cruise": Cruise()},
}  # fmt: skip
PARAMS = {
    "sines": Params(damping_low=3.0),
    "absolute": Params(damping="absolute"),
    "journey": Params(actuation="active", passive_damping=4.0),
}
# liftoffs and touches of a stop, at least, in the first test
CONTACTS = {"quarter-car": (20, 3), "journey": (60, 20), "sines": (10, 20), "absolute": (0, 0), "follower": (0, 3)}


class Ride:
    """A model's record in one scene, from rest under a payload."""

    def __init__(self, name, dt=0.01):
        self.options, self.params = SCENES[name], dataclasses.replace(PARAMS.get(name, Params()), dt=dt)
        self.packed = {key: pack(option) for key, option in self.options.items()}
        self.record, self.state = pack(self.params), np.zeros(1, dtype_of(State))[0]
        self.state["key"], self.state["payload"] = 5, 0.4
        self.knots = {}
        if "undulation" in self.packed:
            start_undulation(self.state)
        if "road" in self.packed:
            start_road(self.state, self.packed["road"], None, self.packed.get("bumps"), None, None)
        rest(self.state, self.record, self.packed.get("tyre"))
        self.began = self.state.copy()
        self.width = (1 if self.params.active else 2) + ("cruise" in self.options)

    def move(self, action):
        first = int(self.state["knot"])
        self.knots.update({k: float(self.state["knots"][k % RING]) for k in range(first, first + RING - 3)})
        advance(self.state, action, self.record, *(self.packed.get(name) for name in OPTIONS))

    def reference(self):
        """One that starts where this ride began; to be called at its end."""
        chosen = {k: self.options[k] for k in ("undulation", "tyre", "stop", "cruise") if k in self.options}
        if "road" in self.options:
            chosen["knots"] = np.array([self.knots[k] for k in range(len(self.knots))])
            chosen["spacing"] = self.options["road"].knot_spacing
        return Reference(self.began, self.params, **chosen)

    def target(self, action):
        return commanded_speed.py_func(action[-1], self.options["cruise"]) if "cruise" in self.options else None


@pytest.mark.parametrize("name", SCENES)
def test_an_episode_agrees_with_an_integrator(name):
    """Actions over the whole range, new ones every 0.2 s."""
    ride, rng = Ride(name), np.random.default_rng(1)
    path, suspensions, targets = [], [], []
    for tick in range(TICKS):
        if tick % 20 == 0:
            action = rng.uniform(-1.0, 1.0, ride.width)
        ride.move(action)
        path.append(seen(ride.state))
        suspensions.append(suspension(ride.state, ride.record))
        targets.append(ride.target(action))
    reference = ride.reference()
    expected = drive_ticks(reference, suspensions, targets)
    assert (np.abs(path - expected).max(0) <= 1e-10 * np.abs(expected).max(0)).all()
    assert (ride.state["liftoffs"], ride.state["airborne"]) == (reference.liftoffs, reference.airborne)
    assert ride.state["airborne_time"] == pytest.approx(reference.airborne_time, abs=1e-10)
    assert ride.state["side"] == reference.side
    assert not ride.state["fault"]
    assert (reference.liftoffs, reference.touches) >= CONTACTS[name]


@pytest.mark.parametrize("name", SCENES)
def test_the_control_interval_does_not_matter(name):
    """One action held for 10 s, in 1 to 10 000 intervals, two of which do not divide a tick."""
    ends, suspensions = [], []
    for dt, count in ((0.01, 1000), (0.001, 10_000), (10.0 / 3003.0, 3003), (10.0 / 77.0, 77), (1.0, 10), (10.0, 1)):
        ride = Ride(name, dt)
        action = np.array([0.6, 0.1, 0.5])[-ride.width :]
        for _ in range(count):
            ride.move(action)
            if dt == 0.01:
                suspensions.append(suspension(ride.state, ride.record))
        ends.append(ride)
        if dt == 0.01:
            reference = ride.reference()
            expected = drive_ticks(reference, suspensions, [ride.target(action)] * count)[-1]
            assert seen(ride.state) == pytest.approx(expected, rel=1e-10)
    first = ends[0].state
    for ride in ends[1:]:
        for field in ("travel", "velocity", "deflection", "hub_velocity", "speed", "airborne_time"):
            assert ride.state[field] == pytest.approx(first[field], abs=1e-12), (ride.params.dt, field)
        if "road" in ride.options:
            places = [r["knot"] + place_on_road(r, ride.packed["road"]) for r in (ride.state, first)]
            assert places[0] == pytest.approx(places[1], abs=1e-12)
        assert ride.state["distance"] == pytest.approx(first["distance"], rel=1e-12)
        for field in ("weighted", "travel_squares", "travel_rate", "acceleration"):
            assert ride.state[field] == pytest.approx(first[field], rel=1e-9, abs=1e-11), (ride.params.dt, field)
        for field in ("side", "airborne", "liftoffs", "ticks", "fault"):
            assert ride.state[field] == first[field], (ride.params.dt, field)
