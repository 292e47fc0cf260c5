"""The subcommands of `vr-envs`, one file each: `add` declares the arguments, `run` does the work."""
