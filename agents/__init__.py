"""Training and judging learning agents on the environments; run as `python -m agents`."""
