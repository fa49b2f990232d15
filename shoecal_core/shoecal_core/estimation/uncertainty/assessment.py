"""How certain a calibration is, and which of its directions the data identify."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from shoecal_core.arrays import FloatArray
from shoecal_core.error_sources.tolerances import Tolerances
from shoecal_core.estimation.checks.accuracy import Misfit
from shoecal_core.estimation.fit import SelfCalibration
from shoecal_core.estimation.joint_fit import JointFit
from shoecal_core.estimation.uncertainty.another_run import AnotherRun, another_run
from shoecal_core.estimation.uncertainty.budget import Budget, budget
from shoecal_core.estimation.uncertainty.expected import ErrorModel, Spread, support_covariance
from shoecal_core.planning.settings import PlannerSettings
from shoecal_core.planning.supports.identifiability import (
    Identifiability,
    best_addition,
    identifiability,
)
from shoecal_core.planning.supports.observability import (
    from_relative,
    observable,
    reference_information,
    relative_information,
)
from shoecal_core.robot.double_support import DoubleSupport
from shoecal_core.robot.robot import Robot
from shoecal_core.samples.stance import Stance
from shoecal_core.screening.settings import CalibrationSettings
from shoecal_core.shoe.shoe import FEET, Shoe

NORMAL_95 = 1.96
"""Half the width of a 95 % interval, in standard deviations."""


@dataclass(frozen=True)
class Assessment:
    """What is known of a calibration's n channels besides their numbers.

    Attributes:
        covariance: (2n + 1,) squared, of gains, offsets and time offset.
        error_model: of the expected errors at any load.
        both, left, right: expected errors over the sensing polygons: see `ErrorModel`.
        budget: where they come from; None for a walk, whose model errors are not known.
        another: the training run to record once more, and what that would win; None likewise.
        identifiability: by the data themselves: rank, singular values, weak directions.
        support_to_add: double support that would fix weak directions best; None where none is
            weak, or the robot can stand in none.
        seen_std: (2n,) of gains and offsets without the patterns that no data show, as they
            change neither force nor CoP (+ - - + over the offsets of a foot's four cells).
        load_range: (2, n) lowest and highest output that each channel was fitted at [N or N m].
    """

    covariance: FloatArray
    error_model: ErrorModel
    both: Spread
    left: Spread
    right: Spread
    budget: Budget | None
    another: AnotherRun | None
    identifiability: Identifiability
    support_to_add: DoubleSupport | None
    seen_std: FloatArray
    load_range: FloatArray

    @property
    def feet(self) -> tuple[Spread, Spread]:
        """Left and right."""
        return self.left, self.right

    @property
    def promised(self) -> Misfit:
        """Root mean square error of both feet together that is expected."""
        return Misfit(self.both.grf_rms, self.both.cop_rms)

    def not_below(self, left: Misfit) -> Assessment:
        """With nothing expected to be better than what the fit leaves on its own runs.

        That is of both feet together; of one foot alone it is more still.
        """
        spreads = (one.at_least(left.grf, left.cop) for one in (self.both, self.left, self.right))
        both, first, second = spreads
        return replace(self, both=both, left=first, right=second)

    def expected_cop(self) -> tuple[float, dict[str, float]]:
        """Expected mean absolute CoP error [m]: of both feet together in the neutral double
        support, and of each foot under half the weight, the CoP anywhere in the sensing polygons.
        """
        feet = {name: one.cop_mae for name, one in zip(FEET, self.feet, strict=True)}
        return self.both.cop_mae, feet

    def expected_cop_with_another(self) -> tuple[float, dict[str, float]]:
        """The same, were the run of `another` recorded once more.

        Raises:
            ValueError: when that is not known.
        """
        if self.another is None:
            raise ValueError("what another run would win is not known")
        both, feet = self.expected_cop()
        ratio = dict(zip(("both", *FEET), self.another.ratio.tolist(), strict=True))
        return ratio["both"] * both, {name: ratio[name] * size for name, size in feet.items()}

    def interval(self) -> FloatArray:
        """(2n + 1,) half 95 % intervals: gains and offsets as `seen_std`, time offset."""
        time_offset_std = np.sqrt(self.covariance[-1, -1])
        return NORMAL_95 * np.append(self.seen_std, time_offset_std)

    def to_json(self, shoe: Shoe) -> dict[str, object]:
        """Figures for result files [N, mm]."""
        width, count = self.interval(), len(shoe.names)
        expected = {}
        for name, spread in zip(("both", *FEET), (self.both, *self.feet), strict=True):
            expected[name] = {
                "grf_std_n": spread.grf_rms,
                "cop_mae_mm": 1e3 * spread.cop_mae,
                "cop_std_mm": 1e3 * spread.cop_rms,
                "cop_worst_mm": 1e3 * float(np.nanmax(spread.cop_mean)),
            }
        found, add = self.identifiability, self.support_to_add
        return {
            "gain_ci95": dict(zip(shoe.names, width[:count].tolist(), strict=True)),
            "offset_ci95_n": dict(zip(shoe.names, width[count:-1].tolist(), strict=True)),
            "time_offset_ci95_s": float(width[-1]),
            "expected_error": expected,
            "rank": found.rank,
            "possible_rank": found.possible,
            "singular_values": found.singular_values.tolist(),
            "weak_directions": [weak.words for weak in found.weak],
            "supports_to_add": [] if add is None else [{"support": [add.dx, add.dy, add.dtheta]}],
            "load_range_n": dict(zip(shoe.names, self.load_range.T.tolist(), strict=True)),
            "budget": [] if self.budget is None else self.budget.to_json(),
            "another_run": None if self.another is None else self.another.to_json(),
        }


def assess(
    robot: Robot,
    stages: SelfCalibration,
    joint: JointFit | None,
    stances: Sequence[Stance],
    settings: CalibrationSettings,
    tolerances: Tolerances,
) -> Assessment:
    """What a fit's data showed.

    Args:
        robot: that moved.
        stages: the self-calibration.
        joint: its joint fit; None for a walk.
        stances: it was fitted to.
        settings: its weights.
        tolerances: of robot and shoes.
    """
    shoe, parameters = stages.shoe, stages.parameters
    count = len(shoe.names)
    if joint is None:
        covariance = stages.fit.covariance
        measuring, shoe_columns = covariance[:-1, :-1], list[FloatArray]()
    else:
        covariance = joint.covariance[: 2 * count + 1, : 2 * count + 1]
        measuring, shoe_columns = joint.measuring
    errors = ErrorModel.of(
        robot,
        shoe,
        shoe if joint is None else joint.signal_model.samples.shoe,
        parameters,
        measuring,
        shoe_columns,
        support_covariance(joint, tolerances),
        tolerances,
    )
    spreads = both, left, right = errors.over_polygons()
    planning = PlannerSettings(fixed_below=settings.fixed_below)
    information = stages.fit.information[: 2 * count, : 2 * count]
    known = relative_information(robot, shoe, parameters, information)
    found = identifiability(robot, shoe, known, planning)
    # A gain may be negative: which reading is the lowest load is not known before.
    ends = [
        parameters.outputs(np.stack((each.readings.min(axis=0), each.readings.max(axis=0))))
        for each in stances
    ]
    return Assessment(
        covariance=covariance,
        error_model=errors,
        both=both,
        left=left,
        right=right,
        budget=None if joint is None else budget(joint, errors, spreads),
        another=None if joint is None else another_run(joint, errors, spreads, tolerances),
        identifiability=found,
        support_to_add=best_addition(robot, shoe, known, planning) if found.weak else None,
        seen_std=_seen_std(robot, stages, covariance, planning),
        load_range=np.stack((np.min(ends, axis=(0, 1)), np.max(ends, axis=(0, 1)))),
    )


def _seen_std(
    robot: Robot, stages: SelfCalibration, covariance: FloatArray, planning: PlannerSettings
) -> FloatArray:
    """(2n,) of the parameters' part that some double supports could show."""
    shoe, supports = stages.shoe, planning.training_supports
    turn = from_relative(robot, shoe, stages.parameters)
    seen = observable(reference_information(robot, shoe, supports, planning))
    kept = turn @ seen @ seen.T @ np.linalg.inv(turn)
    projected = kept @ covariance[:-1, :-1] @ kept.T
    std: FloatArray = np.sqrt(np.clip(np.diag(projected), 0.0, None))
    return std
