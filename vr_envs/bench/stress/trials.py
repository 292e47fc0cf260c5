"""All trials, by name."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from vr_envs.bench.stress import autopilot, ball_grazing, ball_on_bar, ball_on_lens, fuzz, same_bytes, terrain_ride
from vr_envs.bench.stress.trial import Outcome, Trial

BALL, LENS, AIRCRAFT, RIDE, ALL = "ball on a bar", "ball on a lens", "aircraft", "ride", "all"
_DEPTH = "deepest passage, m"
_APART = "difference, of the motion"
_GIVES_UP = "ended: more than 20 000 impacts in an interval"
Run = Callable[[int, int, np.ndarray], Outcome]


def _ball(name: str, tried: str, cases: int, run: Run, unit: str = "impacts", met: str = "") -> Trial:
    return Trial(f"ball-{name}", BALL, tried, unit, _DEPTH, cases, run, _GIVES_UP, met)


def _presets(env_id: str) -> str:
    return " or ".join(fuzz.PRESETS[env_id])


def _all() -> list[Trial]:
    ball, air, ride = ball_on_bar, autopilot, terrain_ride
    return [
        Trial(
            "ball-grazing", BALL,
            "launches hardly faster than the bar, 1e-10 to 100 m/s, at 3 to 100 Hz and 5 to 100 m/s^2, and launches "
            "that graze a crest, halved to rounding; each contact judged by a certified search",
            "launches", _DEPTH, 8000, ball_grazing.run,
        ),
        _ball("chatter", "chatter, rest and release on a bar that moves up and down at 5 to 100 m/s^2", 1500,
              ball.runs(ball.chatter), met="intervals that end at rest"),
        _ball("losses", "restitution 0 and 1, bars still and moving, from 1e-12 m up", 800, ball.runs(ball.losses)),
        _ball("motions", "another random bar motion in every cycle, over the whole range of the actions", 1000,
              ball.runs(ball.motions, motions=True), "motions"),
        _ball("speeds", "bars from 0.5 to 200 Hz, up to 100 m/s^2, blends of 0.05 to 1 cycle", 800,
              ball.runs(ball.speeds)),
        _ball("dropped", "dropped from 10 m", 800, ball.runs(ball.dropped)),
        _ball("curved", "a bar curved to nearly 45 degrees at its ends, a rough sphere that spins and slips", 120,
              ball.runs(ball.curved)),
        Trial(
            "ball-lens", LENS,
            "glass nearly as wide as its sphere, balls nearly as large as it, 5 to 200 Hz, 5 to 100 m/s^2", "impacts",
            _DEPTH, 4000, ball_on_lens.run,
            "ended: the ball rests, or flies over the centre of the lens's sphere",
        ),
        _ball("impacts", "impact after impact at 12 to 25 m/s^2", 1000, ball.runs(ball.impacts)),
        Trial(
            "aircraft-demands", AIRCRAFT,
            "demands from end to end of the envelope, and full commands, in every step, in rough air", "steps", "",
            100, air.demands,
        ),
        Trial(
            "aircraft-standing", AIRCRAFT,
            "slowed to airspeed 0 and sped up again, in still air and in a shear of up to 0.2 1/s", "steps",
            "rounding, of 10 km, 100 m/s and a turn", 200, air.standing, met="at airspeed 0",
        ),
        Trial(
            "aircraft-turns", AIRCRAFT, "a million turns in one direction, in steps of 1 s to 1 h", "turns",
            "heading off, rad", 20, air.turns,
        ),
        Trial(
            "aircraft-intervals", AIRCRAFT, "one interval of 1 ms to 1 h against the same time in 2 to 7", "intervals",
            _APART, 150, air.intervals,
        ),
        Trial(
            "aircraft-rough", AIRCRAFT,
            "turbulence of 20 m/s, six times as strong as severe, down to the ground", "steps",
            "variance of a gust off, of it", 40, air.rough,
        ),
        Trial(
            "ride-kerbs", RIDE, "kerbs up and down without end, to 1 m high, at 1 to 100 m/s", "steps", _APART, 250,
            ride.kerb_cases,
        ),
        Trial(
            "ride-switching", RIDE,
            "damping of 0.001 to 1000 1/s and stiffness over four decades, to 1e9 N/m, switched in every step", "steps",
            _APART, 250, ride.switch_cases,
        ),
        Trial(
            "ride-hopping", RIDE, "light wheels on hard tyres at 100 m/s over roads of class E to H", "steps", _APART,
            250, ride.hop_cases, met="with the wheel off the ground",
        ),
        Trial("ride-far", RIDE, "the default scene, on and on", "steps", "", 100, ride.far),
        Trial(
            "ride-denormals", RIDE, "level roads, from motions of 1e-320 to 1e-300", "steps", "", 20, ride.small_cases,
            met="with all of the motion below 2.3e-308",
        ),
        *(
            Trial(
                f"{name}-fuzz", system, f"{_presets(env_id)}, fields of it and of its options drawn from their ranges; "
                "actions drawn, abrupt, held, none, and +-1e300",
                "steps", "", 600, fuzz.fuzzed(env_id), "refused, each with what is allowed",
            )
            for name, system, env_id in (
                ("ball", BALL, "BallOnBar"), ("aircraft", AIRCRAFT, "Autopilot"), ("ride", RIDE, "TerrainRide")
            )
        ),
        Trial(
            "same-bytes", ALL,
            "repeated; in batches of 1 to 41; in any split of a batch; from restored states; in three threads", "steps",
            "", 2 * len(same_bytes.SCENES), same_bytes.same_everywhere,
        ),
        Trial(
            "processes", ALL, f"{len(same_bytes.SCENES)} scenes in this process and in another", "steps", "", 2,
            same_bytes.processes,
        ),
    ]  # fmt: skip


TRIALS = {trial.name: trial for trial in _all()}
