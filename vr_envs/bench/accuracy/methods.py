"""The methods that more than one system is given to."""

from __future__ import annotations

from vr_envs.bench.accuracy.points import Method

EXACT = Method("exact", "exact")
TEXTBOOK = Method("textbook", "textbook", "step", fixed_step=True)
RIGID_BODY = Method("rigid_body", "rigid body", "step", fixed_step=True)
EULER = Method("semi-implicit Euler", "fixed step", "step", fixed_step=True)
RK4 = Method("RK4", "fixed step", "step", fixed_step=True)
SCIPY = {name: Method(f"solve_ivp {name}", "scipy", "tolerance") for name in ("RK45", "DOP853", "LSODA")}
"""Method of scipy's `solve_ivp` -> method."""
MUJOCO = {name: Method(f"MuJoCo {name}", "MuJoCo", "step", fixed_step=True) for name in ("Euler", "RK4")}
"""Integrator of MuJoCo -> method."""
