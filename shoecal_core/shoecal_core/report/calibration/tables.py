"""The tables of a calibration's report."""

from __future__ import annotations

from shoecal_core.estimation.calibration import Calibration
from shoecal_core.estimation.fit import SelfCalibration
from shoecal_core.estimation.series import Mae
from shoecal_core.report.calibration.content import CalibrationReport, RunReport
from shoecal_core.report.calibration.figures import set_name
from shoecal_core.report.origin import SHORT
from shoecal_core.report.page import Table
from shoecal_core.report.quantities import (
    channel_units,
    double_support_text,
    mean_error,
    number,
    quantity,
    size,
    uncertain,
)
from shoecal_core.robot.robot import Robot
from shoecal_core.shoe.shoe import FEET

STAGES = {
    "initial_guess": "initial guess",
    "self_calibration": "calibrated",
    "modelled": "model",
}
WRENCH = 3
"""Force and two moments: more channels than these have patterns that sum to nothing."""
SETS = {"train": "training runs", "test": "test runs"}


def errors_table(content: CalibrationReport) -> Table:
    """Errors by stage and set, of both feet together and of each."""
    header = ["", "GRF", "CoP"]
    if content.has_truth:
        header += [f"{foot} {what}" for what in ("GRF", "CoP") for foot in FEET]
    rows = []
    for stage, label in STAGES.items():
        for name, found in content.errors.get(stage, {}).items():
            row = [f"{label}, {SETS[name]}", *_pair(found.grf, found.cop)]
            if content.has_truth:
                row += [mean_error(mae, "N") for mae in found.foot_grf]
                row += [mean_error(mae, "mm", 1e3) for mae in found.foot_cop]
            rows.append(tuple(row))
    return Table(
        f"Mean absolute errors against the {content.reference}",
        tuple(header),
        tuple(rows),
        "± is the standard deviation of the absolute error. The CoP's error is a distance in "
        "the plane. The model does not know each foot's share.",
    )


def runs_table(content: CalibrationReport) -> Table:
    """What was recorded."""
    rows = tuple(
        (
            f"run {run.run}",
            set_name(run),
            support_text(run),
            quantity(sum(one.stance.duration for one in run.stances), "s", 1),
            str(sum(len(one.stance.time) for one in run.stances)),
            *_pair(run.errors("measured").grf, run.errors("measured").cop),
        )
        for run in content.runs
    )
    header = ("", "set", "right foot from the left", "duration", "samples", "GRF", "CoP")
    return Table(
        "Runs", header, rows, "GRF and CoP: MAE ± standard deviation of the calibrated shoes."
    )


def support_text(run: RunReport) -> str:
    """Where the right foot stands, or how many stances there are."""
    if not run.double_support:
        return f"{len(run.stances)} stances"
    return double_support_text(run.stances[0].stance.support)


def channels_table(content: CalibrationReport) -> Table:
    """Gain and offset of every channel with their 95 % intervals."""
    shoe, calibration = content.shoe, content.calibration
    count, half = len(shoe.names), content.half_widths
    guess = None if content.stages is None else content.stages.guess.parameters
    rows = []
    for index, name in enumerate(shoe.names):
        unit, gain_unit = channel_units(shoe, torque=bool(shoe.torque[index]))
        row = [
            name,
            uncertain(calibration.parameters.gain[index], half[index], gain_unit),
            uncertain(calibration.parameters.offset[index], half[count + index], unit),
        ]
        if content.assessed is not None:
            low, high = content.assessed.load_range[:, index]
            row.append(f"{number(low, 1)} to {quantity(high, unit, 1)}")
        if guess is not None:
            row += [
                size(guess.gain[index], gain_unit),
                size(guess.offset[index], unit),
            ]
        rows.append(tuple(row))
    header = ["channel", "gain", "offset"]
    if content.assessed is not None:
        header.append("loads seen")
    if guess is not None:
        header += ["guessed gain", "guessed offset"]
    note = "Output = gain · reading + offset; ± is half of the 95 % interval."
    if calibration.covariance is None:
        note = "Output = gain · reading + offset. This calibration came without uncertainties."
    elif any(len(shoe.of_foot(foot)) > WRENCH for foot in (0, 1)):
        unseen = "patterns that no double support shows, such as + − − + over four offsets"
        if content.assessed is None:
            note += f" Single offsets look uncertain: it also holds {unseen}."
        else:
            note += f" It leaves out {unseen}."
    return Table("Channels", tuple(header), tuple(rows), note)


def stages_table(content: CalibrationReport, stages: SelfCalibration) -> Table:
    """How the calibration was found."""
    fit, (_, unit) = stages.fit, channel_units(content.shoe, torque=False)
    rows = []
    for label, guess in (
        ("initial guess, from the CoP alone", stages.guess),
        ("initial guess, from CoP and weight", stages.guess_with_weight),
    ):
        gain, offset = size(guess.gain, unit), size(guess.offset, "N")
        rows.append((label, f"gain {gain}, offset {offset}"))
    rows += [
        (
            "least squares of gains and offsets",
            f"{fit.iterations} iterations, cost {_cost(fit.initial_cost)} → {_cost(fit.cost)}",
        ),
        ("CoP correction", _corrected(stages)),
    ]
    return Table("How it was found", ("stage", "result"), tuple(rows))


def _corrected(stages: SelfCalibration) -> str:
    if not stages.corrections:
        return "none: it did not help on runs held out"
    parts = []
    for correction in stages.corrections:
        (x_low, y_low), (x_high, y_high) = 1e3 * correction.cop_range
        parts.append(
            f"{FEET[correction.foot]} foot, trained for x {number(x_low, 0)} to "
            f"{quantity(x_high, 'mm', 0)}, y {number(y_low, 0)} to {quantity(y_high, 'mm', 0)}"
        )
    return "; ".join(parts)


def timing_table(content: CalibrationReport) -> Table:
    """How long it took."""
    rows = tuple((name, quantity(value, "s", 1)) for name, value in content.timing.items())
    return Table("Time taken", ("stage", "time"), rows)


def belongs_to(calibration: Calibration, robot: Robot) -> Table:
    """Which calibration of what this is."""
    rows = (
        ("calibration", calibration.id),
        ("robot", f"{robot.name}, file {calibration.robot_hash[:SHORT]}"),
        ("shoe", f"{calibration.shoe}, file {calibration.shoe_hash[:SHORT]}"),
        ("weight of robot and shoes", uncertain(calibration.weight, weight_std(robot), "N")),
        ("temperature", quantity(calibration.temperature, "°C", 1)),
    )
    return Table("What it belongs to", ("", ""), rows)


def _cost(cost: float) -> str:
    """Four digits, or all before the point."""
    return f"{cost:.0f}" if abs(cost) >= 1e3 else f"{cost:.4g}"


def weight_std(robot: Robot) -> float:
    """Standard uncertainty of the weight [N]."""
    return robot.mass_std * robot.weight / robot.mass


def _pair(grf: Mae, cop: Mae) -> tuple[str, str]:
    return mean_error(grf, "N"), mean_error(cop, "mm", 1e3)
