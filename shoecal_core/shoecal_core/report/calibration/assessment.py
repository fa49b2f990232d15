"""Expected errors of a calibration and what its data identify, as a section of the report."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from shoecal_core.estimation.uncertainty.assessment import Assessment
from shoecal_core.estimation.uncertainty.expected import Spread
from shoecal_core.report.calibration.assessment_tables import (
    carried,
    expected_table,
    helps_table,
    rms,
    source_name,
)
from shoecal_core.report.calibration.content import CalibrationReport
from shoecal_core.report.figures.error_map import ErrorMap, common_levels, error_map
from shoecal_core.report.figures.feet import foot_shape
from shoecal_core.report.figures.named_bars import NamedBar, named_bars
from shoecal_core.report.page import Group, KeyFigure, Picture, Section, Table
from shoecal_core.report.palette import PLAIN
from shoecal_core.report.quantities import number, quantity, size, uncertain
from shoecal_core.report.screening_parts import left_out_group
from shoecal_core.report.weak_table import weak_table
from shoecal_core.shoe.shoe import FEET

SHOWN_SOURCES = 8


def error_name(assessed: Assessment) -> str:
    """What the expected error of the CoP may be called."""
    return "expected CoP error" if carried(assessed) else "known part of the CoP error"


def possible(assessed: Assessment) -> int:
    """Directions that the data could have fixed."""
    return max(assessed.identifiability.possible, assessed.identifiability.rank)


def error_pictures(content: CalibrationReport, assessed: Assessment) -> tuple[Picture, ...]:
    """Maps of the CoP's expected error, both feet together and each."""
    robot, shoe = content.robot, content.shoe
    neutral = robot.neutral
    own = [foot_shape(robot, shoe, foot) for foot in (0, 1)]
    both = ErrorMap(
        "both feet together",
        (own[0], foot_shape(robot, shoe, 1, neutral)),
        assessed.both.places,
        assessed.both.cop_mean,
    )
    each = [
        ErrorMap(f"{side} foot", (shape,), spread.places, spread.cop_mean)
        for side, shape, spread in zip(FEET, own, assessed.feet, strict=True)
    ]
    levels = common_levels([both, *each])
    name = error_name(assessed)
    title = name[0].upper() + name[1:]
    listed = "; ".join(
        f"{side} {_summary(spread)}" for side, spread in zip(FEET, assessed.feet, strict=True)
    )
    return (
        Picture(
            f"{title}, both feet",
            error_map([both], levels),
            f"Where the CoP is, and by how much it may be off: {_summary(assessed.both)}.",
            tall=True,
        ),
        Picture(
            f"{title}, each foot",
            error_map(each, levels),
            f"Each under half the weight, in the same colours: {listed}.",
            tall=True,
        ),
    )


def _summary(spread: Spread) -> str:
    lengths = 1e3 * spread.cop_mean
    known = lengths[np.isfinite(lengths)]
    if not len(known):
        return "not known"
    along = [size(1e3 * rms(spread.cop[:, axis]), "mm") for axis in (0, 1)]
    return (
        f"{size(float(known.mean()), 'mm')} ({along[0]} along x, {along[1]} along y; at worst "
        f"{size(float(known.max()), 'mm')})"
    )


def source_pictures(assessed: Assessment) -> tuple[Picture, ...]:
    """Error sources of the CoP of both feet together, and of single feet; none for a walk."""
    budget = assessed.budget
    if budget is None:
        return ()
    pictures = []
    for label, part in (("both feet together", slice(0, 1)), ("a single foot", slice(1, 3))):
        sizes = {source_name(one.effect): 1e3 * rms(one.size[part]) for one in budget.sources}
        largest = sorted(sizes, key=lambda name: sizes[name], reverse=True)[:SHOWN_SOURCES]
        whole = max(sizes[largest[0]], 1e-9)
        bars = [
            NamedBar(name, quantity(sizes[name], "mm", 1), sizes[name] / whole, PLAIN)
            for name in largest
        ]
        pictures.append(
            Picture(
                f"Error sources of the CoP, {label}",
                named_bars(bars, "Sources of the expected error"),
                "Root mean square over the sensing polygons. The squares of all sources add up to "
                "the square of the expected error.",
            )
        )
    return tuple(pictures)


