"""The report on a calibration as a page, and as a file."""

from __future__ import annotations

from pathlib import Path

from shoecal_core.estimation.calibration import Calibration
from shoecal_core.estimation.series import Errors
from shoecal_core.report.calibration.assessment import (
    assessment_section,
    expected_keys,
    possible,
    time_offset_text,
)
from shoecal_core.report.calibration.assessment_tables import carried
from shoecal_core.report.calibration.content import CalibrationReport
from shoecal_core.report.calibration.figures import (
    accuracy_pictures,
    foot_picture,
    run_pictures,
    set_name,
)
from shoecal_core.report.calibration.tables import (
    belongs_to,
    channels_table,
    errors_table,
    runs_table,
    stages_table,
    support_text,
    timing_table,
    weight_std,
)
from shoecal_core.report.html import write_page
from shoecal_core.report.next_step import after_calibration
from shoecal_core.report.page import (
    Group,
    KeyFigure,
    Page,
    PageVerdict,
    Reason,
    Section,
)
from shoecal_core.report.quantities import mean_error, uncertain
from shoecal_core.report.recorded_tables import zeros_section
from shoecal_core.screening.verdict import split_reason
from shoecal_core.shoe.shoe import FEET

MEANING = {
    "PASS": "This calibration may be used.",
    "WARN": "This calibration may be used with care: read the reasons first.",
    "FAIL": "This calibration must not be used.",
}
SOURCES = {"self": "self-calibration", "manual": "manual calibration"}


def calibration_report(path: Path, content: CalibrationReport) -> None:
    """Write the report as one self-contained HTML file.

    Raises:
        FileError: when it cannot be written.
    """
    write_page(path, calibration_page(content))


def calibration_page(content: CalibrationReport) -> Page:
    """The report, ready to be rendered; the same content makes the same page."""
    return Page(
        title=f"Calibration of {content.shoe.name} on {content.robot.name}",
        subtitle=subtitle(content),
        verdict=verdict_of(content.calibration),
        key_figures=_key_figures(content),
        sections=(_accuracy(content), *_assessment(content), _channels(content),
                  *zeros_section(content.zeros), _runs(content), _feet(content),
                  _details(content)),
        provenance=content.provenance,
    )  # fmt: skip


def verdict_of(calibration: Calibration, following: str | None = None) -> PageVerdict:
    """May it be used, and why (not).

    Args:
        calibration: found.
        following: what to do next; None: put it in force.
    """
    line = following
    if line is None:
        line = after_calibration(calibration.verdict, by_robot=calibration.source == "self")
    return PageVerdict(
        calibration.verdict,
        MEANING[calibration.verdict],
        tuple(Reason(*split_reason(one, calibration.verdict)) for one in calibration.reasons),
        lines=(line,) if line else (),
    )


def subtitle(content: CalibrationReport) -> str:
    """How, when and from how much."""
    calibration = content.calibration
    parts = [SOURCES.get(calibration.source, calibration.source), *made(calibration)]
    train = sum(not run.test for run in content.runs)
    parts.append(f"training runs: {train}, test runs: {len(content.runs) - train}")
    return " · ".join(parts)


def made(calibration: Calibration) -> list[str]:
    """When it was made; nothing where its clock names no day."""
    moment = calibration.moment
    return [] if moment is None else [moment.strftime("%Y-%m-%d %H:%M UTC")]


def _key_figures(content: CalibrationReport) -> tuple[KeyFigure, ...]:
    judged, stages = content.judged, content.stages
    found = content.errors["self_calibration"][judged]
    before = content.errors["initial_guess"][judged]
    where = "test runs" if judged == "test" else "training runs"
    against, assessed = f"against the {content.reference}", content.assessed
    keys = [
        KeyFigure(f"CoP error {against}", mean_error(found.cop, "mm", 1e3),
                  _note(where, mean_error(before.cop, "mm", 1e3), stages is not None)),
        KeyFigure(f"GRF error {against}", mean_error(found.grf, "N"),
                  _note(where, mean_error(before.grf, "N"), stages is not None)),
    ]  # fmt: skip
    if content.has_truth:
        keys += _foot_keys(found, f"{against}, {where}")
    if assessed is not None:
        late = time_offset_text(assessed, content.calibration.time_offset)
        expected = expected_keys(assessed)
        # What to plan with comes first: against the model nearly every fit looks good.
        keys = [*expected, *keys] if carried(assessed) else [*keys, *expected]
        keys += [
            KeyFigure("identified", f"{assessed.identifiability.rank} of {possible(assessed)}",
                      "directions of gains and offsets"),
            KeyFigure("time offset", late, "joints after readings; 95 % interval"),
        ]  # fmt: skip
    weight = uncertain(content.calibration.weight, weight_std(content.robot), "N")
    keys.append(KeyFigure("reference weight", weight, "robot and shoes, ± standard uncertainty"))
    return tuple(keys)


def _note(where: str, before: str, guessed: bool) -> str:
    return f"{where}; initial guess: {before}" if guessed else where


def _foot_keys(found: Errors, where: str) -> list[KeyFigure]:
    return [
        KeyFigure(f"{foot} foot's CoP error", mean_error(mae, "mm", 1e3), where)
        for foot, mae in zip(FEET, found.foot_cop, strict=True)
    ]


def _accuracy(content: CalibrationReport) -> Section:
    if content.has_truth:
        text = (
            "Errors are counted against the truth: the forces between shoes and floor. "
            "The calibration never saw it; it was fitted to the model."
        )
    else:
        text = (
            "Errors are counted against the model: what masses and joint angles say of GRF and "
            "CoP. There is no truth here, so an error of the model itself stays unseen."
        )
    if content.judged == "train":
        text += " No run was kept for a test: how well other runs are measured is not known."
    group = Group(pictures=accuracy_pictures(content), tables=(errors_table(content),))
    return Section("Accuracy", (group,), text)


def _assessment(content: CalibrationReport) -> tuple[Section, ...]:
    return () if content.assessed is None else (assessment_section(content, content.assessed),)


def _channels(content: CalibrationReport) -> Section:
    group = Group(tables=(channels_table(content),))
    return Section("Channels", (group,))


def _runs(content: CalibrationReport) -> Section:
    groups = tuple(
        Group(
            title=f"Run {run.run} · {set_name(run)}",
            text=_support_line(run.double_support, support_text(run)),
            pictures=run_pictures(content, run),
            folded=number > 0,
        )
        for number, run in enumerate(content.runs)
    )
    return Section("Runs", groups)


def _support_line(double_support: bool, text: str) -> str:
    return f"Right foot from the left: {text}." if double_support else f"{text}."


def _feet(content: CalibrationReport) -> Section:
    pictures = tuple(foot_picture(content, run) for run in content.runs)
    group = Group(title="CoP of each foot, run by run", pictures=pictures, folded=True)
    return Section(
        "Each foot by itself",
        (group,),
        "Both feet together can look right while each is wrong, so each is looked at in its own "
        "sole frame. No CoP is drawn while a foot carries too little.",
    )


def _details(content: CalibrationReport) -> Section:
    tables = [runs_table(content)]
    if content.stages is not None:
        tables.append(stages_table(content, content.stages))
    tables.append(belongs_to(content.calibration, content.robot))
    if content.timing:
        tables.append(timing_table(content))
    return Section("Details", (Group(title="All tables", tables=tuple(tables), folded=True),))
