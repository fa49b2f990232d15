"""Faults of six-axis sensors: units, frames, axes."""
