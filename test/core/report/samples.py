"""Content of reports made up from known gains, offsets and a model that is a little off."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from core.estimation import synthetic
from core.robot import robots
from core.shoe import shoes
from shoecal_core.arrays import FloatArray
from shoecal_core.error_sources.tolerances import Tolerances
from shoecal_core.estimation.calibration import Calibration
from shoecal_core.estimation.comparison import StanceComparison
from shoecal_core.estimation.fit import SelfCalibration, self_calibrate
from shoecal_core.estimation.series import Series, measured_series, modelled_series
from shoecal_core.estimation.uncertainty.assessment import Assessment
from shoecal_core.estimation.uncertainty.expected import ErrorModel, support_covariance
from shoecal_core.planning.settings import PlannerSettings
from shoecal_core.planning.supports.identifiability import identifiability
from shoecal_core.planning.supports.observability import relative_information
from shoecal_core.report.calibration.content import CalibrationReport, RunReport
from shoecal_core.robot.double_support import DoubleSupport
from shoecal_core.robot.robot import Robot
from shoecal_core.samples.stance import Stance
from shoecal_core.screening.settings import CalibrationSettings
from shoecal_core.shoe.sensing import Sensing
from shoecal_core.shoe.shoe import Shoe
from shoecal_core.shoe.wrench import ChannelParameters

TRAIN = (1, 3, 4)


def shoe_of(cells: int) -> Shoe:
    """A pair of shoes with so many cells a foot, on the corners of a polygon."""
    angle = 2.0 * np.pi * (np.arange(cells) + 0.5) / cells
    places = np.column_stack((0.024 + 0.06 * np.cos(angle), 0.035 * np.sin(angle)))
    return shoes.made([*shoes.cells(0, places), *shoes.cells(1, places, polarity=-1)])


def content(
    shoe: Shoe,
    *,
    robot: Robot | None = None,
    truth: bool = True,
    runs: int = 5,
    count: int = 400,
    verdict: str = "PASS",
    reasons: tuple[str, ...] = ("every check passed",),
) -> CalibrationReport:
    """A whole report: the model's CoP is 2 mm off, readings are noisy."""
    robot = robots.load("nao") if robot is None else robot
    rng = np.random.default_rng(7)
    parameters = synthetic.truth(shoe, rng)
    supports = synthetic.SUPPORTS[:runs]
    true = [
        synthetic.stance(
            shoe, parameters, support, rng, run=index + 1, count=count, weight=robot.weight
        )
        for index, support in enumerate(supports)
    ]
    stances = [misled(stance, parameters, rng) for stance in true]
    training = [stance for stance in stances if stance.run in TRAIN]
    stages = self_calibrate(shoe, training, CalibrationSettings())
    exact = Sensing(shoe, parameters)
    assessed = assessment_of(robot, shoe, stages, training)
    return CalibrationReport(
        robot=robot,
        shoe=shoe,
        calibration=calibration_of(robot, shoe, stages, verdict, reasons),
        stages=stages,
        runs=tuple(
            run_report(robot, stages, stance, measured_series(exact, clean) if truth else None)
            for stance, clean in zip(stances, true, strict=True)
        ),
        assessed=assessed,
        timing={"plan": 61.2, "record": 104.5, "solve": 1.31, "total": 171.0},
        provenance=("Simulated robot on simulated shoes, reality default, seed 1.",),
    )


