"""The one simulation of the ball on a lens that notebooks and experiments use.

    from vr_envs.experiments.lens_orbit import period_one_start
    from vr_envs.experiments.lens_simulation import simulate
    from vr_envs.models.ball_on_lens import Params, plano_concave

    params = Params(frequency=30.0, curvature=plano_concave(0.15))
    run = simulate(params, period_one_start(params, x=0.008, v=0.05), cycles=90)
    run.impacts["x"], run.position(run.times + 0.01)

SI units; frame and signs: `models/ball_on_lens.py`.
"""

from __future__ import annotations

import dataclasses

import numpy as np

from vr_envs.models.ball_on_lens import LOGGED, MAX_IMPACTS, Params, State, cycle
from vr_envs.models.ball_options import Friction, Spin
from vr_envs.models.lens_flight import gap_at
from vr_envs.models.record import checked, dtype_of, pack

INSIDE = 1e-12  # m, by which a start may be inside the glass: rounding


@dataclasses.dataclass(frozen=True)
class Run:
    """What a ball did on a lens.

    `cycle` (n,) and `impacts` (column of `LOGGED` -> (n,)) are its impacts, number k in entry k; `end` is the record
    of `State` after the last cycle, with `lost` and `fault`.
    """

    params: Params
    start: State
    cycle: np.ndarray
    impacts: dict[str, np.ndarray]
    end: np.void

    @property
    def times(self) -> np.ndarray:
        """Times of the impacts since the start, s, shape (n,)."""
        return self.cycle * self.params.period + self.impacts["time"]

    def position(self, times: np.ndarray) -> np.ndarray:
        """Place (x, y, z) of the ball's centre at `times` (s since the start), shape (len(times), 3), m.

        NaN after the end of the run.
        """
        names, s = ("x", "y", "z", "u", "v", "w"), self.start
        launches = np.vstack([[s.x, s.y, s.z, s.u, s.v, s.w], np.column_stack([self.impacts[name] for name in names])])
        flight = np.searchsorted(self.times, times, side="right")
        since = times - np.concatenate([[0.0], self.times])[flight]
        place, velocity = launches[flight, :3], launches[flight, 3:]
        place = place + velocity * since[:, None]
        place[:, 2] -= 0.5 * self.params.gravity * since**2
        place[times > float(self.end["cycles"]) * self.params.period] = np.nan
        return place

    def lens_height(self, times: np.ndarray) -> np.ndarray:
        """Height of the lens at `times` (s since the start), m."""
        p = self.params
        return p.amplitude * np.sin(p.omega * (times % p.period) + p.phase)


def simulate(
    params: Params, start: State, cycles: int, spin: Spin | None = None, friction: Friction | None = None
) -> Run:
    """Let a ball bounce on a lens for a number of cycles, or until it is lost or in a fault.

    Args:
        params: the scene.
        start: the ball at the start of the first cycle; see `lens_orbit.period_one_start`.
        cycles: of the lens.
        spin: of a ball that grips.
        friction: the limit of the grip.

    Raises:
        ValueError: the ball does not start above the lens, or a number is not allowed; the message names it.
    """
    checked(Params, dataclasses.asdict(params), "params.")
    checked(State, dataclasses.asdict(start), "start.")
    for name, option in (("spin", spin), ("friction", friction)):
        if option is not None:
            checked(type(option), dataclasses.asdict(option), f"{name}.")
    if spin is not None and spin.radius != params.ball_radius:
        raise ValueError(
            f"spin.radius = {spin.radius:g} m and params.ball_radius = {params.ball_radius:g} m; it is one ball: "
            "give the same"
        )
    record, *options = (None if given is None else pack(given) for given in (params, spin, friction))
    state = np.array([pack(start)], dtype_of(State))[0]
    gap, _ = gap_at(state, 0.0, record)
    if gap < -INSIDE:
        raise ValueError(
            f"the ball starts about {-gap:.1g} m inside the lens at x = {start.x:g}, y = {start.y:g}, z = {start.z:g} "
            "m; raise z"
        )
    log = np.empty((MAX_IMPACTS + 1, len(LOGGED)))
    numbers, rows = [], [np.empty((0, len(LOGGED)))]
    for number in range(cycles):
        before = int(state["impacts"])
        cycle(state, record, *options, log)
        count = int(state["impacts"]) - before
        rows.append(log[np.arange(before, before + count) % len(log)])
        numbers += [number] * count
        if state["lost"] or state["fault"]:
            break
    table = np.vstack(rows)
    impacts = {name: table[:, k] for k, name in enumerate(LOGGED)}
    return Run(params, start, np.array(numbers, dtype=np.int64), impacts, state)
