"""The opponents of the compiled kernels: the same environments as operations on whole arrays, for NumPy or JAX."""
