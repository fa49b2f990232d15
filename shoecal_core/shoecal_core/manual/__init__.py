"""Manual calibration: single cells, then the shoe, under known weights (paper, section III)."""
