"""A planned CoP against time, with the landmarks it comes to and the feet that carry."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from shoecal_core.report.palette import BLUE, CARD, FAIL, INK, MUTED, RED, SLATE, Colour, Look
from shoecal_core.report.svg import SMALL, canvas, draw_line

FloatArray = NDArray[np.float64]

HEIGHT, GAP, TOP, STRIP = 120.0, 16.0, 34.0, 12.0
CARRIERS: dict[str, Colour] = {"both": SLATE, "left": BLUE, "right": RED}
LABELS = ("CoP x (mm)", "CoP y (mm)")
APART = 0.03
"""Part of the time shown that two numbers need between them."""
LEAST = 4.0
"""mm that are shown at least."""


@dataclass(frozen=True)
class Arrival:
    """When the CoP was nearest to a landmark.

    Attributes:
        number: of the landmark.
        time: [s].
        place: (2,) of the landmark [m].
        reached: near enough.
    """

    number: int
    time: float
    place: FloatArray
    reached: bool


@dataclass(frozen=True)
class Carried:
    """From when to when which feet carry: `both`, `left` or `right` [s]."""

    feet: str
    begin: float
    end: float


def cop_plan(
    time: FloatArray, cop: FloatArray, arrivals: Sequence[Arrival], carried: Sequence[Carried]
) -> str:
    """CoP x above, CoP y below, the carrying feet above both where they change.

    Args:
        time: (T,) [s].
        cop: (T, 2) [m].
        arrivals: at landmarks.
        carried: one after another; one alone is not drawn.
    """
    changes = len(carried) > 1
    top = TOP + (STRIP + 16.0 if changes else 0.0)
    with canvas(top + 2 * HEIGHT + GAP + 34.0) as page:
        page.legend(_keys(arrivals), left=46.0)
        if changes:
            page.legend(_carrier_keys(carried), left=46.0, top=17.0)
            strip = page.panel(TOP + 2.0, STRIP, left=52.0)
            strip.set_axis_off()
            strip.set_xlim(time[0], time[-1])
            for while_ in carried:
                strip.axvspan(while_.begin, while_.end, edgecolor="none",
                              facecolor=CARRIERS[while_.feet].light)  # fmt: skip
        for row, label in enumerate(LABELS):
            axes = page.panel(top + row * (HEIGHT + GAP), HEIGHT, left=52.0)
            _draw(axes, time, 1e3 * cop[:, row], arrivals, row)
            axes.set_ylabel(label)
            axes.yaxis.set_label_coords(-0.115, 0.5)
            axes.tick_params(labelbottom=row == len(LABELS) - 1)
            if row == 0:
                _number(axes, arrivals, APART * float(time[-1] - time[0]))
        axes.set_xlabel("time (s)")
        return page.svg(_alt(time, arrivals, carried))


def _draw(
    axes: Axes, time: FloatArray, values: FloatArray, arrivals: Sequence[Arrival], axis: int
) -> None:
    for one in arrivals:
        axes.axvline(one.time, color=MUTED.light, linewidth=0.7, dashes=(2.0, 2.0))
    draw_line(axes, time, values, Look(INK, 1.4))
    for one in arrivals:
        colour = (INK if one.reached else FAIL).light
        axes.plot(one.time, 1e3 * one.place[axis], "o", markersize=6.0, color=colour,
                  markerfacecolor=CARD.light, zorder=4.0)  # fmt: skip
    shown = np.append(values, [1e3 * one.place[axis] for one in arrivals])
    spread = max(LEAST - float(np.ptp(shown)), 0.0) / 2.0
    margin = 0.08 * float(np.ptp(shown)) + spread
    axes.set_ylim(shown.min() - margin, shown.max() + margin)
    axes.set_xlim(time[0], time[-1])
    axes.yaxis.set_major_locator(MaxNLocator(nbins=5, integer=True))


def _number(axes: Axes, arrivals: Sequence[Arrival], apart: float) -> None:
    """Numbers above the lines; those of lines less than a time [s] apart stand together."""
    groups: list[list[Arrival]] = []
    for one in arrivals:
        # The numbers of a group are as wide as there are many.
        if groups and one.time - groups[-1][-1].time < apart * (1 + len(groups[-1])) / 2:
            groups[-1].append(one)
        else:
            groups.append([one])
    for group in groups:
        middle = float(np.mean([one.time for one in group]))
        colour = INK if all(one.reached for one in group) else FAIL
        axes.annotate(", ".join(str(one.number) for one in group), (middle, 1.0), (0.0, 2.0),
                      xycoords=("data", "axes fraction"), textcoords="offset points",
                      ha="center", fontsize=SMALL, color=colour.light,
                      fontweight="bold")  # fmt: skip


def _alt(time: FloatArray, arrivals: Sequence[Arrival], carried: Sequence[Carried]) -> str:
    comes = ", ".join(f"{one.number} at {one.time:.1f} s" for one in arrivals) or "none"
    feet = ", ".join(f"{one.feet} from {one.begin:.1f} s" for one in carried)
    return (
        f"Planned CoP x and y [mm] over {time[-1]:.1f} s; nearest to landmarks: {comes}; "
        f"carrying feet: {feet}."
    )


def _keys(arrivals: Sequence[Arrival]) -> list[Line2D]:
    keys = [Line2D([], [], color=INK.light, linewidth=1.4, label="planned CoP")]
    for reached, label in ((True, "landmark, when nearest"), (False, "not reached")):
        if any(one.reached == reached for one in arrivals):
            colour = (INK if reached else FAIL).light
            keys.append(Line2D([], [], linestyle="", marker="o", markersize=6.0, color=colour,
                               markerfacecolor=CARD.light, label=label))  # fmt: skip
    return keys


def _carrier_keys(carried: Sequence[Carried]) -> list[Patch]:
    found = {one.feet for one in carried}
    names = {"both": "both feet carry", "left": "left alone", "right": "right alone"}
    return [
        Patch(facecolor=CARRIERS[feet].light, edgecolor="none", label=name)
        for feet, name in names.items()
        if feet in found
    ]
