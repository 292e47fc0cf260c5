"""Physics: compiled kernels on records of numbers in SI units. Imports math, numpy and numba only."""
