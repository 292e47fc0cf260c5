"""Roll any policy out on fixed, paired scenarios; metrics with intervals."""
