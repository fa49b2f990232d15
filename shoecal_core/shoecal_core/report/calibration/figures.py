"""The figures of a calibration's report."""

from __future__ import annotations

import numpy as np

from shoecal_core.estimation.series import Series
from shoecal_core.report import palette
from shoecal_core.report.calibration.content import CalibrationReport, RunReport
from shoecal_core.report.figures.bars import Bar, mae_bars
from shoecal_core.report.figures.feet import CopPath, cop_plane, cop_under_feet, foot_shape
from shoecal_core.report.figures.motion import skeleton, snapshots
from shoecal_core.report.figures.series import Line, cop_and_grf, errors_in_time
from shoecal_core.report.page import Picture
from shoecal_core.report.palette import Look
from shoecal_core.report.quantities import mean_error
from shoecal_core.shoe.shoe import FEET

GUESS, MEASURED, MODELLED = "initial guess", "calibrated", "model"


def accuracy_pictures(content: CalibrationReport) -> tuple[Picture, ...]:
    """Errors by stage, then by run next to the model's own."""
    stages = [
        (label, look, name == "test", found)
        for stage, label, look in (
            ("initial_guess", GUESS, palette.GUESS),
            ("self_calibration", MEASURED, palette.MEASURED),
        )
        for name, found in content.errors[stage].items()
    ]
    bars = [
        Bar(label, look, label, test, found.grf, found.cop) for label, look, test, found in stages
    ]
    against = f"Against the {content.reference}; whiskers: one standard deviation."
    pictures = [Picture("Initial guess and calibration", mae_bars(bars), against)]
    kinds = [("measured", MEASURED, palette.MEASURED)]
    title = "Calibrated shoes, run by run"
    if content.has_truth:
        kinds.insert(0, ("modelled", MODELLED, palette.MODELLED))
        title = "Model and calibrated shoes, run by run"
        against += (
            " The model takes the robot as standing still at every instant: its GRF is the weight,"
            " its CoP the CoM's ground projection."
        )
    by_run = []
    for run in content.runs:
        for name, label, look in kinds:
            found = run.errors(name)
            by_run.append(Bar(run_label(run, content), look, label, run.test, found.grf, found.cop))
    pictures.append(Picture(title, mae_bars(by_run), against))
    return tuple(pictures)


def run_label(run: RunReport, content: CalibrationReport) -> str:
    """Short where many runs are shown side by side."""
    return f"run {run.run}" if len(content.runs) <= 6 else str(run.run)


def run_pictures(content: CalibrationReport, run: RunReport) -> tuple[Picture, ...]:
    """Motion, CoP and GRF against time, their errors, and the CoP between the feet."""
    bodies = [skeleton(content.robot, angles) for angles in run.snapshot_angles]
    lines = _lines(content, run)
    found = run.errors("measured")
    pictures = [
        Picture("Motion", snapshots(bodies, run.snapshot_time.tolist())),
        Picture("CoP and GRF", cop_and_grf(lines), _frame_note(run), tall=True),
        Picture(
            f"Error against the {content.reference}",
            errors_in_time(_compared(lines, content), run.series("reference")),
            f"Calibrated: GRF {mean_error(found.grf, 'N')}, CoP {mean_error(found.cop, 'mm', 1e3)} "
            "(MAE ± standard deviation).",
            tall=True,
        ),
    ]
    if run.double_support:
        support = run.stances[0].stance.support
        feet = [
            foot_shape(content.robot, content.shoe, 0),
            foot_shape(content.robot, content.shoe, 1, support),
        ]
        paths = [CopPath(line.label, line.look, line.series.cop) for line in lines]
        pictures.append(Picture("CoP between the feet", cop_plane(feet, paths)))
    return tuple(pictures)


def _frame_note(run: RunReport) -> str:
    if run.double_support:
        return "CoP in the left sole's frame: x forward, y to the left."
    return (
        "CoP in the frame of the left sole while it carries load, else of the right sole: "
        "x forward, y to the left."
    )


def foot_picture(content: CalibrationReport, run: RunReport) -> Picture:
    """CoP under each foot by itself."""
    names = [("measured", MEASURED, palette.MEASURED)]
    if content.has_truth:
        names.insert(0, ("truth", "truth", palette.TRUTH))
    series = [(run.series(name), label, look) for name, label, look in names]
    panels = []
    for foot in (0, 1):
        paths = [CopPath(label, look, one.foot_cop[:, foot]) for one, label, look in series]
        panels.append((foot_shape(content.robot, content.shoe, foot), paths))
    caption = ""
    if content.has_truth:
        found = run.errors("measured").foot_cop
        errors = (f"{foot} {mean_error(found[i], 'mm', 1e3)}" for i, foot in enumerate(FEET))
        caption = f"CoP MAE ± standard deviation: {', '.join(errors)}."
    return Picture(f"Run {run.run} ({set_name(run)})", cop_under_feet(panels), caption)


def set_name(run: RunReport) -> str:
    """What the run was used for."""
    return "test" if run.test else "training"


def _lines(content: CalibrationReport, run: RunReport) -> list[Line]:
    """Guess, truth (or model), calibrated: the last one is drawn on top."""
    reference: tuple[str, str, Look] = (
        ("truth", "truth", palette.TRUTH)
        if content.has_truth
        else ("modelled", MODELLED, palette.REFERENCE)
    )
    chosen = [("guess", GUESS, palette.GUESS), reference, ("measured", MEASURED, palette.MEASURED)]
    lines = [Line(label, look, run.series(name)) for name, label, look in chosen]
    if content.has_truth:
        lines.insert(2, Line(MODELLED, palette.MODELLED, run.series("modelled")))
    return [line for line in lines if _known(line.series)]


def _compared(lines: list[Line], content: CalibrationReport) -> list[Line]:
    """Lines whose error is worth a look: not the reference's own, not the guess's."""
    wanted = {MEASURED} | ({MODELLED} if content.has_truth else set())
    return [line for line in lines if line.label in wanted]


def _known(series: Series) -> bool:
    return bool(np.isfinite(series.grf).any())
