"""The optimisation over one horizon, its solvers, and the horizon that rolls."""
