"""Drafts of a robot file and of a shoe file, from a URDF alone."""