def expected_text(spread: Spread) -> tuple[str, str]:
    """Expected CoP error over a polygon, and a note with the worst place and the GRF."""
    worst = 1e3 * spread.cop_mean
    known = worst[np.isfinite(worst)]
    if not len(known):
        return number(float("nan"), 0), ""
    return (
        size(float(known.mean()), "mm"),
        f"worst place {size(float(known.max()), 'mm')}; GRF {size(rms(spread.grf), 'N')}",
    )


def assessment_section(content: CalibrationReport, assessed: Assessment) -> Section:
    """Expected errors, their causes, identified directions, what was left out."""
    text = (
        "How far GRF and CoP by this calibration may be off, without asking any truth: from the "
        "noise of this recording, from what the files of robot and shoes may be wrong by, and from "
        "what was not observable."
    )
    if not carried(assessed):
        text = (
            "What the noise of this recording makes of GRF and CoP, and what was not observable. "
            "For these runs (walking, or without joint angles) the model's own errors are not "
            "carried: the true errors are larger than these values, by how much is not known."
        )
    return Section(
        "Expected errors and observability",
        (_expected(content, assessed), _fixed(assessed), _left_out(content, assessed)),
        text,
    )


def expected_keys(assessed: Assessment) -> list[KeyFigure]:
    """Expected CoP error of both feet and of each."""
    keys = []
    for label, spread in zip(("both feet", *(f"{side} foot" for side in FEET)),
                             (assessed.both, *assessed.feet), strict=True):  # fmt: skip
        value, note = expected_text(spread)
        if not carried(assessed):
            note = "the model's own errors come on top"
        keys.append(KeyFigure(f"{error_name(assessed)}, {label}", value, note))
    return keys


def time_offset_text(assessed: Assessment, time_offset: float) -> str:
    """Time offset with half of its 95 % interval."""
    return uncertain(1e3 * time_offset, 1e3 * float(assessed.interval()[-1]), "ms")


def _expected(content: CalibrationReport, assessed: Assessment) -> Group:
    return Group(
        title="Expected error" if carried(assessed) else "Known part of the error",
        pictures=(*error_pictures(content, assessed), *source_pictures(assessed)),
        tables=_known(expected_table(assessed), helps_table(assessed)),
    )


def _fixed(assessed: Assessment) -> Group:
    found, support = assessed.identifiability, assessed.support_to_add
    add = None if support is None else f"right foot at {support} of the left"
    if found.weak:
        text = (
            "Directions that are not observable keep their initial guess. They change GRF and CoP, "
            "so the expected errors above include them."
        )
    else:
        text = "All that double supports show are identified."
    return Group(
        title="Identified directions",
        text=f"{found.rank} of {possible(assessed)} patterns of gains and offsets. {text}",
        tables=_known(weak_table(found, "" if add is None else f"To add: {add}.")),
    )


def _left_out(content: CalibrationReport, assessed: Assessment) -> Group:
    late = time_offset_text(assessed, content.calibration.time_offset)
    found = left_out_group(
        content.screening,
        {run.run: max(float(one.stance.time[-1]) for one in run.stances) for run in content.runs},
        "What was left out before the fit",
        f"Time offset (joints after readings): {late}, 95\N{NO-BREAK SPACE}% interval; corrected "
        "by the fit.",
    )
    # What matters of it stands among the reasons.
    return replace(found, folded=True)


def _known(*tables: Table | None) -> tuple[Table, ...]:
    return tuple(table for table in tables if table is not None)
