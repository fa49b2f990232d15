"""From recorded runs to a calibration: initial guess, least squares, CoP correction, checks."""
