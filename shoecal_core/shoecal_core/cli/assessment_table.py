"""How far a calibration can be trusted, and what was left out, for a terminal."""

from __future__ import annotations

from collections import Counter

import numpy as np
from rich.table import Table

from shoecal_core.arrays import FloatArray
from shoecal_core.cli.tables import new_table
from shoecal_core.estimation.assessment import Assessment
from shoecal_core.estimation.budget import Budget
from shoecal_core.report.weak_table import weak_lines
from shoecal_core.screening.faults import Fault
from shoecal_core.screening.result import Screening
from shoecal_core.shoe.shoe import FEET


def screening_table(screening: Screening) -> Table:
    """One line a run that lost something: its samples, and how many of them each fault cost."""
    lost = Counter[tuple[int, Fault]]()
    for one in screening.left_out:
        lost[one.run, one.fault] += one.samples
    faults = [fault for fault in Fault if any(fault is other for _, other in lost)]
    table = new_table("Samples left out")
    for name in ("run", "samples", *(fault.value.replace("_", " ") for fault in faults)):
        table.add_column(name, justify="right")
    for run, count in screening.samples.items():
        cells = [lost[run, fault] for fault in faults]
        if any(cells):
            texts = [f"{one} ({one / count:.1%})" if one else "-" for one in cells]
            table.add_row(str(run), str(count), *texts)
    return table


LISTED = 3
"""Error sources that are named."""


def expected_table(assessment: Assessment) -> Table:
    """Expected GRF error (standard deviation) and CoP MAE over the sensing polygons.

    Both feet stand in the neutral double support; a single foot bears half the weight.
    """
    carried = assessment.budget is not None
    table = new_table("Expected errors" if carried else "Known part of the errors")
    table.add_column("", no_wrap=True)
    for name in ("GRF (N)", "CoP MAE (mm)", "at worst (mm)"):
        table.add_column(name, justify="right", no_wrap=True)
    for label, spread in zip(
        ("both feet", *(f"{side} foot" for side in FEET)),
        (assessment.both, *assessment.feet),
        strict=True,
    ):
        lengths = 1e3 * spread.cop_mean[np.isfinite(spread.cop_mean)]
        table.add_row(
            label,
            f"{_rms(spread.grf):.2f}",
            f"{lengths.mean():.1f}" if len(lengths) else "-",
            f"{lengths.max():.1f}" if len(lengths) else "-",
        )
    return table


def trust_lines(assessment: Assessment, screening: Screening) -> list[str]:
    """What was identified, what was not, what was left out."""
    known = assessment.identifiability
    lines = []
    if assessment.budget is None:
        lines.append("the model's own errors come on top: least squares alone do not know them")
    possible = max(known.possible, known.rank)
    lines += [f"the data identify {known.rank} of {possible} directions", *weak_lines(known)]
    if assessment.budget is not None:
        lines.append(f"largest sources of the expected CoP error: {budget_text(assessment.budget)}")
    if assessment.another is not None:
        lines.append(another_text(assessment, assessment.another.run))
    count = sum(screening.samples.values())
    lost = sum(one.samples for one in screening.left_out)
    if lost:
        causes = dict.fromkeys(one.fault.value.replace("_", " ") for one in screening.left_out)
        lines.append(
            f"left out before the fit: {lost} of {count} samples ({lost / count:.1%}): "
            + ", ".join(causes)
        )
    return lines


def another_text(assessment: Assessment, run: int) -> str:
    """What recording a run once more would win."""
    both, feet = assessment.expected_cop()
    then, feet_then = assessment.expected_cop_with_another()
    falls = [f"both feet {_fall(both, then)}"]
    falls += [f"{name} {_fall(size, feet_then[name])}" for name, size in feet.items()]
    return f"expected CoP error if run {run} were recorded once more: {', '.join(falls)} mm"


def _fall(now: float, then: float) -> str:
    return f"{1e3 * now:.1f} to {1e3 * then:.1f}"


def budget_text(budget: Budget) -> str:
    """The largest sources of the CoP error of both feet, with their shares."""
    largest = sorted(budget.sources, key=lambda one: float(one.share[0]), reverse=True)[:LISTED]
    return ", ".join(f"{one.effect} {one.share[0]:.0%}" for one in largest)


def _rms(values: FloatArray) -> float:
    return float(np.sqrt(np.mean(values**2)))
