"""The section on observability and expected errors, and its key figures."""

from __future__ import annotations

from shoecal_core.report.assessment_content import AssessmentContent
from shoecal_core.report.assessment_figures import (
    direction_picture,
    error_pictures,
    expected_text,
    left_out_picture,
    load_pictures,
    source_pictures,
)
from shoecal_core.report.assessment_tables import (
    expected_table,
    findings_table,
    helps_table,
    left_out_table,
    weak_table,
)
from shoecal_core.report.calibration_content import CalibrationReport
from shoecal_core.report.page import Group, KeyFigure, Section, Table
from shoecal_core.report.quantities import uncertain
from shoecal_core.shoe.shoe import FEET


def assessment_section(content: CalibrationReport, assessed: AssessmentContent) -> Section:
    """Expected errors, their causes, identified directions, what was left out."""
    text = (
        "How far GRF and CoP by this calibration may be off, without asking any truth: from the "
        "noise of this recording, from what the files of robot and shoes may be wrong by, and from "
        "what was not observable."
    )
    if not assessed.carried:
        text = (
            "What the noise of this recording makes of GRF and CoP, and what was not observable. "
            "For these runs (walking, or without joint angles) the model's own errors are not "
            "carried: the true errors are larger than these values, by how much is not known."
        )
    return Section(
        "Expected errors and observability",
        (_expected(content, assessed), _fixed(content, assessed), _left_out(content, assessed)),
        text,
    )


def expected_keys(assessed: AssessmentContent) -> list[KeyFigure]:
    """Expected CoP error of both feet and of each."""
    found = assessed.assessment
    keys = []
    for label, spread in zip(("both feet", *(f"{side} foot" for side in FEET)),
                             (found.both, *found.feet), strict=True):  # fmt: skip
        value, note = expected_text(spread)
        if not assessed.carried:
            note = "the model's own errors come on top"
        keys.append(KeyFigure(f"{assessed.error_name}, {label}", value, note))
    return keys


def time_offset_text(assessed: AssessmentContent, time_offset: float) -> str:
    """Time offset with half of its 95 % interval."""
    return uncertain(1e3 * time_offset, 1e3 * float(assessed.assessment.interval()[-1]), "ms")


def _expected(content: CalibrationReport, assessed: AssessmentContent) -> Group:
    return Group(
        title="Expected error" if assessed.carried else "Known part of the error",
        pictures=(*error_pictures(content, assessed), *source_pictures(assessed)),
        tables=_known(expected_table(assessed), helps_table(assessed)),
    )


def _fixed(content: CalibrationReport, assessed: AssessmentContent) -> Group:
    found, support = assessed.assessment.told, assessed.assessment.support_to_add
    add = None if support is None else f"right foot at {support} of the left"
    if found.weak:
        text = (
            "Directions that are not observable keep their initial guess. They change GRF and CoP, "
            "so the expected errors above include them."
        )
    else:
        text = "All directions of gains and offsets that double supports show are identified."
    return Group(
        title="Identified directions",
        text=text,
        pictures=(direction_picture(assessed), *load_pictures(content, assessed)),
        tables=_known(weak_table(found.weak, "" if add is None else f"To add: {add}.")),
    )


def _left_out(content: CalibrationReport, assessed: AssessmentContent) -> Group:
    picture = left_out_picture(content, assessed)
    counted = sum(assessed.screening.samples.values())
    lost = sum(one.samples for one in assessed.screening.left_out)
    if not counted:
        text = "The recording was not screened."
    elif lost:
        text = f"{lost} of {counted} samples do not count ({100.0 * lost / counted:.1f} %)."
    else:
        text = f"Nothing: all {counted} samples count."
    late = time_offset_text(assessed, content.calibration.time_offset)
    return Group(
        title="What was left out before the fit",
        text=f"{text} Time offset (joints after readings): {late}, 95\N{NO-BREAK SPACE}% interval; "
        "corrected by the fit.",
        pictures=() if picture is None else (picture,),
        tables=_known(left_out_table(assessed.screening), findings_table(assessed.screening)),
    )


def _known(*tables: Table | None) -> tuple[Table, ...]:
    return tuple(table for table in tables if table is not None)
