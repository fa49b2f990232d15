"""The signals that a gap shows in, and what the fitted parameters add to them.

Signals are measured minus modelled. The first three are the calibration's own residuals, each
of the others needs no force sensor, or no model, and so separates other effects:

- grf, cop_x, cop_y: of both feet together, in the stance's frame;
- air_f, air_mx, air_my: the wrench of a foot in the air, which should be zero;
- closure: pose of the right sole in the left's, by the joints: constant while both stand, and
  on one floor without height, roll and pitch;
- parity: of four cells below a stiff plate three determine the fourth;
- tilt: upwards by the IMU, in the sole frame by the joints: along z on a level floor.
"""

from __future__ import annotations

SIGNALS = (
    "grf", "cop_x", "cop_y", "air_f", "air_mx", "air_my",
    "closure_x", "closure_y", "closure_z", "closure_roll", "closure_pitch", "closure_yaw",
    "parity_left", "parity_right", "tilt_x", "tilt_y",
)  # fmt: skip
GRF, COP, AIR, CLOSURE, PARITY, TILT = (
    slice(0, 1), slice(1, 3), slice(3, 6), slice(6, 12), slice(12, 14), slice(14, 16),
)  # fmt: skip
ROLL_PITCH = slice(9, 11)
FLAT = slice(8, 11)
"""Of the closure what soles on one floor have at zero: height, roll and pitch."""
FLAT_OF_CLOSURE = slice(FLAT.start - CLOSURE.start, FLAT.stop - CLOSURE.start)
OWN_ERRORS = (0, 1, 2, 8, 9, 10, 14, 15)
"""Signals to which a stance may add something by itself."""
FAMILIES = {"air": AIR, "closure": CLOSURE, "parity": PARITY, "tilt": TILT}
"""Families of signals that can be left out, and where they stand."""
