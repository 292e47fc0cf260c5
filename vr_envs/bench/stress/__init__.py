"""What was tried to break the kernels: trials whose cases follow from their number alone, and what happened."""
