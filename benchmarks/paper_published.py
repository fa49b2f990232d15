"""Figures of Han, Jiang and Chirikjian, Watch Me Calibrate My Force-Sensing Shoes!, typed once."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Published:
    """A mean absolute error; the standard deviation where the paper gives it."""

    mean: float
    std: float | None = None

    def __str__(self) -> str:
        return f"{self.mean:g}" if self.std is None else f"{self.mean:.2f} ± {self.std:.2f}"


@dataclass(frozen=True)
class ManualRow:
    """One shoe: GRF [N], CoP as measured and corrected [mm]."""

    grf: Published
    cop_before: Published
    cop_after: Published


MANUAL = {
    "left": ManualRow(Published(0.02, 0.01), Published(4.53, 1.89), Published(1.07, 0.62)),
    "right": ManualRow(Published(0.03, 0.03), Published(3.51, 1.90), Published(0.76, 0.35)),
}
"""Table I."""

ASSUMPTIONS = (
    (Published(0.27, 0.22), Published(2.98, 1.62)),
    (Published(0.27, 0.20), Published(2.72, 1.37)),
    (Published(0.12, 0.16), Published(2.20, 1.19)),
    (Published(0.25, 0.21), Published(2.50, 1.71)),
    (Published(0.31, 0.16), Published(2.01, 1.56)),
)
"""Table II: GRF against weight [N], modelled CoP [mm], against the manual calibration, by run."""

GUESS = (Published(7.5), Published(23.0))
CALIBRATED = (Published(0.35), Published(2.8))
"""Section VII, read off Fig. 8: GRF [N] and CoP [mm] of the initial guess, self-calibrated."""
