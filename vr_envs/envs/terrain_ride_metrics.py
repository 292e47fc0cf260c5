"""Domain metrics of the ride."""

from __future__ import annotations

import numpy as np

from vr_envs.envs.scene import Scene
from vr_envs.models.ride_meter import readings


def metrics(states: np.ndarray, scene: Scene) -> dict[str, np.ndarray]:
    """Domain metrics of episodes, one value per record; those that matter most in the scene come first.

    Those of `ride_meter.readings`, and stop_hits: times that a stop was touched; mean_speed_m_s; lateness_m: distance
    behind the schedule at the end, 0 where it is kept or where there is none; fault: a search for a contact did not
    end; is_success: no hit and no fault, weighted acceleration and travel below the values that halve the reward.
    """
    seconds = np.maximum(states["steps"], 1) * scene.params.dt
    found = readings(states, seconds)
    found["stop_hits"] = states["hits"].copy()
    found["mean_speed_m_s"] = np.full(len(states), scene.params.speed)
    found["lateness_m"] = np.zeros(len(states))
    cruise = scene.options["cruise"]
    if cruise is not None:
        found["mean_speed_m_s"] = states["distance"] / seconds
        found["lateness_m"] = np.maximum(0.0, cruise.schedule * seconds - states["distance"])
    found["fault"] = states["fault"] != 0
    acceleration, travel = found["acceleration_rms_m_s2"], 1e-3 * found["travel_rms_mm"]
    calm = (acceleration < scene.params.comfort) & (travel < scene.params.rattle)
    third = (
        "lateness_m" if cruise is not None else "travel_peak_mm" if scene.options["tyre"] is None else "tyre_load_rms"
    )
    first = ("acceleration_rms_m_s2", "travel_rms_mm", third, "stop_hits")
    return {
        "is_success": calm & (states["hits"] == 0) & ~found["fault"],
        **{name: found[name] for name in first},
        **found,
    }
