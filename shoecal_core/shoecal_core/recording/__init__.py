"""Sessions of recorded runs: write, read, align in time, recover."""
