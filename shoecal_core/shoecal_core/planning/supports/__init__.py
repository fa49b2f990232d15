"""Double supports: which are feasible, which to visit, what they will tell."""
