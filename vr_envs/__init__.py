"""Gymnasium environments for classical systems whose truth is known."""

from gymnasium import register

__version__ = "0.4.0"

# 10 s at 15 control cycles per second; 480 s at 1 Hz; 10 s at 100 Hz
for _name, _module, _steps in (
    ("BallOnBar-v0", "ball_on_bar", 150),
    ("Autopilot-v1", "autopilot", 480),
    ("TerrainRide-v0", "terrain_ride", 1000),
):
    register(
        id=f"vr_envs/{_name}",
        entry_point=f"vr_envs.envs.{_module}:{_name.partition('-')[0]}Env",
        vector_entry_point=f"vr_envs.envs.{_module}:{_name.partition('-')[0]}BatchEnv",
        max_episode_steps=_steps,
    )
