"""Double supports: which are feasible, which to visit, what they identify."""
