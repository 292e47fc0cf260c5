"""What the numbers say, in words; every claim is computed, and says so where it fails."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from vr_envs.bench.features.costs import Cost, same_calculation
from vr_envs.bench.features.skipped import Finished, Flight, Judging, Rest
from vr_envs.bench.features.startup import Cold, Start, Warm
from vr_envs.bench.features.tables import PerSystem

LOADED = 1.0  # s: kernels in the cache are to be loaded in less
COMPILED = 15.0  # s: a default scene is to be compiled in less
MESSAGE = 2.0  # s, after which a compilation is announced


def on(costs: PerSystem[Cost]) -> str:
    """What the options cost that are on."""
    parts = []
    for system, found in costs.items():
        dearest = max(found, key=lambda cost: cost.ratio.median)
        middle = sorted(cost.ratio.median for cost in found)[len(found) // 2]
        parts.append(
            f"{system}: {middle:.2f} in the middle of {len(found)}, {dearest.ratio.median:.3g} for {dearest.name}"
        )
    return f"An option that is on multiplies the time of a plain scene, row by row ({'; '.join(parts)})."


def lockstep(costs: Mapping[str, Cost], alone: Mapping[str, Sequence[str]]) -> str:
    """What it gains to move rows in lockstep, and where that is not done."""
    parts = [f"{1.0 / cost.ratio.median:.1f} times as fast ({system})" for system, cost in costs.items()]
    without = [f"{', '.join(alone[system])} ({system})" for system in costs if alone[system]]
    return (
        f"In lockstep the rows of a default scene move {', '.join(parts)}, to the same bytes"
        f"{'; not so with the options ' if without else ''}{'; '.join(without)}."
    )


def off(costs: PerSystem[Cost]) -> str:
    """Whether the options cost anything that are off."""
    every = [cost for found in costs.values() for cost in found]
    same = [cost for cost in every if same_calculation(cost)]
    counts = [tuple(c.total() for c in (*cost.instructions, *cost.other_instructions)) for cost in every]
    more = [own - other for own, _, other, _ in counts]
    longer = [100.0 * (own / other - 1.0) for _, own, _, other in counts]
    ratios = [cost.ratio.median for cost in every]
    sizes = [other for _, _, other, _ in counts]
    verdict = (
        f"An option that is off leaves nothing that calculates in the compiled code of {len(same)} of {len(every)} "
        "scenes: as many floating-point operations, loads and calls of functions of each kind as in kernels that never "
        "had it"
    )
    if others := [cost.name for cost in every if not same_calculation(cost)]:
        verdict += f"; that is not so in {', '.join(others)}"
    return (
        f"{verdict}. All in all LLVM's optimised code differs by {min(more):+d} to {max(more):+d} instructions of "
        f"{min(sizes)} to {max(sizes)}, as calls with fewer arguments are inlined otherwise; machine code, which "
        f"passes null pointers on, is {min(longer):.1f} to {max(longer):.1f} % longer; time is {min(ratios):.2f} to "
        f"{max(ratios):.2f} of theirs."
    )


def flight(found: Sequence[Flight]) -> str:
    """How the time depends on the height of a flight."""
    low, high = found[0], found[-1]
    grows = max(one.exact.median for one in found) > 2.0 * low.exact.median
    begin = "A flight takes longer the higher it is" if grows else "A flight is jumped, however long"
    times, samples = low.exact.median / high.exact.median, high.sampled.median / high.exact.median
    return (
        f"{begin}: a ball {high.height:g} m high costs {high.exact.median:.3g} us per "
        f"simulated second, {times:.2g} times less than one at {1e3 * low.height:g} mm, and {samples:.3g} times less "
        "than looking for contacts by samples."
    )


def rest(found: Sequence[Rest]) -> str:
    """What a resting ball costs."""
    bouncing, still, moving = found
    return (
        f"A ball at rest on a still bar takes {still.time.median / bouncing.time.median:.2f} of the time of one that "
        "bounces twice a cycle, on a moving bar, where its release is looked for, "
        f"{moving.time.median / bouncing.time.median:.2f}."
    )


def finished(found: PerSystem[Finished], rows: int) -> str:
    """What finished rows cost."""
    shares = [some[1:] for some in found.values()]
    parts = [
        f"{', '.join(f'{some[k].ratio.median:.2f} ({system})' for system, some in zip(found, shares, strict=True))} "
        f"with {shares[0][k].live}"
        for k in reversed(range(len(shares[0])))
    ]
    text = (
        "The records of finished rows do not change. Over the time of a step in which all of "
        f"{rows} rows run, one takes {' and '.join(parts)} of them, evenly spread"
    )
    slower = [system for system, some in zip(found, shares, strict=True) if any(f.ratio.median > 1.0 for f in some)]
    if slower:
        text += f"; that some of them cost more than all ({', '.join(slower)}) is the price of moving them one by one"
    return f"{text}."


def judging(found: PerSystem[Judging]) -> str:
    """What metrics cost."""
    parts = [f"{100.0 * some[-1].share:.2g} % ({system})" for system, some in found.items()]
    return f"The metrics of rows that end together cost {', '.join(parts)} of the time of their episodes' steps."


def imports(starts: Mapping[str, Start]) -> str:
    """What is loaded before someone looks."""
    found = list(starts.values())
    own = max(start.stages["vr_envs"].modules for start in found)
    early = {m for start in found for name, stage in start.stages.items() if name != "picture" for m in stage.heavy}
    drawing = sorted(early & {"matplotlib", "pygame", "vr_envs.render"})
    before = (
        f"no picture is asked for, but {', '.join(drawing)} is loaded"
        if drawing
        else "nothing that draws is loaded before a picture is asked for"
    )
    return f"`import vr_envs` loads {own} module{'s' if own > 1 else ''} beside gymnasium's; {before}."


def warm(found: Sequence[Warm]) -> str:
    """Whether cached kernels load in time."""
    worst = max(found, key=lambda start: start.kernels.median)
    verdict = "less" if worst.kernels.median < LOADED else "not less"
    return (
        f"With kernels in the cache an environment is made and stepped in {worst.kernels.median:.2f} s of CPU time at "
        f"most ({worst.env_id}), {verdict} than {LOADED:g} s; numba's import is {worst.numba.median:.2f} s, "
        f"gymnasium's {worst.gymnasium.median:.2f} s, that of vr_envs {1e3 * worst.vr_envs.median:.1f} ms."
    )


def cold(found: Sequence[Cold]) -> str:
    """Whether default scenes compile in time."""
    parts = [f"{c.cpu:.1f} s ({c.env_id.rpartition('/')[2]})" for c in found]
    slow = [c.env_id for c in found if c.cpu >= COMPILED]
    silent = [c.env_id for c in found if c.wall > MESSAGE and not c.said]
    verdict = f"of which {', '.join(slow)} not below {COMPILED:g} s" if slow else f"all below {COMPILED:g} s"
    long = any(c.wall > MESSAGE for c in found)
    words = f"without a word from {', '.join(silent)}" if silent else f"with a word after {MESSAGE:g} s"
    words = words if long else f"none longer than {MESSAGE:g} s"
    return f"The first compilation of a default scene takes {', '.join(parts)} of CPU time, {verdict}, {words}."
