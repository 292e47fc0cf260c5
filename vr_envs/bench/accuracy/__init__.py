"""Run time against error: every engine, and what one would use instead, on the same episodes."""
