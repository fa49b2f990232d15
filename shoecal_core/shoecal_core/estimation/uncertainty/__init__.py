"""How certain a calibration is: what the data identify, expected errors, where they come from."""
