"""The training comparison of the folder `agents`, which belongs to a clone, in a process of its own."""

from __future__ import annotations

import importlib.util
import json
import subprocess
import sys
from pathlib import Path
from typing import Any

CLONE = Path(__file__).resolve().parents[3]


def missing() -> str | None:
    """Why no training can be measured here, as a sentence; None if it can."""
    if not (CLONE / "agents" / "speed.py").exists():
        return "Training was not measured: the folder `agents` is in a clone of the repository, not in the package."
    if not all(importlib.util.find_spec(name) for name in ("torch", "stable_baselines3")):
        return "Training was not measured: it needs `pip install '.[agents]'` in the clone."
    return None


def trainings(env_ids: list[str], steps: int) -> list[dict[str, Any]]:
    """What `python -m agents speed` prints: one dict per training, times in CPU seconds."""
    command = [sys.executable, "-m", "agents", "speed", *env_ids, "--timesteps", str(steps)]
    run = subprocess.run(command, cwd=CLONE, check=True, stdout=subprocess.PIPE, text=True)
    return json.loads(run.stdout)
