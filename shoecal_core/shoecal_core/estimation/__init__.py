"""Gains and offsets with everything that may be wrong beside them: fit, uncertainty, budget."""
