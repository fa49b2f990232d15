"""The report on a session before any calibration, as a page and as a file."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from shoecal_core.estimation.uncertainty.assessment import Assessment
from shoecal_core.estimation.weight import Weighed
from shoecal_core.recording.info import RunInfo
from shoecal_core.recording.run import Run
from shoecal_core.recording.session import RunEntry, Session
from shoecal_core.report import palette
from shoecal_core.report.calibration.assessment_tables import expected_table
from shoecal_core.report.figures.strips import Strip, strips
from shoecal_core.report.html import write_page
from shoecal_core.report.next_step import after_check
from shoecal_core.report.origin import origin, robot_text, shoe_text
from shoecal_core.report.page import (
    Group,
    KeyFigure,
    Page,
    PageVerdict,
    Picture,
    Reason,
    Section,
    Table,
)
from shoecal_core.report.quantities import UNKNOWN, double_support_text, quantity, uncertain
from shoecal_core.report.recorded_tables import zeros_section
from shoecal_core.report.screening_parts import left_out_group
from shoecal_core.report.svg import line_key
from shoecal_core.report.weak_table import weak_table
from shoecal_core.robot.gravity import GRAVITY
from shoecal_core.robot.robot import Robot
from shoecal_core.samples.aligned import Aligned
from shoecal_core.samples.zeros import ZeroFigures
from shoecal_core.screening.result import Screening
from shoecal_core.shoe.shoe import FEET

MEANING = {
    "PASS": "This session is fit for a calibration.",
    "WARN": "This session is fit for a calibration: read the warnings first.",
    "FAIL": "This session cannot be calibrated from as it is.",
}


@dataclass(frozen=True)
class CheckReport:
    """A session as `shoecal check` finds it.

    Attributes:
        session: the folder.
        robot: in its shoes.
        entries: of the runs that can be read.
        runs: by number.
        aligned: of them, where joint angles and readings go together.
        screening: what was found in them.
        problems: what is in the way of a calibration, a line each.
        warnings: what is not, but should be looked at.
        zeros: what feet read in the air.
        weighed: the weight by data sheets; None where it cannot be known.
        assessed: how certain a calibration from it would be; None where there can be none.
    """

    session: Session
    robot: Robot
    entries: tuple[RunEntry, ...]
    runs: Mapping[int, Run]
    aligned: Mapping[int, Aligned]
    screening: Screening
    problems: tuple[str, ...]
    warnings: tuple[str, ...]
    zeros: tuple[ZeroFigures, ...] = ()
    weighed: Weighed | None = None
    assessed: Assessment | None = None

    @property
    def verdict(self) -> str:
        """PASS, WARN or FAIL."""
        return "FAIL" if self.problems else "WARN" if self.warnings else "PASS"


def raw_picture(content: CheckReport, entry: RunEntry) -> Picture:
    """Each channel of one run against time, over its own range in the whole session."""
    shoe, readings = content.session.shoe, content.runs[entry.run].readings
    faulty = {
        name for one in content.screening.left_out if one.run == entry.run for name in one.channels
    }
    rows = []
    for index, channel in enumerate(shoe.channels):
        low, high = _range(content, index)
        values = readings.value[:, index]
        known = np.isfinite(values)
        moved = (
            np.where(known, np.abs(values - np.median(values[known])), -1.0)
            if known.any()
            else None
        )
        spread = float(np.ptp(values[known])) if known.any() else float("nan")
        rows.append(
            Strip(
                label=channel.name,
                time=readings.time,
                lines=((palette.FEET[channel.foot], values),),
                low=low,
                high=high,
                limits=tuple(end for end in (channel.lowest, channel.highest) if low < end < high),
                number=quantity(spread, shoe.unit, 2),
                worst=0 if moved is None else int(np.argmax(moved)),
                kept=bool(known.any()) and channel.name not in faulty,
            )
        )
    keys = [line_key(look, side) for look, side in zip(palette.FEET, FEET, strict=True)]
    svg = strips(rows, keys, "each strip: that channel’s range", "range here")
    caption = f"Faulty: {', '.join(sorted(faulty))}." if faulty else ""
    return Picture(f"Run {entry.run} ({entry.info.motion})", svg, caption)


def _range(content: CheckReport, index: int) -> tuple[float, float]:
    """Lowest and highest reading of a channel in all runs, a little widened."""
    every = np.concatenate([run.readings.value[:, index] for run in content.runs.values()])
    known = every[np.isfinite(every)]
    if not len(known):
        return -1.0, 1.0
    low, high = float(known.min()), float(known.max())
    margin = max(0.05 * (high - low), 1e-6 * max(abs(low), abs(high)), 1e-9)
    return low - margin, high + margin


def check_report(path: Path, content: CheckReport) -> None:
    """Write the report as one self-contained HTML file.

    Raises:
        FileError: when it cannot be written.
    """
    write_page(path, check_page(content))


def check_page(content: CheckReport) -> Page:
    """The report, ready to be rendered; the same content makes the same page."""
    session = content.session
    runs = [entry.run for entry in content.entries]
    count = len(runs)
    return Page(
        title=f"Check of {session.robot} on {session.shoe_name}",
        subtitle=f"folder {session.folder.name} · {count} run{'' if count == 1 else 's'} "
        "that can be read",
        verdict=_verdict(content),
        key_figures=_key_figures(content),
        sections=(
            _runs(content),
            *_reached(content),
            _left_out(content),
            *zeros_section(content.zeros),
            *_raw(content),
            _details(content),
        ),
        provenance=(origin(session, runs), "Raw readings: nothing here rests on a calibration."),
    )


def _verdict(content: CheckReport) -> PageVerdict:
    reasons = [Reason("FAIL", text) for text in content.problems]
    reasons += [Reason("WARN", text) for text in content.warnings]
    following = after_check(content.verdict, content.session.folder.name)
    lines = (following,) if following else ()
    return PageVerdict(content.verdict, MEANING[content.verdict], tuple(reasons), lines=lines)


def _key_figures(content: CheckReport) -> tuple[KeyFigure, ...]:
    runs = content.runs.values()
    readings = [run.readings.rate_hz for run in runs]
    joints = [run.joints.rate_hz for run in runs]
    counted = sum(content.screening.samples.values())
    lost = sum(one.samples for one in content.screening.left_out)
    late = content.screening.time_offset
    weight = uncertain(content.robot.weight, content.robot.mass_std * GRAVITY, "N")
    return (
        KeyFigure("recorded", quantity(sum(_duration(entry, content) for entry in content.entries),
                                       "s", 0), "all runs together"),
        KeyFigure("samples that count", _share(counted - lost, counted),
                  f"{counted - lost} of {counted}"),
        KeyFigure("readings come at", _rates(readings), "the lowest and the highest of a run"),
        KeyFigure("joint angles come at", _rates(joints), "the lowest and the highest of a run"),
        KeyFigure("time offset", quantity(1e3 * late, "ms", 1), "joints after readings, found "
                  "before the fit") if late else KeyFigure("time offset", "none",
                  "joints after readings, before the fit"),
        KeyFigure("double supports", str(len(_supports(content))),
                  "distinct; they must differ in yaw, too"),
        KeyFigure("reference weight", weight, "robot and shoes, ± standard uncertainty"),
        *_weighed(content.weighed),
    )  # fmt: skip


def _weighed(weighed: Weighed | None) -> tuple[KeyFigure, ...]:
    if weighed is None:
        return ()
    text = uncertain(weighed.kg, 0.5 * (weighed.ci95[1] - weighed.ci95[0]), "kg")
    return (KeyFigure("weight by data sheets", text, "of the robot's own sensors; 95 % interval"),)


def _supports(content: CheckReport) -> set[tuple[float, float, float]]:
    places = [entry.info.support for entry in content.entries if entry.info.support is not None]
    return {(round(one.dx, 3), round(one.dy, 3), round(one.dtheta, 2)) for one in places}


def _runs(content: CheckReport) -> Section:
    rows = tuple(
        (
            f"run {entry.run}",
            entry.hint or UNKNOWN,
            entry.info.motion,
            _support(entry.info),
            quantity(_duration(entry, content), "s", 1),
            quantity(content.runs[entry.run].joints.rate_hz, "Hz", 0),
            quantity(content.runs[entry.run].readings.rate_hz, "Hz", 0),
            "; ".join(content.runs[entry.run].notes) or UNKNOWN,
        )
        for entry in content.entries
    )
    header = ("", "set", "motion", "right foot from the left", "duration", "joint angles",
              "readings", "notes")  # fmt: skip
    group = Group(tables=(Table("Runs", header, rows),) if rows else ())
    return Section("What was recorded", (group,))


def _reached(content: CheckReport) -> tuple[Section, ...]:
    if content.assessed is None:
        return ()
    tables = (expected_table(content.assessed), weak_table(content.assessed.identifiability))
    group = Group(tables=tuple(table for table in tables if table is not None))
    return (Section("What a calibration would reach", (group,)),)


def _left_out(content: CheckReport) -> Section:
    ends = {number: float(run.readings.time[-1]) for number, run in content.runs.items()}
    return Section("What a calibration would leave out", (left_out_group(content.screening, ends),))


def _raw(content: CheckReport) -> tuple[Section, ...]:
    if not content.entries:
        return ()
    first, *others = (raw_picture(content, entry) for entry in content.entries)
    groups = [Group(pictures=(first,))]
    if others:
        title = f"{len(others)} more run{'s' if len(others) > 1 else ''}"
        groups.append(Group(title, pictures=tuple(others), folded=True))
    text = (
        "Every channel as it was read. A line that stands still, jumps, or runs along the end of "
        "its range belongs to a cell or a cable to look at."
    )
    return (Section("Raw readings", tuple(groups), text),)


def _details(content: CheckReport) -> Section:
    session, robot = content.session, content.robot
    rows = (
        ("session", str(session.folder.name)),
        ("robot", robot_text(robot)),
        ("shoe", shoe_text(session.shoe)),
        ("channels", str(len(session.shoe.names))),
        ("joints", f"{len(robot.joint_names)}, of which {len(robot.legs)} legs' motors"),
    )  # fmt: skip
    return Section("Details", (Group(tables=(Table("What it belongs to", ("", ""), rows),)),))


def _support(info: RunInfo) -> str:
    if info.support is not None:
        return double_support_text(info.support)
    return "both feet in the air" if info.hanging else "none (walking)"


def _duration(entry: RunEntry, content: CheckReport) -> float:
    time = content.runs[entry.run].readings.time
    return float(time[-1] - time[0]) if len(time) else 0.0


def _rates(rates: list[float]) -> str:
    if not rates:
        return UNKNOWN
    low, high = min(rates), max(rates)
    if round(low) == round(high):
        return quantity(low, "Hz", 0)
    return f"{low:.0f} to {quantity(high, 'Hz', 0)}"


def _share(part: int, whole: int) -> str:
    return quantity(100.0 * part / whole, "%", 1) if whole else UNKNOWN
