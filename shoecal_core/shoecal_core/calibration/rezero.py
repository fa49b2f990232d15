"""Offsets corrected from one standstill: cells drift, their gains hardly do.

The change d of the outputs is the smallest one, weighed by how uncertain each offset is, that
makes GRF and CoP what the model says: minimise d' S^-1 d subject to A d = r, so
d = S A' (A S A')^-1 r.
"""

from __future__ import annotations

import dataclasses
import hashlib

import numpy as np
from numpy.typing import NDArray

from shoecal_core.calibration.calibration import Calibration
from shoecal_core.errors import ShapeError, ShoecalError
from shoecal_core.model.kinematics import BodyStates
from shoecal_core.sensing.sensing import MINIMUM_FORCE
from shoecal_core.sensing.shoe import Shoe
from shoecal_core.sensing.wrench import (
    ChannelParameters,
    at_cop,
    columns_in_left,
    combined,
    cop,
    foot_wrenches,
)

FloatArray = NDArray[np.float64]

LOADED_SHARE = 0.1
"""A foot with less of the weight on it hangs in the air."""
DRIFT_STD = 0.1
"""How far any offset may have drifted since it was estimated [N or N m]."""
ITERATIONS = 5
"""The CoP correction depends a little on the outputs."""


class RezeroError(ShoecalError):
    """Offsets that cannot be corrected here."""


def rezero(
    calibration: Calibration,
    shoe: Shoe,
    readings: FloatArray,
    body: BodyStates,
    *,
    largest: float,
    made_ns: int,
) -> tuple[Calibration, FloatArray]:
    """A calibration with corrected offsets, and what was added to each (n,) [N or N m].

    Args:
        calibration: in force.
        shoe: its shoes.
        readings: (n,) mean raw readings of a standstill.
        body: one sample of the same standstill.
        largest: change that is still a drift [N or N m].
        made_ns: time stamp of the new calibration [ns].

    Raises:
        RezeroError: when a change is no drift any more.
        WrongShoeError, ShapeError: for another shoe's calibration or readings.
    """
    calibration.sensing(shoe)
    if readings.shape != (len(shoe.names),) or not np.isfinite(readings).all():
        raise ShapeError("readings", f"({len(shoe.names)},) finite", readings.shape)
    outputs = calibration.parameters.outputs(readings)
    force = foot_wrenches(shoe, outputs)[:, 0]
    loaded = force > LOADED_SHARE * calibration.weight
    spread = _uncertainty(calibration)
    change = np.zeros(len(outputs))
    for _ in range(ITERATIONS):
        matrix, missing = _equations(calibration, shoe, outputs + change, body, loaded)
        gain = spread @ matrix.T
        change = change + gain @ np.linalg.solve(matrix @ gain, missing)
    worst = int(np.argmax(np.abs(change)))
    if abs(change[worst]) > largest:
        raise RezeroError(
            f"'{shoe.names[worst]}' is off by {change[worst]:.2f} N, more than a drift "
            f"({largest:g} N): see that nothing touches the robot, else calibrate anew"
        )
    old = calibration.parameters
    parameters = ChannelParameters(old.gain, old.offset + change)
    digest = hashlib.sha256(parameters.offset.tobytes() + str(made_ns).encode()).hexdigest()
    fresh = dataclasses.replace(
        calibration,
        id=f"rezero-{digest[:12]}",
        source="rezero",
        made_ns=made_ns,
        parameters=parameters,
        reasons=(*calibration.reasons, f"offsets of '{calibration.id}' corrected at a standstill"),
    )
    return fresh, change


def _uncertainty(calibration: Calibration) -> FloatArray:
    """(n, n) covariance of the offsets as they are now."""
    count = len(calibration.channels)
    drift = DRIFT_STD**2 * np.eye(count)
    if calibration.covariance is None:
        return drift
    return calibration.covariance[count:, count:] + drift


def _equations(
    calibration: Calibration,
    shoe: Shoe,
    outputs: FloatArray,
    body: BodyStates,
    loaded: NDArray[np.bool_],
) -> tuple[FloatArray, FloatArray]:
    """A (k, n) and r (k,): wrenches that the model expects, less those measured."""
    wrenches = foot_wrenches(shoe, outputs)
    for correction in calibration.corrections:
        foot = correction.foot
        if loaded[foot]:
            place = correction.correct(
                cop(wrenches[foot], MINIMUM_FORCE), outputs[shoe.of_foot(foot)]
            )
            wrenches[foot] = at_cop(wrenches[foot, 0], place)
    weight = np.array(calibration.weight)
    if loaded.all():
        support = body.support()
        wanted = at_cop(weight, body.cop[0, 0])
        return columns_in_left(shoe, support).T, wanted - combined(wrenches, support)
    rows, missing = [], []
    for foot in (0, 1):
        wanted = at_cop(weight, body.cop[0, foot]) if loaded[foot] else np.zeros(3)
        rows.append(np.where((shoe.foot == foot)[:, None], shoe.columns, 0.0).T)
        missing.append(wanted - wrenches[foot])
    return np.concatenate(rows), np.concatenate(missing)
