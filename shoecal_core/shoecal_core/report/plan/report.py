"""What was planned, to be looked at: a page for all motions, a picture for each."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from shoecal_core.planning.supports.identifiability import Identifiability
from shoecal_core.report.figures.margins import margin_text
from shoecal_core.report.html import write_page
from shoecal_core.report.next_step import after_plan
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
from shoecal_core.report.plan.animation import animation
from shoecal_core.report.plan.content import PlannedMotion
from shoecal_core.report.plan.figures import motion_pictures
from shoecal_core.report.quantities import double_support_text, quantity
from shoecal_core.report.sheet import SheetFigure, write_sheet
from shoecal_core.report.svg import readable
from shoecal_core.report.weak_table import weak_table
from shoecal_core.robot.double_support import DoubleSupport
from shoecal_core.robot.robot import Robot

PAGE = "plan.html"
NOTE = "A plan, computed from the robot’s model; nothing was measured."


@dataclass(frozen=True)
class Unplanned:
    """A double support in which no motion could be planned.

    Attributes:
        label: what its motion would have been called.
        support: where.
        reason: why not, in a line.
    """

    label: str
    support: DoubleSupport
    reason: str


def write_plan(
    folder: Path,
    motions: Sequence[PlannedMotion],
    unplanned: Sequence[Unplanned] = (),
    known: Identifiability | None = None,
) -> None:
    """Write `plan.html`, and next to it `LABEL.svg` for every motion.

    Args:
        folder: to write into.
        motions: one at least.
        unplanned: double supports in which there is none.
        known: what a calibration from these motions would fix, where that is known.

    Raises:
        FileError: when a file cannot be written.
    """
    pictures = [motion_pictures(planned) for planned in motions]
    for planned, drawn in zip(motions, pictures, strict=True):
        write_sheet(folder / picture_name(planned), _rows(planned, drawn), _alt(planned))
    write_page(folder / PAGE, plan_page(motions, pictures, unplanned, known))


def picture_name(planned: PlannedMotion) -> str:
    """File of a motion's picture."""
    return f"{planned.label}.svg"


def _rows(
    planned: PlannedMotion, pictures: Sequence[Picture]
) -> tuple[tuple[SheetFigure, ...], ...]:
    parts = [SheetFigure(picture.title, picture.svg) for picture in pictures]
    parts[0] = SheetFigure(f"{heading(planned)}: seen from above", parts[0].svg, (NOTE,))
    return tuple(parts[:3]), tuple(parts[3:])


def _alt(planned: PlannedMotion) -> str:
    return f"{heading(planned)}, as planned; {support_text(planned.motion.support)}."


def plan_page(
    motions: Sequence[PlannedMotion],
    pictures: Sequence[tuple[Picture, ...]],
    unplanned: Sequence[Unplanned] = (),
    known: Identifiability | None = None,
) -> Page:
    """The page, ready to be rendered; the same motions make the same page.

    Args:
        motions: one at least.
        pictures: of each.
        unplanned: double supports in which there is none.
        known: what a calibration from them would fix, where that is known.
    """
    open_directions = weak_table(known) if known else None
    more = (_unplanned_table(unplanned) if unplanned else None, open_directions)
    tables = (_table(motions), *(table for table in more if table is not None))
    robot = motions[0].robot
    count = len(motions)
    return Page(
        title=f"Planned motions of {readable(robot.name)}",
        subtitle=f"{count} motion{'s' if count > 1 else ''}, each from standing still to standing "
        "still",
        verdict=verdict(motions, unplanned, known),
        key_figures=(*_key_figures(motions), *(_fixed_figure(known) if known else ())),
        sections=(
            Section("All motions", (Group(tables=tables),)),
            Section(
                "Each motion",
                tuple(
                    _group(planned, drawn, folded=number > 0)
                    for number, (planned, drawn) in enumerate(zip(motions, pictures, strict=True))
                ),
            ),
        ),
        provenance=(
            NOTE,
            _robot_line(robot),
        ),
    )


def _fixed_figure(known: Identifiability) -> tuple[KeyFigure, ...]:
    fixed = f"{known.rank} of {known.possible}"
    return (KeyFigure("would be identified", fixed, "directions of gains and offsets"),)


def _fixed_line(known: Identifiability) -> str:
    """A sentence for the verdict: a feasible motion may still identify too little."""
    if known.rank >= known.possible:
        return "A calibration from these motions would identify every identifiable direction."
    return (
        f"A calibration from these motions alone would identify {known.rank} of {known.possible} "
        "directions: add double supports with other yaws between the feet."
    )


def _robot_line(robot: Robot) -> str:
    return (
        f"Robot file {robot.path.name}, SHA-256 {robot.digest[:12]}…; "
        f"{quantity(robot.mass, 'kg', 3)} with shoes."
    )


