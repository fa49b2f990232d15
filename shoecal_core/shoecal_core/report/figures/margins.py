"""How far each constraint of a motion is used up."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from shoecal_core.planning.checking.findings import ConstraintMargin
from shoecal_core.report.figures.named_bars import NamedBar, named_bars
from shoecal_core.report.palette import FAIL, PLAIN
from shoecal_core.report.quantities import SPACE, number
from shoecal_core.report.svg import readable

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
    space = "" if unit in {"", "°"} else SPACE
    return f"{value}{space}{unit}, {bound} {limit}{space}{unit}"


def margins(findings: Sequence[ConstraintMargin]) -> str:
    """One bar a constraint, tightest first; its name, value and limit stand above it."""
    bars = [
        NamedBar(short_name(one), margin_text(one), used(one), PLAIN if one.kept else FAIL,
                 "part of the limit used" if one.kept else "violated")
        for one in sorted(findings, key=used, reverse=True)
    ]  # fmt: skip
    return named_bars(bars, "Worst value of each constraint over the motion", "limit of the check")


def short_name(finding: ConstraintMargin) -> str:
    """Short enough to leave room for the numbers."""
    names = {
        "distance of the CoP from the edge of the sensing polygon": "CoP from the hull's edge",
        "distance between capsules": "capsules",
        "distance from joint limits": "joint limits",
        "drift of the way between the feet": "feet drift apart",
        "drift of the turn between the feet": "feet turn",
        "lever of the weight from the edge of a sole": "weight from the sole's edge",
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
