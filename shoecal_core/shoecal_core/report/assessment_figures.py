"""Figures of the expected errors and of what the data identify."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from shoecal_core.estimation.expected import Spread
from shoecal_core.report.assessment_content import AssessmentContent
from shoecal_core.report.calibration_content import CalibrationReport
from shoecal_core.report.error_source_names import source_name
from shoecal_core.report.figures.directions import singular_values
from shoecal_core.report.figures.error_map import ErrorMap, common_levels, error_map
from shoecal_core.report.figures.left_out import RunSpan, left_out_in_time
from shoecal_core.report.figures.sources import largest_sources
from shoecal_core.report.figures.spans import spans
from shoecal_core.report.foot_shapes import foot_shape
from shoecal_core.report.page import Picture
from shoecal_core.report.quantities import channel_units, number, size
from shoecal_core.robot.double_support import DoubleSupport
from shoecal_core.screening.result import Screening
from shoecal_core.shoe.shoe import FEET

SHOWN_SOURCES = 8


def rms(values: np.ndarray[tuple[int, ...], np.dtype[np.float64]]) -> float:
    """Root mean square of values (p,) in their unit; NaN is left out."""
    return float(np.sqrt(np.nanmean(values**2)))


def error_pictures(content: CalibrationReport, assessed: AssessmentContent) -> tuple[Picture, ...]:
    """Maps of the CoP's expected error, both feet together and each."""
    robot, shoe, found = content.robot, content.shoe, assessed.assessment
    neutral = DoubleSupport(*(float(value) for value in robot.support_range.neutral))
    own = [foot_shape(robot, shoe, foot) for foot in (0, 1)]
    both = ErrorMap(
        "both feet together",
        (own[0], foot_shape(robot, shoe, 1, neutral)),
        found.both.places,
        found.both.cop_mean,
    )
    each = [
        ErrorMap(f"{side} foot", (shape,), spread.places, spread.cop_mean)
        for side, shape, spread in zip(FEET, own, found.feet, strict=True)
    ]
    levels = common_levels([both, *each])
    title = assessed.error_name[0].upper() + assessed.error_name[1:]
    listed = "; ".join(
        f"{side} {_summary(spread)}" for side, spread in zip(FEET, found.feet, strict=True)
    )
    return (
        Picture(
            f"{title}, both feet",
            error_map([both], levels),
            f"Where the CoP is, and by how much it may be off: {_summary(found.both)}.",
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


def source_pictures(assessed: AssessmentContent) -> tuple[Picture, ...]:
    """Error sources of the CoP of both feet together, and of single feet; none for a walk."""
    budget = assessed.assessment.budget
    if budget is None:
        return ()
    pictures = []
    for label, part in (("both feet together", slice(0, 1)), ("a single foot", slice(1, 3))):
        sizes = {source_name(one.effect): 1e3 * rms(one.size[part]) for one in budget.sources}
        largest = sorted(sizes, key=lambda name: sizes[name], reverse=True)[:SHOWN_SOURCES]
        pictures.append(
            Picture(
                f"Error sources of the CoP, {label}",
                largest_sources(largest, [sizes[name] for name in largest], "mm", "expected error"),
                "Root mean square over the sensing polygons. The squares of all sources add up to "
                "the square of the expected error.",
            )
        )
    return tuple(pictures)


def direction_picture(assessed: AssessmentContent) -> Picture:
    """Singular values."""
    found = assessed.assessment.told
    return Picture(
        f"Identified: {found.rank} of {assessed.possible} directions",
        singular_values(found.singular_values, 1.0 / assessed.fixed_below),
        "Each direction is a pattern of gains and offsets. One over its value is what the data "
        "leave of it: 100 is 1 % of the gains, or of each channel's even share of the weight.",
    )


def load_pictures(content: CalibrationReport, assessed: AssessmentContent) -> tuple[Picture, ...]:
    """How far each channel was loaded, forces apart from torques."""
    shoe, ends = content.shoe, assessed.assessment.load_range
    pictures = []
    for torque, kind in ((False, "force"), (True, "torque")):
        chosen = np.flatnonzero(shoe.torque == torque)
        if not len(chosen):
            continue
        unit, _ = channel_units(shoe, torque=torque)
        alike = bool((shoe.columns[chosen, 0] == 1.0).all())
        share = content.calibration.weight / len(shoe.names) if alike and not torque else None
        names = [shoe.names[index] for index in chosen]
        pictures.append(
            Picture(
                f"Loads seen, {kind} channels",
                spans(names, ends[:, chosen], unit, share),
                "Lowest and highest output in the training runs; beyond them the calibration "
                "extrapolates.",
            )
        )
    return tuple(pictures)


def left_out_picture(content: CalibrationReport, assessed: AssessmentContent) -> Picture | None:
    """When samples were left out; None where every one counts."""
    ends: dict[int, float] = {
        run.run: max(float(one.stance.time[-1]) for one in run.stances) for run in content.runs
    }
    return left_out_spans(assessed.screening, ends)


def left_out_spans(screening: Screening, ends: Mapping[int, float]) -> Picture | None:
    """The same of any screening.

    Args:
        screening: of a recording.
        ends: when each run ends, since its start [s].
    """
    if not screening.left_out:
        return None
    lost: dict[int, dict[str, list[tuple[float, float]]]] = {}
    for one in screening.left_out:
        found = lost.setdefault(one.run, {}).setdefault(cause_name(one.fault.value), [])
        found.extend(one.stretches)
    runs = []
    for run in screening.samples:
        own = lost.get(run, {})
        last = [end for found in own.values() for _, end in found]
        runs.append(RunSpan(f"run {run}", 0.0, max([ends.get(run, 0.0), *last]), own))
    shown = [run for run in runs if run.end > 0.0]
    if not shown:
        return None
    return Picture("Samples left out, in time", left_out_in_time(shown))


def cause_name(value: str) -> str:
    """A fault's name for a person."""
    return value.replace("_", " ")


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
