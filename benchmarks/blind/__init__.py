"""The blind check of the diagnosis: sets with known effects, sealed answers, runs, scores."""
