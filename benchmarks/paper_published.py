"""Figures of Han, Jiang and Chirikjian, Watch Me Calibrate My Force-Sensing Shoes!, typed once.

Mean absolute errors, with the standard deviation where the paper gives it: GRF [N], CoP [mm].
"""

MANUAL = {
    "left": ("0.02 ± 0.01", "4.53 ± 1.89", "1.07 ± 0.62"),
    "right": ("0.03 ± 0.03", "3.51 ± 1.90", "0.76 ± 0.35"),
}
"""Table I: GRF, CoP as measured and corrected."""

ASSUMPTIONS = (
    ("0.27 ± 0.22", "2.98 ± 1.62"),
    ("0.27 ± 0.20", "2.72 ± 1.37"),
    ("0.12 ± 0.16", "2.20 ± 1.19"),
    ("0.25 ± 0.21", "2.50 ± 1.71"),
    ("0.31 ± 0.16", "2.01 ± 1.56"),
)
"""Table II: GRF against weight, modelled CoP, against the manual calibration, by run."""

GUESS = ("about 7.5", "about 23")
CALIBRATED = ("about 0.35", "about 2.8")
"""Section VII, read off Fig. 8: GRF and CoP of the initial guess, self-calibrated."""
