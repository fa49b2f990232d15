"""Detection against strength, as a picture."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from blind.cases import Case
from blind.intervals import clopper_pearson
from shoecal_core.arrays import FloatArray
from shoecal_core.report import palette
from shoecal_core.report.palette import Look
from shoecal_core.report.sheet import SheetFigure, write_sheet
from shoecal_core.report.svg import WIDTH, canvas, draw_line, line_key

HEIGHT = 210.0
BORDERS = (0.0, 1.1, 1.5, 2.1, 3.0, 4.2, 6.0, 9.0, np.inf)
"""Of the gap over the floor."""
LOOKS = {"found": Look(palette.FOUND, 1.8), "right effect first": Look(palette.INK, 1.8)}


def write_chart(cases: Sequence[Case], file: Path) -> None:
    """Draw it from single effects."""
    single = [case for case in cases if case.answer.category == "single"]
    rows = {
        "found": _shares(single, [case.found for case in single]),
        "right effect first": _shares(single, [case.first_right for case in single]),
    }
    alt = "Share of single effects found, and named right, against their gap over the floor."
    file.parent.mkdir(parents=True, exist_ok=True)
    write_sheet(
        file, [[SheetFigure("Single effects, by the size of their gap", _drawn(rows, alt))]], alt
    )


def _shares(cases: Sequence[Case], hits: Sequence[bool]) -> FloatArray:
    """(k, 4) median gap, share, and its interval, of every span of gaps that holds any."""
    rows = []
    for low, high in itertools.pairwise(BORDERS):
        inside = [
            (case.gap, hit) for case, hit in zip(cases, hits, strict=True) if low <= case.gap < high
        ]
        if inside:
            gaps, right = zip(*inside, strict=True)
            interval = clopper_pearson(sum(right), len(right))
            rows.append([float(np.median(gaps)), sum(right) / len(right), *interval])
    return np.array(rows, dtype=np.float64).reshape(-1, 4)


def _drawn(rows: dict[str, FloatArray], alt: str) -> str:
    with canvas(HEIGHT) as page:
        page.legend([line_key(look, name) for name, look in LOOKS.items()], left=46.0)
        axes = page.panel(26.0, HEIGHT - 66.0, left=52.0, right=WIDTH - 10.0)
        for shift, (name, look) in enumerate(LOOKS.items()):
            gap, share, low, high = rows[name].T
            gap = gap * (1.0 + 0.03 * shift)
            draw_line(axes, gap, 100.0 * share, look)
            axes.plot(gap, 100.0 * share, "o", color=look.colour.light, markersize=4.0)
            axes.vlines(gap, 100.0 * low, 100.0 * high, color=look.colour.light, linewidth=0.8)
        axes.set_xscale("log")
        ticks = (1, 1.5, 2, 3, 4, 6, 10, 20, 50)
        left, right = axes.get_xlim()
        shown = [tick for tick in ticks if left <= tick <= right]
        axes.set_xticks(shown, [f"{tick:g}" for tick in shown])
        axes.set_xticks([], minor=True)
        axes.set_ylim(-2.0, 102.0)
        axes.set_xlabel("gap over the floor")
        axes.set_ylabel("share of the sets (%)")
        return page.svg(alt)
