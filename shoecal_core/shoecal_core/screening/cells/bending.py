"""Cells that do not answer in proportion to their load, by the vertical force of both feet alone.

Whatever the robot's model says of the CoP, the vertical forces add up to its weight. Squares of the
readings b_i let cells bend,
    sum_i A_i (g_i S_i + d_i + b_i u_i^2) = w - b,    u_i = (S_i - mean) / (half the range),
and where they take away most of what the forces are off that sum, that is why.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from shoecal_core.screening.faults import Fault
from shoecal_core.screening.rough_fit import Statics, solve
from shoecal_core.screening.verdict import Finding
from shoecal_core.shoe.shoe import Shoe

LARGEST_N = 5.0
"""Standard deviation of what is believed of a bend at both ends of the range."""
LEFT, LEAST_DROP = 0.5, 30.0
"""Of the squares of the vertical force, what bending cells leave at most, and by how much these
have to fall. Cells that answer 20 % less at full load leave 0.02, one that touches its shell 0.4;
sound recordings, simulated and real, hardly change (below 4, by less than 1)."""
NAMED_N, NAMED_STDS = 0.3, 3.0
"""Bends from which a cell is listed."""


@dataclass(frozen=True)
class Bending:
    """Cells that bend.

    Attributes:
        channels: indices, the one that bends most first.
        force: of each, by how much it is off a line at the ends of its range [N].
    """

    channels: tuple[int, ...]
    force: tuple[float, ...]


def bending(statics: Statics) -> Bending | None:
    """Vertical channels that bend; None where lines fit as well."""
    shoe, parts, rows = statics.shoe, statics.parts, statics.robust
    vertical = np.flatnonzero(shoe.vertical)
    readings = np.concatenate([one.readings for one in parts.values()])[:, vertical]
    middle, half = readings.mean(axis=0), np.maximum(np.ptp(readings, axis=0) / 2.0, 1e-12)
    # Bends are forces, as offsets are.
    bent = {
        run: one.with_columns(
            one.matrix[:, :, len(shoe.names) + vertical]
            * ((parts[run].readings[:, vertical] - middle) / half) ** 2
        )
        for run, one in rows.items()
    }
    largest = np.full(len(vertical), LARGEST_N**-2.0)
    fit = solve(bent, np.concatenate((statics.information, largest)))
    before, after = (
        sum(one.force_squares(vector) for one in equations.values())
        for equations, vector in ((rows, statics.fit.vector), (bent, fit.vector))
    )
    if after > min(LEFT * before, before - LEAST_DROP):
        return None
    first = 2 * len(shoe.names)
    force = np.abs(fit.vector[first:])
    std = np.sqrt(np.diag(fit.covariance)[first:])
    order = [k for k in np.argsort(-force) if force[k] > max(NAMED_N, NAMED_STDS * std[k])]
    if not order:
        return None
    return Bending(tuple(vertical[order].tolist()), tuple(force[order].tolist()))


def describe_bending(shoe: Shoe, found: Bending | None, *, refused: bool = False) -> list[Finding]:
    """Cells that bend; refused where forces are off by as much as with a rope on the robot."""
    if found is None:
        return []
    named = ", ".join(
        f"{shoe.names[channel]} {force:.1f} N"
        for channel, force in zip(found.channels, found.force, strict=True)
    )
    return [
        Finding(
            "FAIL" if refused else "WARN",
            f"readings do not grow in proportion to the load (off a line at the ends of the "
            f"range: {named}): see that no cell touches its shell or is bent, straighten the "
            "readings of sensors that bend by nature (force sensing resistors, voltage dividers) "
            "by their data sheets' curve before they are recorded; `shoecal diagnose` shows it",
            Fault.BENT,
        )
    ]