def assessment_of(
    robot: Robot, shoe: Shoe, stages: SelfCalibration, training: Sequence[Stance]
) -> Assessment:
    """What the training runs identify; without joint angles no error of the robot is known.

    The double support to add is made up: to find the best of all takes seconds.
    """
    tolerances = Tolerances()
    fit, parameters = stages.fit, stages.parameters
    size = 2 * len(shoe.names)
    covariance = fit.covariance
    supports = support_covariance(None, tolerances)
    model = ErrorModel.of(
        robot, shoe, shoe, parameters, covariance[:-1, :-1], (), supports, tolerances
    )
    both, left, right = model.over_polygons()
    known = relative_information(robot, shoe, parameters, fit.information[:size, :size])
    found = identifiability(robot, shoe, known, PlannerSettings())
    outputs = np.concatenate([parameters.outputs(one.readings) for one in training])
    return Assessment(
        covariance=covariance,
        error_model=model,
        both=both,
        left=left,
        right=right,
        budget=None,
        another=None,
        identifiability=found,
        support_to_add=DoubleSupport(0.08, -0.11, 0.5) if found.weak else None,
        seen_std=np.sqrt(np.diag(covariance)[:size]),
        load_range=np.stack((outputs.min(axis=0), outputs.max(axis=0))),
    )


def misled(stance: Stance, parameters: ChannelParameters, rng: np.random.Generator) -> Stance:
    """As recorded: readings with noise, and a model whose CoM is a little off."""
    phase = np.linspace(0.0, 6.0, len(stance.time))[:, None] + rng.uniform(0.0, 6.0, 2)
    noise = 0.05 * rng.standard_normal(stance.readings.shape) / parameters.gain
    return replace(
        stance,
        readings=stance.readings + noise,
        cop=stance.cop + 1e-3 * (rng.normal(0.0, 1.2, 2) + np.sin(phase)),
    )


def calibration_of(
    robot: Robot, shoe: Shoe, stages: SelfCalibration, verdict: str, reasons: tuple[str, ...]
) -> Calibration:
    """As the pipeline makes it."""
    size = 2 * len(shoe.names)
    return Calibration(
        id="self-0123456789ab",
        source="self",
        made_ns=1_790_000_000 * 10**9,
        robot=robot.name,
        shoe=shoe.name,
        robot_hash=robot.digest,
        shoe_hash=shoe.digest,
        channels=shoe.names,
        parameters=stages.parameters,
        covariance=stages.fit.covariance[:size, :size],
        corrections=stages.corrections,
        weight=robot.weight,
        time_offset=stages.time_offset,
        temperature=24.5,
        verdict=verdict,
        reasons=reasons,
    )


def run_report(
    robot: Robot, stages: SelfCalibration, stance: Stance, truth: Series | None
) -> RunReport:
    """One run in double support, the body swaying from side to side."""
    times = np.linspace(stance.time[0], stance.time[-1], 5)
    guessed = Sensing(stages.shoe, stages.guess.parameters)
    one = StanceComparison(
        set="train" if stance.run in TRAIN else "test",
        stance=stance,
        guess=measured_series(guessed, stance),
        measured=measured_series(stages.sensing, stance),
        modelled=modelled_series(stance),
        truth=truth,
    )
    return RunReport((one,), times, swaying(robot, len(times), 0.05 + 0.03 * stance.run))


def swaying(robot: Robot, count: int, amplitude: float = 0.15) -> FloatArray:
    """(count, m) joint angles around the robot's posture."""
    angles = np.tile(robot.posture, (count, 1))
    phase = np.linspace(0.0, 2.0 * np.pi, count)
    for index, name in enumerate(robot.joint_names):
        if name.endswith("HipRoll"):
            angles[:, index] += amplitude * np.sin(phase)
        if name.endswith("AnkleRoll"):
            angles[:, index] -= amplitude * np.sin(phase)
    return angles


def with_gap(run: RunReport) -> RunReport:
    """The same run; its shoes sent nothing for a while, and nothing at all on the right."""
    (one,) = run.stances
    cop, foot_cop = one.measured.cop.copy(), one.measured.foot_cop.copy()
    cop[50:90] = np.nan
    foot_cop[50:90] = np.nan
    foot_cop[:, 1] = np.nan
    measured = replace(one.measured, cop=cop, foot_cop=foot_cop)
    return replace(run, stances=(replace(one, measured=measured),))
