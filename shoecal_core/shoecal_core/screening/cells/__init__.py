"""Faults of cells, their cables and converters."""
