"""The CoP correction of one shoe from known loads (paper, eqs. 4 to 6).

The paper calls eq. 6 a nonlinear least squares; the corrected CoP is linear in all of its
parameters, so one linear least squares gives the minimum. A hardly felt damping keeps
directions that no load identifies, such as a pattern of cell forces that a stiff plate never makes,
from being filled with noise.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from shoecal_core.arrays import FloatArray
from shoecal_core.manual.measurements import Measurements
from shoecal_core.manual.shoe_loads import ShoeLoads
from shoecal_core.shoe.correction import CopCorrection, features
from shoecal_core.shoe.shoe import FEET

COP_STD, TERM_STD = 1e-3, 20e-3
"""m; scatter of one load's CoP, and how large a term of the correction may be."""
LINES = 3
"""Rows and columns of holes that a second-order polynomial needs."""
FIXED = 1e-3
"""Smallest singular value of a fixed problem, over the largest."""
MISPLACED, MISPLACED_MEDIANS = 8e-3, 6.0
"""m, and in median errors: a load further off the others' prediction stood elsewhere."""


@dataclass(frozen=True)
class CorrectionFit:
    """A correction and what it does.

    Attributes:
        correction: fitted to every load.
        corrected: (N, 2) CoP by it [m].
        held_out: (N, 2) CoP of each load by a correction fitted to the others [m].
    """

    correction: CopCorrection
    corrected: FloatArray
    held_out: FloatArray


def fit_correction(loads: Measurements, found: ShoeLoads) -> CorrectionFit:
    """The correction of one shoe.

    Raises:
        ShoecalError: for loads that do not fix it, and for one that stood in another hole.
    """
    _check_fixed(loads, found)
    target = found.expected_cop - found.cop
    solved = [
        _solve(rows, target[:, axis])
        for axis, rows in enumerate(features(found.cop, found.outputs))
    ]
    (in_x, predicted_x, others_x), (in_y, predicted_y, others_y) = solved
    held_out = found.cop + np.stack((others_x, others_y), axis=1)
    _check_places(loads, found, held_out)
    correction = CopCorrection(
        foot=found.foot,
        x=in_x,
        y=in_y,
        cop_range=np.stack((found.cop.min(axis=0), found.cop.max(axis=0))),
        output_range=np.stack((found.outputs.min(axis=0), found.outputs.max(axis=0))),
    )
    return CorrectionFit(
        correction, found.cop + np.stack((predicted_x, predicted_y), axis=1), held_out
    )


def _solve(rows: FloatArray, target: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Damped least squares of rows (N, p) to a target (N,).

    Returns:
        The solution (p,), its prediction (N,), and each prediction by a solution without it (N,).
    """
    size = np.sqrt((rows**2).mean(axis=0))
    size[size == 0.0] = 1.0
    scaled = rows / size
    normal = scaled.T @ scaled + (COP_STD / TERM_STD) ** 2 * np.eye(len(size))
    hat = np.linalg.solve(normal, scaled.T)
    solution = hat @ target
    predicted = scaled @ solution
    leverage = np.clip((scaled * hat.T).sum(axis=1), 0.0, 1.0 - 1e-9)
    return solution / size, predicted, target - (target - predicted) / (1.0 - leverage)


def _check_fixed(loads: Measurements, found: ShoeLoads) -> None:
    """Refuse loads that leave parts of the polynomial or of the forces' terms open."""
    holes = loads.shoe.holes[found.foot]
    assert holes is not None, "loads stand in holes"
    places = np.array([holes.position(load.place) for load in found.loads])
    rows, columns = (len(np.unique(places[:, axis])) for axis in (0, 1))
    weights = len(np.unique(found.masses))
    side = FEET[found.foot]
    if rows < LINES or columns < LINES or weights < 2:
        raise loads.error(
            f"{side} shoe: {len(found.loads)} loads in {rows} rows and {columns} columns of holes, "
            f"of {weights} weight(s), do not fix the correction; load at least {LINES} rows and "
            f"{LINES} columns with 2 weights"
        )
    x, y = (places / np.abs(places).max(axis=0)).T
    force = found.masses / found.masses.max()
    for along, across in ((x, y), (y, x)):
        terms = (along**2, along, across, np.ones_like(x), force, force * along, force * across)
        singular = np.linalg.svd(np.stack(terms, axis=1), compute_uv=False)
        if len(found.loads) < len(terms) or singular[-1] < FIXED * singular[0]:
            raise loads.error(
                f"{side} shoe: {len(found.loads)} loads do not fix the correction; put every "
                "weight in more of the holes"
            )


def _check_places(loads: Measurements, found: ShoeLoads, held_out: FloatArray) -> None:
    """Refuse a load that stood where the others say it did not."""
    error = np.linalg.norm(held_out - found.expected_cop, axis=1)
    worst = int(np.argmax(error))
    if error[worst] <= max(MISPLACED, MISPLACED_MEDIANS * float(np.median(error))):
        return
    holes = loads.shoe.holes[found.foot]
    assert holes is not None, "loads stand in holes"
    # The shoe's own weight draws all CoPs a little: what is left of it by the hole's own CoP.
    at = holes.position(found.loads[worst].place) + held_out[worst] - found.expected_cop[worst]
    nearest = holes.names[int(np.argmin(np.linalg.norm(holes.positions - at, axis=1)))]
    raise loads.error(
        f"{found.loads[worst]}: reads {1e3 * error[worst]:.0f} mm away from it, near hole "
        f"{nearest}; read it again"
    )
