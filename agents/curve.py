"""The learning curve of a run: what its `progress.csv` says, as a picture."""

from __future__ import annotations

import csv
import io
from pathlib import Path

import numpy as np

from vr_envs.evaluation.files import write_bytes


def read(folder: Path, limit: int) -> tuple[np.ndarray, np.ndarray]:
    """Steps, and the score of the training episodes that had ended by then (mean reward per possible step).

    Args:
        folder: of the run.
        limit: control intervals of a full episode.
    """
    with (folder / "progress.csv").open(newline="") as file:
        rows = [row for row in csv.DictReader(file) if row.get("rollout/ep_rew_mean")]
    steps = np.array([float(row["time/total_timesteps"]) for row in rows])
    return steps, np.array([float(row["rollout/ep_rew_mean"]) for row in rows]) / limit


def draw(folder: Path, limit: int, title: str, baseline: tuple[str, float] | None) -> Path:
    """Draw `learning_curve.png` in the run's folder.

    Args:
        folder: of the run.
        limit: control intervals of a full episode.
        title: of the picture.
        baseline: name and held-out score of the policy to draw as a line, or None.
    """
    from matplotlib.figure import Figure

    steps, scores = read(folder, limit)
    figure = Figure(figsize=(7.0, 4.2), dpi=120, layout="constrained")
    axes = figure.add_subplot()
    axes.plot(steps / 1e6, scores, label="agent, training episodes (with exploration)")
    if baseline is not None:
        axes.axhline(baseline[1], color="0.4", linestyle="--", label=f"{baseline[0]}, held-out scenarios")
    axes.set(xlabel="control intervals, millions", ylabel="score: mean reward per possible step", title=title)
    axes.set_xlim(left=0.0)
    axes.grid(alpha=0.3)
    axes.legend(loc="best")
    picture = io.BytesIO()
    figure.savefig(picture, format="png")
    path = folder / "learning_curve.png"
    write_bytes(path, picture.getvalue())
    return path
