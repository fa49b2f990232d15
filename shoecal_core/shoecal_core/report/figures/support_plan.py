"""A planned motion seen from above: feet, sensing hull, landmarks and the CoP's way."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patches import Circle, Patch, Polygon
from numpy.typing import NDArray

from shoecal_core.report.figures.feet import FootShape, draw_feet
from shoecal_core.report.palette import CARD, FAIL, INK, MUTED, SLATE, SOLE, STEPS, Look
from shoecal_core.report.plan_content import TargetMark
from shoecal_core.report.svg import SMALL, TEXT, WIDTH, Canvas, canvas, draw_line

FloatArray = NDArray[np.float64]

LEFT, TOP, BOTTOM = 50.0, 84.0, 36.0
ROOM = 0.05
"""Around the feet, as part of what is shown."""
LABEL, LINE, LETTER = 15.0, 4.0, 3.0
"""Units from a landmark to its number; more for a second line and for each further letter."""
TALLEST = 330.0


@dataclass(frozen=True)
class Swing:
    """A foot on its way through the air.

    Attributes:
        way: (n, 2) of its sole's middle [m].
        outline: (k, 2) of the sole where it comes down [m].
    """

    way: FloatArray
    outline: FloatArray


@dataclass(frozen=True)
class SupportPlan:
    """What is seen from above, in one frame, x forward, y to the left.

    Attributes:
        feet: left and right at the start.
        hulls: (h, 2) each, where the CoP may be [m].
        marks: the landmarks, in the order of pursuit.
        radius: within which one counts as reached [m].
        time: (T,) [s].
        cop: (T, 2) planned [m].
        swings: of steps, in their order.
    """

    feet: Sequence[FootShape]
    hulls: Sequence[FloatArray]
    marks: Sequence[TargetMark]
    radius: float
    time: FloatArray
    cop: FloatArray
    swings: Sequence[Swing] = ()


def support_plan(plan: SupportPlan) -> str:
    """The plan from above; colours show the time."""
    points = np.vstack(
        [
            plan.cop,
            *(foot.outline for foot in plan.feet),
            *(swing.outline for swing in plan.swings),
            *(mark.place[None] for mark in plan.marks),
        ]
    )
    low, high = 1e3 * points.min(axis=0), 1e3 * points.max(axis=0)
    room = ROOM * float((high - low).max())
    low, high = low - [1.5 * room, room], high + room
    width = WIDTH - LEFT - 8.0
    scale = min(width / (high[1] - low[1]), TALLEST / (high[0] - low[0]))
    height = scale * (high[0] - low[0])
    spare = width / scale - (high[1] - low[1])
    with canvas(TOP + height + BOTTOM) as page:
        page.legend(_shape_keys(plan), left=LEFT - 6.0, top=34.0)
        page.legend(_path_keys(plan), left=LEFT - 6.0, top=52.0)
        _time_scale(page, plan.time)
        axes = page.panel(TOP, height, left=LEFT)
        draw_feet(axes, plan.feet)
        for hull in plan.hulls:
            axes.add_patch(Polygon(1e3 * hull[:, ::-1], facecolor="none", edgecolor=SLATE.light,
                                   linewidth=1.1, linestyle=(0, (4, 2))))  # fmt: skip
        for swing in plan.swings:
            _draw_swing(axes, swing)
        _draw_path(axes, plan)
        _draw_marks(axes, plan, scale)
        axes.set_ylim(low[0], high[0])
        axes.set_xlim(high[1] + spare / 2.0, low[1] - spare / 2.0)
        axes.locator_params(nbins=6)
        axes.set_ylabel("x, forward (mm)")
        axes.yaxis.set_label_coords(-38.0 / width, 0.5)
        axes.set_xlabel("y, to the left (mm)")
        return page.svg(_alt(plan))


def _alt(plan: SupportPlan) -> str:
    missed = [f"landmark {mark.label}" for mark in plan.marks if mark.missing]
    reached = "; ".join(missed) or "all reached"
    return (
        "Planned motion seen from above: soles, sensing polygons, their hull, "
        f"{len(plan.marks)} landmarks in the order of pursuit ({reached}), and the CoP's path "
        f"over {plan.time[-1]:.1f} s"
        + (f", with {len(plan.swings)} ways of a lifted foot." if plan.swings else ".")
    )


def _time_scale(page: Canvas, time: FloatArray) -> None:
    """A bar of the path's colours with their times."""
    page.write(LEFT, 12.0, "CoP path by time", fontsize=SMALL, va="center")
    axes = page.panel(7.0, 9.0, left=LEFT + 88.0, right=WIDTH - 20.0)
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


def _draw_path(axes: Axes, plan: SupportPlan) -> None:
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


def _draw_marks(axes: Axes, plan: SupportPlan, scale: float) -> None:
    """Rings and numbers; the scale is in units a millimetre."""
    if not plan.marks:
        return
    places = 1e3 * np.array([mark.place for mark in plan.marks])
    centre = places.mean(axis=0)
    for mark, place in zip(plan.marks, places, strict=True):
        colour = (FAIL if mark.missing else INK).light
        dashes = (0, (2.5, 1.5)) if mark.missing else "-"
        axes.add_patch(Circle(place[::-1], 1e3 * plan.radius, facecolor="none", edgecolor=colour,
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


def _draw_swing(axes: Axes, swing: Swing) -> None:
    axes.add_patch(Polygon(1e3 * swing.outline[:, ::-1], facecolor="none", edgecolor=MUTED.light,
                           linewidth=1.0, linestyle=(0, (1.5, 1.5))))  # fmt: skip
    x, y = 1e3 * swing.way.T
    axes.plot(y, x, color=MUTED.light, linewidth=1.4, linestyle=(0, (1.5, 1.5)))
    _arrow(axes, np.column_stack((y, x)), MUTED.light)


def _shape_keys(plan: SupportPlan) -> list[Artist]:
    keys: list[Artist] = [
        Patch(facecolor=SOLE.light, edgecolor="none", label="sole"),
        Patch(facecolor="none", edgecolor=MUTED.light, linewidth=0.9, label="sensing polygon"),
        Line2D([], [], color=SLATE.light, linewidth=1.1, linestyle=(0, (4, 2)),
               label="sensing hull"),
    ]  # fmt: skip
    if plan.swings:
        keys.append(Line2D([], [], color=MUTED.light, linewidth=1.4, linestyle=(0, (1.5, 1.5)),
                           label="lifted foot"))  # fmt: skip
    return keys


def _path_keys(plan: SupportPlan) -> list[Artist]:
    def ring(colour: str, label: str) -> Line2D:
        return Line2D([], [], linestyle="", marker="o", markersize=6.0, markerfacecolor="none",
                      color=colour, label=label)  # fmt: skip

    keys: list[Artist] = [
        Line2D([], [], linestyle="", marker="o", markersize=6.5, markerfacecolor=CARD.light,
               color=INK.light, markeredgewidth=1.4, label="start"),
        Line2D([], [], linestyle="", marker="s", markersize=4.5, color=INK.light, label="end"),
    ]  # fmt: skip
    if plan.marks:
        keys.append(ring(INK.light, "landmark, in order"))
    if any(mark.missing for mark in plan.marks):
        keys.append(ring(FAIL.light, "not reached: distance"))
    return keys
