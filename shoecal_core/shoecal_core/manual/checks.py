"""May a manual calibration be used?"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations

import numpy as np

from shoecal_core.arrays import FloatArray
from shoecal_core.estimation.checks.usable import GAIN_RATIO
from shoecal_core.estimation.series import Mae
from shoecal_core.manual.cells import CellFit, unlike_gains
from shoecal_core.robot.gravity import GRAVITY
from shoecal_core.screening.verdict import Finding
from shoecal_core.shoe.shoe import FEET, Shoe

GRF_LIMITS = (0.15, 0.5)
COP_LIMITS = (2e-3, 5e-3)
"""N and m; MAE under known weights above which there is a warning, and no use."""
BEFORE_LIMIT = 0.015
"""m; MAE of an assembled shoe's CoP before it is corrected. Sound shoes come to 4 mm, holes that
were counted from the other side to 34 mm; the correction leaves 0.7 mm of these, in the holes."""
LINE_LIMITS = (0.01, 0.05)
"""Scatter of a cell about its line, over its largest load, above which there is a warning, and no
use: cells are straight to 0.1 %, hands to a few."""
EXCHANGED = 0.01
"""Of the squares about a line, what two exchanged weights leave at most: noise is far below."""
SHIFT_LIMIT = 5.0
"""N; screwing a cell in seldom shifts its zero by more."""
FULL_SHARE = 0.5
"""Loads read, of those planned: fewer leave the correction to few of them."""


def check_cells(shoe: Shoe, gain: FloatArray) -> list[Finding]:
    """Gains (n,) [N/unit] of the wrong sign or of a size unlike the others'."""
    findings = [
        Finding(
            "FAIL",
            f"{name} has gain {value:g}, the others about {typical:g}: check its weight and that "
            "nothing else bore it",
        )
        for name, value, typical in unlike_gains(shoe, gain, GAIN_RATIO)
    ]
    for name, value, polarity in zip(shoe.names, gain, shoe.polarity, strict=True):
        if polarity and np.sign(value) != polarity:
            findings.append(
                Finding(
                    "FAIL",
                    f"{name} has the other sign than its polarity in {shoe.path.name}: correct the "
                    "wiring or the file",
                )
            )
    return findings


def check_lines(fits: Sequence[CellFit]) -> list[Finding]:
    """Cells whose readings do not lie on a line."""
    warn, fail = (GRAVITY * limit for limit in LINE_LIMITS)
    return [
        Finding(
            "FAIL" if fit.residual_std > fail * fit.masses.max() else "WARN",
            f"{fit.name} scatters by {fit.residual_std:.2f} N about its line"
            f"{_exchanged(fit)}: read it again",
        )
        for fit in fits
        if fit.residual_std > warn * fit.masses.max()
    ]


def _exchanged(fit: CellFit) -> str:
    """Two weights that make a line of the readings at each other's place, in words; or nothing."""
    left = {}
    for one, other in combinations(range(len(fit.masses)), 2):
        masses = fit.masses.copy()
        masses[[one, other]] = masses[[other, one]]
        line = np.polyfit(fit.readings, masses, 1)
        left[one, other] = float(np.square(np.polyval(line, fit.readings) - masses).sum())
    one, other = min(left, key=lambda pair: left[pair])
    straight = GRAVITY**2 * left[one, other] < EXCHANGED * np.square(fit.residuals).sum()
    names = f"{fit.masses[one]:g} and {fit.masses[other]:g} kg"
    return f", and does not with {names} exchanged" if straight else ""


def check_foot(
    foot: int, grf: Mae, before: Mae | None, cop: Mae | None, shift: FloatArray
) -> list[Finding]:
    """Errors of one shoe under its weights.

    Args:
        foot: index into FEET.
        grf: error of the force [N].
        before, cop: error of the CoP without and with its correction [m]; None where the channels
            give a force alone.
        shift: (k,) what assembling added to the offsets [N].
    """
    findings = []
    side = FEET[foot]
    if cop is None:
        reason = f"the channels of the {side} shoe give a force alone: it has a GRF, but no CoP"
        findings.append(Finding("WARN", reason))
    judged = [("GRF", grf, GRF_LIMITS, "N", 1.0)]
    if cop is not None:
        judged.append(("CoP", cop, COP_LIMITS, "mm", 1e3))
    for name, mae, limits, unit, scale in judged:
        for verdict, limit in (("FAIL", limits[1]), ("WARN", limits[0])):
            if not mae.mean <= limit:
                findings.append(
                    Finding(
                        verdict,
                        f"{name} of the {side} shoe is {mae.mean * scale:.2f} {unit} off under "
                        f"known weights (limit {limit * scale:.2f} {unit}): check the weights, and "
                        "that the shoe stands flat and free",
                    )
                )
                break
    if before is not None and before.mean > BEFORE_LIMIT:
        findings.append(
            Finding(
                "FAIL",
                f"CoP of the {side} shoe is {before.mean * 1e3:.0f} mm off before its correction "
                f"(limit {BEFORE_LIMIT * 1e3:.0f} mm): check that its holes were counted from the "
                "right side, and where the shoe file says that holes and cells are",
            )
        )
    if np.abs(shift).max() > SHIFT_LIMIT:
        findings.append(
            Finding(
                "WARN",
                f"assembling shifted the {side} shoe's offsets by up to {np.abs(shift).max():.1f} "
                "N: see that no cell is bent by its screws, or read the cells again",
            )
        )
    return findings


def check_plan(foot: int, read: int, planned: int) -> list[Finding]:
    """Many loads that were left out."""
    if read >= FULL_SHARE * planned:
        return []
    return [
        Finding("WARN", f"{read} of {planned} loads of the {FEET[foot]} shoe read: read more holes")
    ]
