"""Layouts for RViz, Foxglove and PlotJuggler, and whether they fit the topics there are."""
