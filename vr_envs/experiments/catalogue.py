"""All experiments, in the order of the source documents: the bouncing ball's report, then the lecture."""

from __future__ import annotations

from vr_envs.experiments.experiment import Experiment

VISION = (
    Experiment("vision", "Figs 2.1, 2.2", "the vision system tracks ball and bar in space", "vision:run"),
    Experiment("vision-error", "Section II", "error of the vision system over noise and pixels", "vision_error:run"),
)
LENS = (
    Experiment("lens-travel", "Figs 2.3, 2.4", "a ball travels round a concave lens as it bounces", "lens:travel"),
    Experiment("lens-height", "Fig 2.5", "height of the ball, adjusted for the lens under it", "lens:height"),
)

VERTICAL = (
    Experiment("period-one", "Figs 3.1, 3.2, Table 3.1", "period one at 30 Hz", "period_figures:period_one"),
    Experiment("period-two", "Figs 3.3, 3.4, Table 3.2", "period two at 30 Hz", "period_figures:period_two"),
    Experiment(
        "period-three", "Fig 3.5", "period three at 30 Hz, and the starts that lead to it", "period_three:period_three"
    ),
    Experiment("period-one-m2", "Fig 3.6", "period one over two bar cycles at 20 Hz", "period_figures:period_one_m2"),
    Experiment("period-two-m2", "Fig 3.7", "period two over four bar cycles at 20 Hz", "period_figures:period_two_m2"),
    Experiment(
        "restitution", "Section III.D", "restitution from the decay of a dropped ball", "restitution:restitution"
    ),
    Experiment("bifurcation", "Figs 3.8 to 3.10", "heights of bounce against acceleration", "bifurcation:bifurcation"),
    Experiment("stability-bands", "Fig 3.11", "stable period one for m = 1 to 7", "stability_bands:stability_bands"),
    Experiment(
        "phase-portrait", "Fig 3.12", "impacts in the reduced phase space, and locking", "phase_portrait:phase_portrait"
    ),
)

HORIZONTAL = (
    Experiment("growth", "Fig 4.1", "growth rate over the tilt's phase, no x-motion", "horizontal_figures:no_x_motion"),
    Experiment("growth-surface", "Figs 4.2, 4.3", "growth rate over phase and tilt", "horizontal_figures:surface"),
    Experiment("bar-motions", "Fig 4.4", "a motion that is a source and one that is a sink", "bar_motions:bar_motions"),
    Experiment("growth-x", "Fig 4.5", "growth rate with a small x-motion", "horizontal_figures:small_x_motion"),
    Experiment(
        "growth-x-surface", "Fig 4.6", "growth rate over phase and tilt, small x-motion", "horizontal_figures:surface_x"
    ),
    Experiment("growth-x-sizes", "Fig 4.7", "growth rate for several x-motions", "horizontal_figures:x_motions"),
)

SEARCH = (Experiment("grazing", "Section III.D", "first contacts of a million grazing launches", "grazing:grazing"),)

LECTURE = (
    Experiment("kd-step", "Lecture, 3.88", "the damping of a factor once a step", "kd_step:kd_step"),
    Experiment("ride-readings", "Lecture, 3.89, 3.90", "two readings of h over the step", "ride_readings:readings"),
    Experiment("ride-engines", "Lecture, 3.89, 3.90", "error of every engine over its step", "ride_engines:engines"),
    Experiment("heading-step", "Lecture, aircraft", "the turn of a heading step without dt", "heading_step:heading"),
)

RIDE = (
    Experiment(
        "road-spectrum", "ISO 8608", "densities of three road classes over the formula", "road_spectrum:road_spectrum"
    ),
    Experiment(
        "ride-classes", "ISO 8608, 2631-1", "ride of a quarter car by road class and speed", "ride_classes:ride_classes"
    ),
)

EXPERIMENTS: dict[str, Experiment] = {
    e.name: e for e in (*VISION, *LENS, *VERTICAL, *SEARCH, *HORIZONTAL, *LECTURE, *RIDE)
}
