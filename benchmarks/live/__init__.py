"""What the benchmark of the live path is made of: two chains, a line, what goes on meanwhile."""
