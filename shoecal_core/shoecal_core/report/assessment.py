"""Expected errors of a calibration and what its data identify, as a section of the report."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from shoecal_core.estimation.assessment import Assessment
from shoecal_core.estimation.expected import Spread
from shoecal_core.report.calibration_content import CalibrationReport
from shoecal_core.report.figures.error_map import ErrorMap, common_levels, error_map
from shoecal_core.report.figures.feet import foot_shape
from shoecal_core.report.figures.named_bars import NamedBar, named_bars
from shoecal_core.report.page import Group, KeyFigure, Picture, Section, Table
from shoecal_core.report.palette import RED
from shoecal_core.report.quantities import UNKNOWN, number, quantity, size, uncertain
from shoecal_core.report.screening_parts import left_out_group
from shoecal_core.report.weak_table import weak_table
from shoecal_core.shoe.shoe import FEET

NAMES = {
    "backlash": "play of the gears",
    "cell_position": "places of the cells",
    "gains_and_offsets": "gains and offsets left to the prior",
    "joint_compliance": "compliance of the gears",
    "joint_offset": "zeros of the joints",
    "link_com": "centres of mass of the links",
    "link_mass": "masses of the links",
    "noise": "noise and model form error",
    "placement": "feet that stand elsewhere in a run",
    "plates": "plates that carry load past the cells",
    "sideways_force": "sideways forces at the cells' height",
    "soft_ground": "soles that tilt under load",
    "support": "where the right foot stands",
    "time_offset": "time offset of the joints",
    "zero_offset": "zeros of single runs",
}
CURES = {
    "cell_position": "measure where the cells are, or calibrate the shoe manually",
    "plates": "calibrate the shoe manually, with known weights",
    "joint_offset": "calibrate the robot's joints",
    "link_com": "measure the links' balance points",
    "link_mass": "weigh the links",
    "joint_compliance": "measure how far the joints give under load",
    "backlash": "measure the play of the joints",
    "zero_offset": "lift each foot in every run",
    "soft_ground": "stand on a stiff floor",
}
SHOWN_SOURCES = 8
LISTED_SOURCES, LEAST_WIN = 6, 0.005


def source_name(effect: str) -> str:
    """Its name for a person."""
    return NAMES.get(effect, effect.replace("_", " "))


def cure(effect: str) -> str | None:
    """What would make it smaller; None where nothing is known to."""
    return CURES.get(effect)


def carried(assessed: Assessment) -> bool:
    """The model's own errors are part of the uncertainties; of walking they are not."""
    return assessed.budget is not None


def error_name(assessed: Assessment) -> str:
    """What the expected error of the CoP may be called."""
    return "expected CoP error" if carried(assessed) else "known part of the CoP error"


def possible(assessed: Assessment) -> int:
    """Directions that the data could have fixed."""
    return max(assessed.identifiability.possible, assessed.identifiability.rank)


def rms(values: np.ndarray[tuple[int, ...], np.dtype[np.float64]]) -> float:
    """Root mean square of values (p,) in their unit; NaN is left out."""
    return float(np.sqrt(np.nanmean(values**2)))


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
            NamedBar(name, quantity(sizes[name], "mm", 1), sizes[name] / whole, RED)
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


def expected_table(assessed: Assessment) -> Table:
    """Expected errors of GRF and CoP."""
    rows = []
    for label, spread in zip(
        ("both feet", *(f"{side} foot" for side in FEET)),
        (assessed.both, *assessed.feet),
        strict=True,
    ):
        lengths = spread.cop_mean[np.isfinite(spread.cop_mean)]
        rows.append(
            (
                label,
                size(rms(spread.grf), "N"),
                size(1e3 * float(lengths.mean()), "mm") if len(lengths) else UNKNOWN,
                *(size(1e3 * rms(spread.cop[:, axis]), "mm") for axis in (0, 1)),
                size(1e3 * float(lengths.max()), "mm") if len(lengths) else UNKNOWN,
            )
        )
    return Table(
        "Expected errors" if carried(assessed) else "Known part of the errors",
        ("", "GRF", "CoP", "CoP along x", "CoP along y", "CoP, worst place"),
        tuple(rows),
        "CoP: mean absolute error over the sensing polygons. GRF, and the CoP along one axis: "
        "one standard deviation. Both feet: in the neutral double support, CoP anywhere between "
        "them. One foot: under half the weight.",
    )


def helps_table(assessed: Assessment) -> Table | None:
    """What knowing an error source exactly would win; None where that is not known."""
    budget = assessed.budget
    if budget is None:
        return None
    known = [
        one
        for one in budget.sources
        if cure(one.effect) is not None
        and np.isfinite(one.without).all()
        and (one.without < (1.0 - LEAST_WIN) * budget.total).any()
    ]
    if not known:
        return None
    known.sort(key=lambda one: float(np.sum(one.without**2)))
    # The budget is of mean squares; errors are stated as means of their size.
    mean = np.array([np.nanmean(one.cop_mean) for one in (assessed.both, *assessed.feet)])
    rows = tuple(
        (
            source_name(one.effect),
            *(
                _falls(float(now), float(now * ratio))
                for now, ratio in zip(mean, one.without / budget.total, strict=True)
            ),
            cure(one.effect) or UNKNOWN,
        )
        for one in known[:LISTED_SOURCES]
    )
    return Table(
        "What would help most",
        ("if known exactly", "both feet", *(f"{side} foot" for side in FEET), "how"),
        rows,
        "Expected CoP error before → after, as in the table of expected errors."
        + _another(assessed),
    )


def _another(assessed: Assessment) -> str:
    """What recording a run once more would win."""
    if assessed.another is None:
        return ""
    both, feet = assessed.expected_cop()
    then, feet_then = assessed.expected_cop_with_another()
    falls = [("both feet", both, then)]
    falls += [(f"{name} foot", size, feet_then[name]) for name, size in feet.items()]
    won = [f"{name} {fall}" for name, *sizes in falls if (fall := _falls(*sizes)) != UNKNOWN]
    run = f" Run {assessed.another.run} recorded once more"
    return f"{run}: {', '.join(won)}." if won else f"{run} would win nothing."


def _falls(now: float, then: float) -> str:
    """Both in mm; a dash where nothing changes."""
    decimals = 1 if now < 0.01 else 0
    before, after = (number(1e3 * value, decimals) for value in (now, then))
    return UNKNOWN if before == after else f"{before} → {after} mm"


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
        tables=_known(weak_table(found.weak, "" if add is None else f"To add: {add}.")),
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
