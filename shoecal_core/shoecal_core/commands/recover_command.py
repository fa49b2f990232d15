"""`shoecal recover FILE`: rescue what can be read of a damaged run file."""
