"""Physical constants that more than one system needs."""

G = 9.80665  # standard gravity [m/s^2]
