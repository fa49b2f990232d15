"""Offsets corrected from one standstill: cells drift, their gains hardly do.

A standstill gives k differences e between measured and modelled values (`standstill`), a drift of
the n offsets has more directions. The change d of the offsets is the smallest one, weighed by how
uncertain each offset is under the gains as they are, that takes the differences away: minimise
d' S^-1 d subject to H d = -e, so d = -K e with K = S H' (H S H')^-1. After it, gains and offsets
have the covariance (1 - K J) P (1 - K J)' + K R K', with J the differences' derivatives by gains,
offsets and columns, P the covariance before with the drift added, and R that of weight and model:
what was corrected is known as well as they are, whatever it shares with them. The error of a weight
that the gains were fitted to is no part of R: it is no error of single channels, and is stated by
itself (`stated_error`).
"""

from __future__ import annotations

import dataclasses
import hashlib
from dataclasses import dataclass

import numpy as np

from shoecal_core.arrays import BoolArray, FloatArray
from shoecal_core.errors import ShoecalError
from shoecal_core.estimation.calibration import Calibration
from shoecal_core.estimation.checks.drift import Drift, drift_of, shares_model
from shoecal_core.estimation.checks.standstill import (
    ModelTolerance,
    StandstillResiduals,
    compare,
    hanging_feet,
)
from shoecal_core.robot.kinematics import BodyStates
from shoecal_core.shoe.priors import TORQUE_LEVER_M
from shoecal_core.shoe.shoe import Shoe
from shoecal_core.shoe.wrench import ChannelParameters

DRIFT_STD = 0.1
"""How far an offset drifts in an hour or longer, where no sign of more is seen [N]."""
DRIFT_TIME_S = 3600.0
LEAST_DRIFT = 0.01
"""Share of that variance which is there at once."""
EQUAL_N = 0.05
"""How far the GRF of a robot at rest is off the weight once corrected to it [N]."""
ITERATIONS = 5
"""The CoP depends on the offsets a little otherwise than to first order."""


class RezeroError(ShoecalError):
    """Offsets that cannot be corrected here."""


@dataclass(frozen=True)
class Rezeroed:
    """What a standstill could correct.

    Attributes:
        calibration: with corrected offsets; the same one where nothing was to be corrected.
        change: (n,) what was added to each offset [N or N m].
        directions: of the offsets that were corrected.
        before, after: differences to weight and model; None where no foot was loaded.
        where: the standstill, in words.
    """

    calibration: Calibration
    change: FloatArray
    directions: int
    before: Drift | None
    after: Drift | None
    where: str

    @property
    def summary(self) -> str:
        """One line."""
        if not self.directions:
            assert self.before is not None
            return (
                f"nothing corrected: {self.before.reason}; that is no more than weight and model "
                "may be off, so the offsets stay as calibrated"
            )
        done = "the feet in the air read zero again"
        if self.before is not None and self.after is not None:
            grf = abs(self.after.grf_error - self.before.grf_error)
            cop = abs(self.before.cop_error - self.after.cop_error)
            done = f"corrected GRF by {grf:.2f} N and CoP by {1e3 * cop:.1f} mm"
        return (
            f"{done}; from {self.where} {self.directions} of {len(self.change)} directions of the "
            "offsets can be corrected, the rest stays as calibrated"
        )


def rezero(
    calibration: Calibration,
    shoe: Shoe,
    readings: FloatArray,
    body: BodyStates,
    tolerance: ModelTolerance,
    *,
    largest: float,
    made_ns: int,
    temperature: float = float("nan"),
) -> Rezeroed:
    """Correct offsets so that measured values become the modelled ones.

    A calibration that knows forces from elsewhere (a manual one) keeps GRF or CoP where they are
    off by no more than weight and model may be: they would make it worse.

    Args:
        calibration: in force.
        shoe: its shoes.
        readings: (n,) mean raw readings of a standstill.
        body: one sample of the same standstill.
        tolerance: of weight and modelled CoP.
        largest: change that is still a drift [N or N m].
        made_ns: time stamp of the new calibration [ns].
        temperature: of the shoes at the standstill [degC], NaN where unknown.

    Raises:
        RezeroError: when a change is no drift any more.
        WrongShoeError, ShapeError: for another shoe's calibration or readings.
    """
    hanging = hanging_feet(calibration, shoe, readings, body)
    found = compare(calibration, shoe, readings, body, hanging, tolerance)
    before = drift_of(found, calibration, readings) if found.loaded else None
    chosen = _better_known(calibration, before, len(found.error))
    if not chosen.any():
        nothing = np.zeros(len(shoe.names))
        return Rezeroed(calibration, nothing, 0, before, before, found.where)
    prior = _prior(calibration, shoe, found, chosen, made_ns)
    spread = _offsets_under_gains(prior)
    fresh = calibration
    for _ in range(ITERATIONS):
        gain = _gain(spread, found.slopes[chosen])
        fresh = _with_offsets(fresh, fresh.parameters.offset - gain @ found.error[chosen])
        found = compare(fresh, shoe, readings, body, hanging, tolerance)
    change = fresh.parameters.offset - calibration.parameters.offset
    _require_drift(shoe, change, largest)
    if calibration.covariance is not None:
        known = found.tolerance.copy()
        if found.loaded and shares_model(calibration):
            # The weight's error is in all gains alike, and stated by itself.
            known[0] = EQUAL_N
        fresh = _with_covariance(
            fresh, _updated(prior, spread, found, chosen, readings, known[chosen])
        )
    return Rezeroed(
        calibration=_signed(calibration, fresh, made_ns, temperature),
        change=change,
        directions=int(chosen.sum()),
        before=before,
        after=drift_of(found, fresh, readings) if found.loaded else None,
        where=found.where,
    )


