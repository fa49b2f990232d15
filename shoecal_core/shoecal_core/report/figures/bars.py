"""Mean absolute errors of GRF and CoP as bars, by stage or by run."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.patches import Patch

from shoecal_core.estimation.series import Mae
from shoecal_core.report.palette import INK, MUTED, Look
from shoecal_core.report.svg import SMALL, area_key, canvas, readable, y_label

HEIGHT, GAP, TOP = 128.0, 24.0, 40.0
MOST_LABELLED = 10
"""With more bars than these their figures would not fit above them."""


@dataclass(frozen=True)
class Bar:
    """One bar in each panel.

    Attributes:
        group: bars of one name stand together.
        look: its colour.
        label: what the colour means.
        test: of runs that were not fitted: drawn empty.
        grf: [N].
        cop: [m].
    """

    group: str
    look: Look
    label: str
    test: bool
    grf: Mae
    cop: Mae


def mae_bars(bars: Sequence[Bar]) -> str:
    """GRF above, CoP below; whiskers are one standard deviation of the absolute error."""
    groups = list(dict.fromkeys(bar.group for bar in bars))
    slots = _slots(bars, groups)
    with canvas(TOP + 2 * HEIGHT + GAP + 24.0) as page:
        page.legend(_colour_keys(bars), left=46.0)
        page.legend(_set_keys(bars), left=46.0, top=17.0)
        for row, (label, scale) in enumerate((("GRF MAE (N)", 1.0), ("CoP MAE (mm)", 1e3))):
            axes = page.panel(TOP + row * (HEIGHT + GAP), HEIGHT, left=52.0)
            found = [bar.cop if row else bar.grf for bar in bars]
            _draw(axes, bars, slots, found, scale)
            y_label(axes, label)
            axes.set_xticks(_centres(bars, slots, groups), [readable(one, 20) for one in groups])
            axes.tick_params(axis="x", length=0.0, labelcolor=INK.light)
        return page.svg(_alt(bars))


def _slots(bars: Sequence[Bar], groups: Sequence[str]) -> list[float]:
    """Places of the bars, a gap of half a bar between groups."""
    places, x, before = [], 0.0, groups[0]
    for bar in bars:
        x += 0.6 if bar.group != before else 0.0
        before = bar.group
        places.append(x)
        x += 1.0
    return places


def _centres(bars: Sequence[Bar], slots: Sequence[float], groups: Sequence[str]) -> list[float]:
    of_group: dict[str, list[float]] = {group: [] for group in groups}
    for bar, x in zip(bars, slots, strict=True):
        of_group[bar.group].append(x)
    return [float(np.mean(places)) for places in of_group.values()]


def _draw(
    axes: Axes, bars: Sequence[Bar], slots: Sequence[float], found: Sequence[Mae], scale: float
) -> None:
    axes.grid(visible=False, axis="x")
    top = 0.0
    for bar, x, mae in zip(bars, slots, found, strict=True):
        if not mae.count:
            continue
        height, std = scale * mae.mean, scale * mae.std
        colour = bar.look.colour.light
        face = "none" if bar.test else colour
        axes.bar(x, height, 0.78, facecolor=face, edgecolor=colour, linewidth=1.4)
        axes.errorbar(x, height, [[min(height, std)], [std]], color=MUTED.light, linewidth=1.0,
                      capsize=2.5)  # fmt: skip
        top = max(top, height + std)
        if len(bars) <= MOST_LABELLED:
            axes.annotate(f"{height:.2f}", (x, height + std), (0.0, 3.5),
                          textcoords="offset points", ha="center", fontsize=SMALL)  # fmt: skip
    axes.set_ylim(0.0, 1.22 * top if top > 0.0 else 1.0)
    axes.set_xlim(slots[0] - 0.8, max(slots[-1], 2.0) + 0.8)
    axes.locator_params(axis="y", nbins=5)


def _colour_keys(bars: Sequence[Bar]) -> list[Artist]:
    looks = {bar.label: bar.look for bar in bars}
    return [area_key(look.colour, label) for label, look in looks.items()]


def _set_keys(bars: Sequence[Bar]) -> list[Artist]:
    keys: list[Artist] = []
    for test, label in ((False, "filled: training runs"), (True, "empty: test runs")):
        if any(bar.test is test for bar in bars):
            face = "none" if test else MUTED.light
            keys.append(Patch(facecolor=face, edgecolor=MUTED.light, label=label))
    return keys


def _alt(bars: Sequence[Bar]) -> str:
    listed = (
        f"{readable(bar.group)}, {readable(bar.label)}, {'test' if bar.test else 'training'}: "
        f"GRF {bar.grf.mean:.2f} N, CoP {1e3 * bar.cop.mean:.2f} mm"
        for bar in bars
    )
    return f"Mean absolute errors. {'; '.join(listed)}."
