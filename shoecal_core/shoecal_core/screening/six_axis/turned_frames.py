"""Frames of six-axis sensors that are turned about the sole's vertical axis by any angle.

A frame that is turned mixes the moments of its two axes, which gains alone do not. The angle of
each foot is fitted with them. Turns by right angles look like cables; see `wiring`.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import product

import numpy as np
from scipy.optimize import minimize

from shoecal_core.arrays import FloatArray
from shoecal_core.screening.faults import Fault
from shoecal_core.screening.rough_fit import Statics, solve
from shoecal_core.screening.six_axis.sideways import AXES
from shoecal_core.screening.verdict import Finding
from shoecal_core.shoe.shoe import FEET, Shoe

PAIRS = (AXES, ("mx", "my"))
"""Axes that a turn about the vertical mixes."""
LEAST_RAD, MOST_RAD = np.radians(5.0), np.radians(60.0)
"""Frames that are turned by less are mounted well; by more they look like exchanged axes."""
LEFT_SHARE = 0.6
"""Of the sum of squares, that the turn leaves at most: 10 degrees of both feet leave 0.33, of one
0.52. Four sound sessions kept 0.97 or more, by angles up to 1.7 degrees; other faults 0.74."""
START_RAD = np.radians(10.0)
"""Besides zero, the angles from which the fit may start: far off its cost is no parabola. Where
zero is the best of them, frames are off by about LEAST_RAD at most."""


def turned_frames(statics: Statics) -> FloatArray | None:
    """(2,) by how much the frame of each foot is turned, counterclockwise from above [rad].

    None where nothing is, and for shoes without moments.
    """
    shoe = statics.shoe
    names = [f"{foot}/{axis}" for foot in FEET for axis in PAIRS[1]]
    if not set(names) <= set(shoe.names):
        return None

    def cost(angles: FloatArray) -> float:
        turned = statics.changed(
            lambda one: replace(one, columns=_turned(shoe, one.columns, angles))
        )
        return solve(turned.rows, statics.information).cost

    starts = [np.array(pair) for pair in product((-START_RAD, 0.0, START_RAD), repeat=2)]
    start = min(starts, key=cost)
    if not start.any():
        return None
    best = minimize(cost, start, method="BFGS", options={"gtol": 1e-2})
    angles: FloatArray = best.x
    if not LEAST_RAD < np.abs(angles).max() < MOST_RAD:
        return None
    return angles if best.fun < LEFT_SHARE * cost(np.zeros(2)) else None


def describe_turned_frames(angles: FloatArray | None) -> list[Finding]:
    """Frames to turn back, by angles (2,) [rad]."""
    if angles is None:
        return []
    turned = " and ".join(
        f"{name} by {np.degrees(angle):+.0f} degrees"
        for name, angle in zip(FEET, angles, strict=True)
        if abs(angle) > LEAST_RAD
    )
    return [
        Finding(
            "FAIL",
            f"frames of the six-axis sensors look turned about z, counterclockwise from above: "
            f"{turned}; correct them where the sensor is mounted, in the URDF, or at its driver, "
            "and record again",
            Fault.SWAPPED,
        )
    ]


def _turned(shoe: Shoe, columns: FloatArray, angles: FloatArray) -> FloatArray:
    """Columns (n, 3) of sensors whose frames are turned by angles (2,) [rad]."""
    turned = columns.copy()
    for (foot, angle), axes in product(zip(FEET, angles.tolist(), strict=True), PAIRS):
        pair = [f"{foot}/{axis}" for axis in axes]
        if set(pair) <= set(shoe.names):
            along, across = map(shoe.index, pair)
            c, s = np.cos(angle), np.sin(angle)
            turned[along] = c * columns[along] + s * columns[across]
            turned[across] = -s * columns[along] + c * columns[across]
    return turned
