"""One standstill under a calibration: what the shoes say, less what weight and model say.

On both feet, or on one while the other hangs, GRF and CoP are compared with the robot's weight
and the modelled CoP; a hanging foot's wrench is zero.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from shoecal_core.arrays import FloatArray
from shoecal_core.errors import ShapeError
from shoecal_core.estimation.calibration import Calibration
from shoecal_core.robot.gravity import GRAVITY
from shoecal_core.robot.kinematics import BodyStates
from shoecal_core.robot.robot import Robot
from shoecal_core.screening.settings import CalibrationSettings
from shoecal_core.shoe.sensing import Measured
from shoecal_core.shoe.shoe import FEET, Shoe
from shoecal_core.shoe.wrench import (
    by_parameters,
    columns_in_left,
    combined,
    cop_jacobian,
    foot_wrenches,
    to_left,
)

LIFTED_M, LIFTED_SHARE = 0.005, 0.25
"""A foot so much higher than the other one, with less of the weight on it, is off the floor."""
AIR_SHARE = 0.2
"""With less of the weight on both feet together the robot is held in the air."""
HANGING_STD = np.array([0.05, 0.002, 0.002])
"""How far a hanging foot's wrench is off zero: what its plates weigh more or less [N, N m]."""


@dataclass(frozen=True)
class ModelTolerance:
    """Standard deviations of what a standstill is compared with.

    Attributes:
        force: of the weight [N].
        cop: of the modelled CoP, each axis [m].
    """

    force: float
    cop: float

    @classmethod
    def of(cls, robot: Robot, settings: CalibrationSettings) -> ModelTolerance:
        """As the robot file and the settings of the fit state them."""
        return cls(max(robot.mass_std * GRAVITY, settings.force_std_n), settings.cop_std_m)


@dataclass(frozen=True)
class StandstillResiduals:
    """k differences of a standstill: where any foot is loaded those of GRF, CoP x and CoP y,
    then F, Mx, My of each hanging foot.

    Attributes:
        hanging: which feet hang, left and right.
        error: (k,) measured less modelled [N, m, N m].
        slopes: (k, n) of the differences to the channels' outputs.
        column_slopes: (k, 3n) of them to the channels' columns, channel by channel.
        tolerance: (k,) standard deviations of what they are compared with.
    """

    hanging: tuple[bool, bool]
    error: FloatArray
    slopes: FloatArray
    column_slopes: FloatArray
    tolerance: FloatArray

    @property
    def loaded(self) -> bool:
        """Whether any foot carries the robot."""
        return not all(self.hanging)

    @property
    def grf(self) -> float:
        """Of the loaded feet, less the weight [N]; NaN where none is loaded."""
        return float(self.error[0]) if self.loaded else float("nan")

    @property
    def cop(self) -> float:
        """Distance from the modelled CoP [m]; NaN where no foot is loaded."""
        return float(np.linalg.norm(self.error[1:3])) if self.loaded else float("nan")

    @property
    def where(self) -> str:
        """In words."""
        if not any(self.hanging):
            return "one double support"
        if not self.loaded:
            return "both feet in the air"
        return f"one stand with the {FEET[self.hanging.index(True)]} foot lifted"

    def variance(self, readings: FloatArray, covariance: FloatArray | None) -> FloatArray:
        """(k, k) of the differences by what a calibration leaves open; 0 for None.

        Args:
            readings: (n,) what the gains multiply.
            covariance: (2n, 2n) of gains and offsets, or (5n, 5n) of columns, too.
        """
        if covariance is None:
            return np.zeros((len(self.error), len(self.error)))
        jacobian = self.joint_jacobian(readings)[:, : len(covariance)]
        variance: FloatArray = jacobian @ covariance @ jacobian.T
        return variance

    def jacobian(self, readings: FloatArray) -> FloatArray:
        """(k, 2n) of the differences to gains and offsets."""
        return by_parameters(self.slopes, readings)

    def joint_jacobian(self, readings: FloatArray) -> FloatArray:
        """(k, 5n) of the differences to gains, offsets and columns."""
        return np.hstack((self.jacobian(readings), self.column_slopes))


