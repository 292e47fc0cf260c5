"""Throughput: steps per second of CPU time, in this package and written otherwise."""