def verdict(
    motions: Sequence[PlannedMotion],
    unplanned: Sequence[Unplanned] = (),
    known: Identifiability | None = None,
) -> PageVerdict:
    """Whether the robot may do it, what it will not reach, and whether it identifies enough."""
    lines = (_fixed_line(known),) if known else ()
    following = (*lines, after_plan(f"{motions[0].label}.csv"))
    reasons = []
    for planned in motions:
        for finding in planned.report.violated:
            text = f"{planned.label}: {finding.constraint} is {margin_text(finding)}"
            where = f" ({finding.where})" if finding.where else ""
            reasons.append(Reason("FAIL", f"{text}{where}; do not send it."))
    violated = bool(reasons)
    reasons += [Reason("FAIL", f"{one.label}: not planned: {one.reason}") for one in unplanned]
    for planned in motions:
        missed = [
            f"{one.number} ({one.off(planned.settings.landmark_radius)})"
            for one in planned.targets
            if not one.reached
        ]
        if missed:
            text = f"{planned.label}: out of reach: landmark {', '.join(missed)}."
            reasons.append(Reason("WARN", text))
    if violated:
        return PageVerdict(
            "FAIL", "Not every motion keeps its limits.", tuple(reasons), lines=lines
        )
    if unplanned:
        count = len(motions) + len(unplanned)
        meaning = f"{len(unplanned)} of {count} motions could not be planned."
        return PageVerdict("FAIL", meaning, tuple(reasons), lines=lines)
    meaning = "Every motion keeps all limits in a check that is independent of the planner."
    if reasons:
        meaning = f"{meaning} Not every landmark is reached."
        return PageVerdict("WARN", meaning, tuple(reasons), lines=following)
    return PageVerdict("PASS", f"{meaning} Every landmark is reached.", (), lines=following)


def heading(planned: PlannedMotion) -> str:
    """What a motion is called."""
    return readable(f"{planned.label} ({planned.motion.name})", 40)


def support_text(support: DoubleSupport) -> str:
    """Where the right foot stands."""
    return f"right foot from the left: {double_support_text(support)}"


def _key_figures(motions: Sequence[PlannedMotion]) -> tuple[KeyFigure, ...]:
    targets = [one for planned in motions for one in planned.targets]
    reached = sum(one.reached for one in targets)
    radius = motions[0].settings.landmark_radius
    torque = max(motions, key=lambda planned: planned.peak_torque[0])
    room = min(motions, key=lambda planned: planned.least_room)
    return (
        KeyFigure("landmarks reached", f"{reached} of {len(targets)}",
                  f"within {quantity(1e3 * radius, 'mm', 1)}"),
        KeyFigure("duration", quantity(sum(one.motion.duration for one in motions), "s", 0),
                  "all motions, without the way from one double support to the next"),
        KeyFigure("highest torque", quantity(100.0 * torque.peak_torque[0], "%", 0),
                  f"of its limit, {torque.peak_torque[1]}, {torque.label}"),
        KeyFigure("CoP from the hull’s edge", quantity(1e3 * room.least_room, "mm", 1),
                  f"at least, {room.label}"),
    )  # fmt: skip


def _table(motions: Sequence[PlannedMotion]) -> Table:
    rows = tuple(
        (
            planned.label,
            planned.motion.name,
            quantity(1e3 * planned.motion.support.dx, "mm", 0),
            quantity(1e3 * planned.motion.support.dy, "mm", 0),
            quantity(math.degrees(planned.motion.support.dtheta), "°", 1),
            quantity(planned.motion.duration, "s", 1),
            f"{sum(one.reached for one in planned.targets)} of {len(planned.targets)}",
            f"{quantity(100.0 * planned.peak_torque[0], '%', 0)} ({planned.peak_torque[1]})",
        )
        for planned in motions
    )
    header = (
        "", "motion", "right foot: forward", "to the left", "yaw", "duration",
        "landmarks reached", "highest torque",
    )  # fmt: skip
    note = "The right foot’s position is given in the left sole’s frame, at the motion’s start."
    return Table("Motions", header, rows, note)


def _unplanned_table(unplanned: Sequence[Unplanned]) -> Table:
    rows = tuple((one.label, support_text(one.support), one.reason) for one in unplanned)
    return Table("Not planned", ("", "double support", "reason"), rows)


def _group(planned: PlannedMotion, pictures: tuple[Picture, ...], *, folded: bool) -> Group:
    text = f"{support_text(planned.motion.support)}; {planned.motion.duration:.1f} s."
    return Group(
        heading(planned),
        text[0].upper() + text[1:],
        pictures,
        player=animation(planned),
        folded=folded,
    )
