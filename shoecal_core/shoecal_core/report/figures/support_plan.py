"""A planned motion seen from above: feet, sensing hull, landmarks and the CoP's way."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.patches import Circle

from shoecal_core.arrays import FloatArray
from shoecal_core.report.figures.feet import (
    LEFT,
    Above,
    FootShape,
    draw_feet,
    draw_outline,
    from_above,
    polygon_key,
)
from shoecal_core.report.palette import CARD, FAIL, INK, MODEL, MUTED, SOLE, STEPS, Look
from shoecal_core.report.plan.content import BOTH, PlannedMotion, Stand
from shoecal_core.report.svg import (
    SMALL,
    TEXT,
    WIDTH,
    Canvas,
    area_key,
    draw_line,
    line_key,
    marker_key,
)
from shoecal_core.shoe.shoe import FEET

HULL, SWING = Look(MODEL, 1.1, (4.0, 2.0)), Look(MUTED, 1.4, (1.5, 1.5))
ROOM = 0.05
"""Around the feet, as part of what is shown."""
LABEL, LINE, LETTER = 15.0, 4.0, 3.0
"""Units from a landmark to its number; more for a second line and for each further letter."""


@dataclass(frozen=True)
class Swing:
    """A foot on its way through the air.

    Attributes:
        way: (n, 2) of its sole's middle [m].
        outline: (k, 2) of the sole where it comes down [m].
    """

    way: FloatArray
    outline: FloatArray


def swing(planned: PlannedMotion, stand: Stand) -> Swing:
    """The way of the foot that does not carry."""
    foot = 1 - FEET.index(stand.feet)
    outline = planned.robot.feet[foot].outline
    middle, samples = outline.mean(axis=0)[None], range(stand.begin, stand.end)
    way = np.vstack([planned.placed(foot, sample, middle) for sample in samples])
    return Swing(way, planned.placed(foot, stand.end - 1, outline))


def support_plan(plan: PlannedMotion) -> str:
    """A motion from above, in the world; colours show the time."""
    feet = [
        FootShape(FEET[side], plan.placed(side, 0, foot.outline),
                  plan.placed(side, 0, foot.sensing_polygon), np.zeros((0, 2)))
        for side, foot in enumerate(plan.robot.feet)
    ]  # fmt: skip
    swings = [swing(plan, stand) for stand in plan.stands if stand.feet != BOTH]
    points = 1e3 * np.vstack(
        [
            plan.cop,
            *(foot.outline for foot in feet),
            *(one.outline for one in swings),
            *(mark.place[None] for mark in plan.marks),
        ]
    )
    low, high = points.min(axis=0), points.max(axis=0)
    room = ROOM * float((high - low).max())
    panel = Above(low - [1.5 * room, room], high + room, partial(_draw, plan, feet, swings))
    return from_above(
        [panel], [_shape_keys(swings), _path_keys(plan)], _alt(plan, swings), tallest=330.0,
        band=partial(_time_scale, plan.motion.time),
    )  # fmt: skip


def _draw(
    plan: PlannedMotion,
    feet: Sequence[FootShape],
    swings: Sequence[Swing],
    axes: Axes,
    scale: float,
) -> None:
    draw_feet(axes, feet)
    for hull in plan.hulls:
        draw_outline(axes, hull, HULL)
    for one in swings:
        _draw_swing(axes, one)
    _draw_path(axes, plan)
    _draw_marks(axes, plan, scale)


def _alt(plan: PlannedMotion, swings: Sequence[Swing]) -> str:
    missed = [f"landmark {mark.label}" for mark in plan.marks if mark.missing]
    reached = "; ".join(missed) or "all reached"
    return (
        "Planned motion seen from above: soles, sensing polygons, their hull, "
        f"{len(plan.marks)} landmarks in the order of pursuit ({reached}), and the CoP's path "
        f"over {plan.motion.time[-1]:.1f} s"
        + (f", with {len(swings)} ways of a lifted foot." if swings else ".")
    )


def _time_scale(time: FloatArray, page: Canvas, top: float) -> None:
    """A bar of the path's colours with their times."""
    page.write(LEFT, top + 5.0, "CoP path by time", fontsize=SMALL, va="center")
    axes = page.panel(top, 9.0, left=LEFT + 88.0, right=WIDTH - 20.0)
    axes.grid(visible=False)
    axes.spines[:].set_visible(False)
    edges = np.linspace(time[0], time[-1], len(STEPS) + 1)
    for colour, begin, end in zip(STEPS, edges[:-1], edges[1:], strict=True):
        axes.axvspan(begin, end, facecolor=colour.light, edgecolor="none", linewidth=0.0)
    axes.set_xlim(time[0], time[-1])
    axes.set_yticks([])
    axes.set_xticks([time[0], (time[0] + time[-1]) / 2.0, time[-1]])
    axes.set_xticklabels([f"{moment:.0f} s" for moment in axes.get_xticks()])
    axes.tick_params(axis="x", length=0.0, pad=1.5)


