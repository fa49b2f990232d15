"""Standard acceleration of gravity; by itself, since shoes need it and no model of a robot."""

GRAVITY = 9.80665
"""Standard acceleration of gravity [m/s^2]."""
