"""From trajectories to what robots' own drivers understand."""
