"""The main job on the simulated robot: node processes, their conductor, and what came out."""
