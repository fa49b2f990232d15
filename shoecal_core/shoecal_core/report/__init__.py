"""Plots and the one-file HTML reports."""
