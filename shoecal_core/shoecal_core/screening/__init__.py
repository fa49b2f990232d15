"""Faults of a recording, found and named before the fit; what breaks its assumptions goes."""
