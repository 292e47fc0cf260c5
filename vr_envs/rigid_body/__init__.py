"""The systems as scenes of a rigid-body engine: `vr_envs.rigid_body.<task name>.SIMULATOR` moves a task's state."""
