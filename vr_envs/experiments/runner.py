"""Runs experiments and writes what they found: a picture, tables as CSV, findings as JSON."""

from __future__ import annotations

import csv
import io
import multiprocessing
import os
import time
from collections.abc import Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from pathlib import Path
from typing import Any

import numpy as np
from tqdm import tqdm

from vr_envs.evaluation.files import write_bytes, write_json
from vr_envs.evaluation.table import markdown
from vr_envs.experiments.catalogue import EXPERIMENTS
from vr_envs.experiments.experiment import Finding, Outcome, Progress
from vr_envs.render.extras import extra

PICTURE_SIZE = (9.0, 6.0)  # inches; `draw` may set another
RESOLUTION = 120  # points per inch


def silent(items: Iterable[Any], *, desc: str) -> Iterable[Any]:
    """A `Progress` that shows nothing."""
    return items


def _bar(items: Iterable[Any], *, desc: str) -> Iterable[Any]:
    return tqdm(items, desc=desc, leave=False, disable=None)


def run_one(name: str, folder: str | os.PathLike[str], progress: Progress = silent) -> tuple[Finding, ...]:
    """Run the experiment `name` and write NAME.png, NAME.json and one CSV a table to `folder`; returns its findings.

    Raises:
        ImportError: the extra `render` is not installed.
        OSError: `folder` is missing or cannot be written.
    """
    experiment = EXPERIMENTS[name]
    extra("matplotlib.figure")
    start = time.perf_counter()
    outcome = experiment.run(progress)
    report = {
        "name": name,
        "figure": experiment.figure,
        "title": experiment.title,
        "findings": [vars(finding) for finding in outcome.findings],
        "seconds": round(time.perf_counter() - start, 3),
    }
    target = Path(folder)
    for table, columns in outcome.tables.items():
        write_bytes(target / f"{name}-{table}.csv", csv_of(columns))
    write_bytes(target / f"{name}.png", picture(outcome))
    write_json(target / f"{name}.json", report)
    return outcome.findings


def run_all(
    names: Sequence[str], folder: str | os.PathLike[str], jobs: int = 1
) -> Iterator[tuple[str, tuple[Finding, ...]]]:
    """`run_one` for each name, in at most `jobs` processes; yields (name, findings) as they come."""
    if jobs == 1 or len(names) == 1:
        for name in (bar := tqdm(names, leave=False, disable=None, unit="experiment")):
            bar.set_description(name)
            yield name, run_one(name, folder, _bar)
        return
    with ProcessPoolExecutor(min(jobs, len(names)), multiprocessing.get_context("spawn")) as pool:
        running = {pool.submit(run_one, name, folder): name for name in names}
        try:
            done = as_completed(running)
            for one in tqdm(done, "experiments", len(names), leave=False, disable=None, unit="experiment"):
                yield running[one], one.result()
        finally:
            pool.shutdown(cancel_futures=True)


def summary(name: str, findings: Sequence[Finding]) -> str:
    """Title and the table "expected, found, agrees" of one experiment."""
    experiment = EXPERIMENTS[name]
    body = [[f.what, f.expected, f.found, "yes" if f.agrees else "NO"] for f in findings]
    table = markdown(["", "expected", "found", "agrees"], body, left=range(4))
    return f"{name}: {experiment.title} ({experiment.figure})\n\n{table}"


def csv_of(columns: Mapping[str, np.ndarray]) -> bytes:
    """Columns of equal length as CSV, numbers to full accuracy."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(columns)
    writer.writerows(zip(*(np.asarray(column).tolist() for column in columns.values()), strict=True))
    return text.getvalue().encode()


def picture(outcome: Outcome) -> bytes:
    """The experiment's picture as PNG."""
    figure = extra("matplotlib.figure").Figure(figsize=PICTURE_SIZE, layout="constrained")
    outcome.draw(figure)
    content = io.BytesIO()
    figure.savefig(content, format="png", dpi=RESOLUTION, metadata={"Software": None})
    return content.getvalue()
