"""How far each constraint of a motion is used up."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from shoecal_core.planning.checking.findings import ConstraintMargin
from shoecal_core.report.palette import FAIL, INK, MUTED, SOLE, TEAL
from shoecal_core.report.quantities import SPACE, number
from shoecal_core.report.svg import SMALL, WIDTH, area_key, canvas, readable

ROW, TOP, BOTTOM = 30.0, 22.0, 38.0
SHOWN = 1.08
"""Share of a limit at which a bar ends; whatever is further is as bad."""
SCALES = {
    "m": ("mm", 1e3),
    "m/s": ("mm/s", 1e3),
    "rad": ("°", 180.0 / np.pi),
    "rad/s": ("°/s", 180.0 / np.pi),
}
"""Units that are easier to read than those of the check."""


def at_least(finding: ConstraintMargin) -> bool:
    """Whether the value must be no less than its limit, else no more."""
    below, beyond = finding.limit - finding.value, finding.value - finding.limit
    return abs(finding.excess - below) < abs(finding.excess - beyond)


def used(finding: ConstraintMargin) -> float:
    """Part of the limit that is used: 1 at the limit, 0 far from it."""
    numbers = (finding.limit, finding.value) if at_least(finding) else (
        finding.value, finding.limit)  # fmt: skip
    part, whole = numbers
    if whole <= 0.0:
        return 0.0 if finding.kept else np.inf
    return max(part / whole, 0.0)


def margin_text(finding: ConstraintMargin) -> str:
    """The worst value, its limit and where it was."""
    unit, scale = SCALES.get(finding.unit, (finding.unit, 1.0))
    decimals = _decimals(abs(scale * finding.limit))
    value, limit = (number(scale * each, decimals) for each in (finding.value, finding.limit))
    bound = "at least" if at_least(finding) else "at most"
    space = "" if unit == "°" else SPACE
    return f"{value}{space}{unit}, {bound} {limit}{space}{unit}"


def margins(findings: Sequence[ConstraintMargin]) -> str:
    """One bar a constraint, tightest first; its name, value and limit stand above it."""
    findings = sorted(findings, key=used, reverse=True)
    height = ROW * len(findings)
    with canvas(TOP + height + BOTTOM) as page:
        page.legend(_keys())
        axes = page.panel(TOP, height, left=6.0, right=WIDTH - 10.0)
        axes.grid(visible=False)
        axes.spines["left"].set_visible(False)
        rows = np.arange(len(findings))
        shares = np.array([min(used(finding), SHOWN) for finding in findings])
        colours = [(TEAL if finding.kept else FAIL).light for finding in findings]
        axes.barh(rows, np.full(len(rows), 1.0), 0.26, color=SOLE.light, edgecolor="none")
        axes.barh(rows, shares, 0.26, color=colours, edgecolor="none")
        axes.vlines(np.ones(len(rows)), rows - 0.2, rows + 0.2, color=INK.light, linewidth=1.4)
        axes.set_ylim(len(rows) - 0.6, -0.78)
        axes.set_yticks([])
        axes.set_xlim(0.0, SHOWN)
        axes.set_xticks([0.0, 0.25, 0.5, 0.75, 1.0], ["0", "25", "50", "75", "100"])
        axes.set_xlabel("part of the limit used (%)")
        for row, finding in enumerate(findings):
            top = TOP + height * (row + 0.78 - 0.24) / (len(rows) + 0.18)
            page.write(6.0, top, _name(finding), va="bottom", fontsize=SMALL)
            colour = MUTED if finding.kept else FAIL
            page.write(WIDTH - 10.0, top, margin_text(finding), ha="right", va="bottom",
                       fontsize=SMALL, color=colour.light)  # fmt: skip
        listed = "; ".join(f"{finding.constraint} {margin_text(finding)}" for finding in findings)
        return page.svg(f"Worst value of each constraint over the motion: {listed}.")


def _name(finding: ConstraintMargin) -> str:
    """Short enough to leave room for the numbers."""
    names = {
        "distance of the CoP from the edge of the sensing polygon": "CoP from the hull's edge",
        "distance between capsules": "capsules",
        "distance from joint limits": "joint limits",
        "drift of the way between the feet": "feet drift apart",
        "drift of the turn between the feet": "feet turn",
        "shift of the CoP by acceleration": "CoP shift by acceleration",
        "way while holding still": "moves while holding still",
    }
    where = f" · {finding.where}" if finding.where else ""
    return readable(names.get(finding.constraint, finding.constraint) + where, 46)


def _decimals(limit: float) -> int:
    """So many that the limit has three digits, four decimals at most."""
    if limit <= 0.0 or not np.isfinite(limit):
        return 2
    return int(np.clip(2 - np.floor(np.log10(limit)), 0, 4))


def _keys() -> list[Patch | Line2D]:
    return [
        area_key(TEAL, "kept"),
        area_key(FAIL, "violated"),
        Line2D([], [], color=INK.light, linewidth=1.0, label="limit of the check"),
    ]