def _draw_path(axes: Axes, plan: PlannedMotion) -> None:
    x, y = 1e3 * plan.cop.T
    parts = np.array_split(np.arange(len(x)), len(STEPS))
    for colour, part in zip(STEPS, parts, strict=True):
        if not len(part):
            continue
        # One sample of the next part, so that there is no gap.
        shown = np.append(part, min(part[-1] + 1, len(x) - 1))
        draw_line(axes, y[shown], x[shown], Look(colour, 2.2))
        _arrow(axes, np.column_stack((y[shown], x[shown])), colour.light)
    for index, marker, size, fill in ((0, "o", 6.5, CARD), (-1, "s", 4.5, INK)):
        axes.plot(y[index], x[index], marker, markersize=size, markerfacecolor=fill.light,
                  markeredgecolor=INK.light, markeredgewidth=1.4, zorder=4.0)  # fmt: skip


def _arrow(axes: Axes, points: FloatArray, colour: str) -> None:
    """A head in the middle of a way, where there is one."""
    length = np.concatenate(([0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))))
    if length[-1] < 12.0:
        return
    (x, y), (x_before, y_before) = (
        (float(np.interp(at, length, points[:, 0])), float(np.interp(at, length, points[:, 1])))
        for at in (length[-1] / 2.0, length[-1] / 2.0 - 1.0)
    )
    style = {"arrowstyle": "-|>", "color": colour, "mutation_scale": 15.0, "linewidth": 0.1,
             "shrinkA": 0.0, "shrinkB": 0.0}  # fmt: skip
    axes.annotate("", (x, y), (x_before, y_before), arrowprops=style, zorder=3.0)


def _draw_marks(axes: Axes, plan: PlannedMotion, scale: float) -> None:
    """Rings and numbers; the scale is in units a millimetre."""
    if not plan.marks:
        return
    places = 1e3 * np.array([mark.place for mark in plan.marks])
    centre, radius = places.mean(axis=0), 1e3 * plan.settings.landmark_radius
    for mark, place in zip(plan.marks, places, strict=True):
        colour = (FAIL if mark.missing else INK).light
        dashes = (0, (2.5, 1.5)) if mark.missing else "-"
        axes.add_patch(Circle(place[::-1], radius, facecolor="none", edgecolor=colour,
                              linewidth=1.2, linestyle=dashes, zorder=4.0))  # fmt: skip
        axes.plot(place[1], place[0], "+", color=colour, markersize=4.0, zorder=4.0)
        away = place - centre
        length = np.linalg.norm(away)
        outward = away / length if length > 1.0 else np.array([1.0, 0.0])
        lines = [mark.numbers]
        if mark.missing:
            lines.append(mark.missing.removesuffix(" off"))
        room = [LINE * (len(lines) - 1), LETTER * (max(map(len, lines)) - 1)]
        x, y = place + (LABEL + np.array(room)) / scale * outward
        axes.text(y, x, "\n".join(lines), color=colour, ha="center", va="center", fontsize=TEXT,
                  fontweight="bold", linespacing=1.1, zorder=5.0)  # fmt: skip


def _draw_swing(axes: Axes, one: Swing) -> None:
    draw_outline(axes, one.outline, SWING)
    x, y = 1e3 * one.way.T
    draw_line(axes, y, x, SWING)
    _arrow(axes, np.column_stack((y, x)), MUTED.light)


def _shape_keys(swings: Sequence[Swing]) -> list[Artist]:
    keys: list[Artist] = [
        area_key(SOLE, "sole"),
        polygon_key(),
        line_key(HULL, "sensing hull"),
    ]
    if swings:
        keys.append(line_key(SWING, "lifted foot"))
    return keys


def _path_keys(plan: PlannedMotion) -> list[Artist]:
    keys: list[Artist] = [
        marker_key("o", INK, "start", 6.5),
        marker_key("s", INK, "end", filled=True),
    ]
    if plan.marks:
        keys.append(marker_key("o", INK, "landmark, in order", 6.0))
    if any(mark.missing for mark in plan.marks):
        keys.append(marker_key("o", FAIL, "not reached: distance", 6.0))
    return keys
