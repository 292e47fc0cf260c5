"""Which values of a ride's scene go together."""

from __future__ import annotations

import math

from vr_envs.envs.scene import Scene
from vr_envs.models.quarter_car import check_stiffness
from vr_envs.models.ride_textbook import step_of
from vr_envs.models.road_options import RING, check_road


def validate(scene: Scene) -> None:
    """Ranges in order, the payload within the stops, the preview within the knots that are kept, and a ground.

    Raises:
        ValueError: a rule is broken; it says what was given and what is allowed.
    """
    p, options = scene.params, scene.options
    road, preview, payload, stop, cruise = (options[k] for k in ("road", "preview", "payload", "stop", "cruise"))
    check_road(options)
    orders = [
        ("damping_low", p.damping_low, "damping_high", p.damping_high, True),
        ("modulus_low", p.modulus_low, "modulus_high", p.modulus_high, True),
    ]
    if preview is not None and road is not None:
        reach = (RING - 4) * road.knot_spacing
        orders.append(
            ("speed * preview.horizon", p.speed * preview.horizon, f"{RING - 4} road.knot_spacing", reach, False)
        )
    if payload is not None and stop is not None:
        sag = payload.size / p.w2 * (1.0 if p.active else math.exp(-p.modulus_centre))
        orders.append(("payload.size over the spring", sag, "stop.travel", stop.travel, True))
    if cruise is not None:
        orders.append(("cruise.slowest", cruise.slowest, "cruise.fastest", cruise.fastest, True))
        orders.append(("cruise.schedule", cruise.schedule, "cruise.fastest", cruise.fastest, False))
    for low_name, low, high_name, high, strict in orders:
        if low > high * (1.0 + 1e-12) or (strict and low == high):
            rule = "be below" if strict else "not exceed"
            raise ValueError(f"{low_name} = {low:g} is not allowed; it must {rule} {high_name} = {high:g}")
    if options["undulation"] is None and road is None:
        raise ValueError("road = null is not allowed without an undulation; give one of the two")
    if options["tyre"] is None:
        _check_follower(scene)
    else:
        check_stiffness(p, options["tyre"], stop)
    _check_engine(scene)


def _check_follower(scene: Scene) -> None:
    """What the closed forms of a wheel that follows the ground do not cover; a tyre lifts these limits."""
    options = scene.options
    if options["undulation"] is not None:
        for name in ("stop", "cruise"):
            if options[name] is not None:
                raise ValueError(
                    f"{name} = {{...}} is not allowed over an undulation without a tyre; "
                    "give undulation = null and road = true, or tyre = true"
                )
    if options["cruise"] is not None and not scene.params.relative:
        raise ValueError(
            "damping = 'absolute' is not allowed with cruise and without a tyre; "
            "give damping = 'relative', or tyre = true"
        )


def _check_engine(scene: Scene) -> None:
    """What the engine of the scene knows of the lecture alone, one by one but not together, or at short steps."""
    p, options, step = scene.params, scene.options, _step_of(scene)
    w2, gamma = (p.w2, p.passive_damping) if p.active else (p.w2 * p.modulus_high, p.damping_high)
    if scene.engine == "textbook":
        if p.relative:
            raise ValueError(
                "damping = 'relative' is not allowed with the engine 'textbook': the lecture's factor k_d damps the "
                "mass's own velocity; give damping = 'absolute'"
            )
        longest = math.sqrt(2.0 * (1.0 + math.exp(-gamma * step)) / w2)
    elif scene.engine == "rigid_body":
        if options["wheel"] is not None and options["undulation"] is not None:
            raise ValueError(
                "wheel = {...} is not allowed over an undulation with the engine 'rigid_body', whose disc stands on a "
                "road alone; give undulation = null, or wheel = null"
            )
        tyre, stop = options["tyre"], options["stop"]
        springs = w2 + (0.0 if stop is None else stop.rate / p.mass)
        if tyre is not None:
            springs += (p.mass * springs + tyre.rate) / tyre.unsprung_mass
        longest = 1.0 / math.sqrt(springs)  # half of the limit, for springs that act together
    else:
        return
    if step >= longest:
        raise ValueError(
            f"{scene.engine}.step = {step:g} s is not allowed: with the stiffest springs of this scene the engine is "
            f"sure to be stable below {longest:.3g} s only; give a smaller {scene.engine}.step"
        )


def _step_of(scene: Scene) -> float:
    """The longest step (s) that the engine of the scene makes; 0 for the exact one, which makes none."""
    if scene.engine == "textbook":
        return step_of.py_func(scene.params, scene.options["textbook"])
    return scene.simulators["rigid_body"].step if scene.engine == "rigid_body" else 0.0