def hanging_feet(
    calibration: Calibration, shoe: Shoe, readings: FloatArray, body: BodyStates
) -> tuple[bool, bool]:
    """Which feet hang: those with little load and lifted by the joint angles; both in the air.

    Args:
        calibration: in force.
        shoe: its shoes.
        readings: (n,) mean raw readings of a standstill.
        body: one sample of the same standstill.

    Raises:
        WrongShoeError, ShapeError: for another shoe's calibration or readings.
    """
    if readings.shape != (len(shoe.names),) or not np.isfinite(readings).all():
        raise ShapeError("readings", f"({len(shoe.names)},) finite", readings.shape)
    share = calibration.sensing(shoe).measure(readings).grf / calibration.weight
    if share.sum() < AIR_SHARE:
        return True, True
    height = float(body.translation[0, 2])
    return (
        bool(share[0] < LIFTED_SHARE) and height < -LIFTED_M,
        bool(share[1] < LIFTED_SHARE) and height > LIFTED_M,
    )


def compare(
    calibration: Calibration,
    shoe: Shoe,
    readings: FloatArray,
    body: BodyStates,
    hanging: tuple[bool, bool],
    tolerance: ModelTolerance,
) -> StandstillResiduals:
    """The differences of one standstill.

    Args:
        calibration, shoe, body: as `hanging_feet`, which gives `hanging`.
        readings: (n,) likewise.
        hanging: which feet hang.
        tolerance: of weight and modelled CoP.
    """
    sensing = calibration.sensing(shoe)
    shoe = sensing.shoe
    outputs = sensing.parameters.outputs(readings)
    parts = [_hanging_foot(shoe, foot, outputs) for foot, hangs in enumerate(hanging) if hangs]
    if not all(hanging):
        standing = _standing(calibration, shoe, outputs, sensing.measure(readings), body, hanging)
        known = np.array([tolerance.force, tolerance.cop, tolerance.cop])
        parts.insert(0, (*standing, known))
    joined = [np.concatenate([part[item] for part in parts]) for item in range(4)]
    return StandstillResiduals(hanging, *joined)


def _standing(
    calibration: Calibration,
    shoe: Shoe,
    outputs: FloatArray,
    measured: Measured,
    body: BodyStates,
    hanging: tuple[bool, bool],
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Errors (3,), slopes (3, n) and column slopes (3, 3n) of GRF and CoP of feet that stand."""
    wrenches = foot_wrenches(shoe, outputs)
    turns = np.broadcast_to(np.eye(3), (len(outputs), 3, 3))
    if any(hanging):
        foot = hanging.index(False)
        columns, wrench = _of_foot(shoe, foot), wrenches[foot]
        turns = np.where((shoe.foot == foot)[:, None, None], turns, 0.0)
        force, place = measured.grf[foot], measured.cop[foot]
    else:
        foot, support = 0, body.support()
        columns, wrench = columns_in_left(shoe, support), combined(wrenches, support)
        turns = np.where((shoe.foot == 1)[:, None, None], to_left(support), turns)
        force, place = measured.total_grf, measured.combined_cop(support)
    error = np.concatenate(([force - calibration.weight], place - body.cop[0, foot]))
    slopes = cop_jacobian(wrench)
    return error, slopes @ columns.T, _by_columns(slopes, turns, outputs)


def _hanging_foot(
    shoe: Shoe, foot: int, outputs: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    own = np.where((shoe.foot == foot)[:, None, None], np.eye(3), 0.0)
    return (
        foot_wrenches(shoe, outputs)[foot],
        _of_foot(shoe, foot).T,
        _by_columns(np.eye(3), own, outputs),
        HANGING_STD,
    )


def _by_columns(slopes: FloatArray, turns: FloatArray, outputs: FloatArray) -> FloatArray:
    """(k, 3n) slopes to columns, of slopes (k, 3) to a wrench that each channel's (n, 3, 3) turns
    take it into.
    """
    found: FloatArray = np.einsum("kw,nwc,n->knc", slopes, turns, outputs)
    return found.reshape(len(slopes), -1)


def _of_foot(shoe: Shoe, foot: int) -> FloatArray:
    """(n, 3) columns of one foot's channels, zero for the other's."""
    return np.where((shoe.foot == foot)[:, None], shoe.columns, 0.0)
