"""The calibrator: live CoP and GRF, the calibration in force, self-calibration, recording."""
