"""Calibration with a model that is allowed to be wrong: found effects and tolerances are fitted."""
