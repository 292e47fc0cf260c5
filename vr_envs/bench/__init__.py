"""Throughput of the environments."""