def _better_known(calibration: Calibration, before: Drift | None, count: int) -> BoolArray:
    """(k,) which differences are better known by weight and model than by the calibration."""
    chosen = np.ones(count, dtype=bool)
    if before is not None and not shares_model(calibration):
        chosen[0] = before.grf_beyond
        chosen[1:3] = before.cop_beyond
    return chosen


def _prior(
    calibration: Calibration,
    shoe: Shoe,
    found: StandstillResiduals,
    chosen: BoolArray,
    made_ns: int,
) -> FloatArray:
    """(5n, 5n) covariance of gains, offsets and columns by now: what is not known has drifted.

    The drift is as large as time makes it, or as the differences show: the least change that
    takes them away is k / n of it in variance.
    """
    count = len(shoe.names)
    size = np.where(shoe.torque, TORQUE_LEVER_M, 1.0)
    age = (made_ns - calibration.made_ns) / 1e9 / DRIFT_TIME_S
    share = min(max(age, LEAST_DRIFT), 1.0) if age >= 0.0 else 1.0
    least = np.linalg.pinv(found.slopes[chosen] * size) @ found.error[chosen]
    drift = max(DRIFT_STD**2 * share, float(least @ least) / int(chosen.sum()))
    joint = calibration.joint_covariance
    prior = np.zeros((5 * count, 5 * count)) if joint is None else joint
    prior[count : 2 * count, count : 2 * count] += drift * np.diag(size**2)
    return prior


def _offsets_under_gains(prior: FloatArray) -> FloatArray:
    """(n, n) covariance of the offsets where the gains stay as they are."""
    count = len(prior) // 5
    gain, offset = slice(count), slice(count, 2 * count)
    gains, mixed, offsets = prior[gain, gain], prior[offset, gain], prior[offset, offset]
    return np.asarray(offsets - mixed @ np.linalg.pinv(gains, hermitian=True) @ mixed.T)


def _gain(spread: FloatArray, slopes: FloatArray) -> FloatArray:
    """(n, k) K."""
    shift = spread @ slopes.T
    return np.asarray(np.linalg.solve(slopes @ shift, shift.T).T)


def _updated(
    prior: FloatArray,
    spread: FloatArray,
    found: StandstillResiduals,
    chosen: BoolArray,
    readings: FloatArray,
    known: FloatArray,
) -> FloatArray:
    """(5n, 5n) covariance of gains, offsets and columns after the change."""
    gain = _gain(spread, found.slopes[chosen])
    whole = np.zeros((len(prior), gain.shape[1]))
    whole[len(gain) : 2 * len(gain)] = gain
    kept = np.eye(len(prior)) - whole @ found.joint_jacobian(readings)[chosen]
    added = whole * known
    return np.asarray(kept @ prior @ kept.T + added @ added.T)


def _with_offsets(calibration: Calibration, offset: FloatArray) -> Calibration:
    parameters = ChannelParameters(calibration.parameters.gain, offset)
    return dataclasses.replace(calibration, parameters=parameters)


def _with_covariance(calibration: Calibration, joint: FloatArray) -> Calibration:
    own = 2 * len(calibration.channels)
    columns = None if calibration.column_covariance is None else joint[own:]
    return dataclasses.replace(calibration, covariance=joint[:own, :own], column_covariance=columns)


def _require_drift(shoe: Shoe, change: FloatArray, largest: float) -> None:
    worst = int(np.argmax(np.abs(change)))
    if abs(change[worst]) > largest:
        raise RezeroError(
            f"'{shoe.names[worst]}' is off by {change[worst]:.2f} N, more than a drift "
            f"({largest:g} N): see that nothing touches the robot, else calibrate again"
        )


def _signed(
    calibration: Calibration, fresh: Calibration, made_ns: int, temperature: float
) -> Calibration:
    """The new calibration under its own name; however often offsets are corrected, one reason."""
    digest = hashlib.sha256(fresh.parameters.offset.tobytes() + str(made_ns).encode()).hexdigest()
    reasons = calibration.reasons
    if calibration.source != "rezero":
        reasons = (*reasons, f"offsets of '{calibration.id}' corrected at standstills since")
    return dataclasses.replace(
        fresh,
        id=f"rezero-{digest[:12]}",
        source="rezero",
        made_ns=made_ns,
        temperature=calibration.temperature if np.isnan(temperature) else temperature,
        reasons=reasons,
    )
