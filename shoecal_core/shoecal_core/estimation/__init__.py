"""Gains and offsets with everything else that may be wrong: fit, uncertainty, budget."""
