"""Tables of the expected errors and of what the data identify."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from shoecal_core.planning.supports.identifiability import WeakDirection
from shoecal_core.report.assessment_content import AssessmentContent
from shoecal_core.report.assessment_figures import cause_name, rms
from shoecal_core.report.error_source_names import cure, source_name
from shoecal_core.report.page import Table
from shoecal_core.report.quantities import UNKNOWN, number, size
from shoecal_core.screening.faults import Fault
from shoecal_core.screening.result import Screening
from shoecal_core.shoe.shoe import FEET

LISTED_SOURCES, LEAST_WIN = 6, 0.005


def expected_table(assessed: AssessmentContent) -> Table:
    """Expected errors of GRF and CoP."""
    found = assessed.assessment
    rows = []
    for label, spread in zip(
        ("both feet", *(f"{side} foot" for side in FEET)),
        (found.both, *found.feet),
        strict=True,
    ):
        lengths = spread.cop_mean[np.isfinite(spread.cop_mean)]
        rows.append(
            (
                label,
                size(rms(spread.grf), "N"),
                size(1e3 * float(lengths.mean()), "mm") if len(lengths) else UNKNOWN,
                *(size(1e3 * rms(spread.cop[:, axis]), "mm") for axis in (0, 1)),
                size(1e3 * float(lengths.max()), "mm") if len(lengths) else UNKNOWN,
            )
        )
    return Table(
        "Expected errors" if assessed.carried else "Known part of the errors",
        ("", "GRF", "CoP", "CoP along x", "CoP along y", "CoP, worst place"),
        tuple(rows),
        "CoP: mean absolute error over the sensing polygons. GRF, and the CoP along one axis: "
        "one standard deviation. Both feet: in the neutral double support, CoP anywhere between "
        "them. One foot: under half the weight.",
    )


def helps_table(assessed: AssessmentContent) -> Table | None:
    """What knowing an error source exactly would win; None where that is not known."""
    budget = assessed.assessment.budget
    if budget is None:
        return None
    known = [
        one
        for one in budget.sources
        if np.isfinite(one.without).all() and (one.without < (1.0 - LEAST_WIN) * budget.total).any()
    ]
    known.sort(key=lambda one: float(np.sum(one.without**2)))
    rows = tuple(
        (
            source_name(one.effect),
            f"{one.share[0]:.0%} ({one.interval[0, 0]:.0%} to {one.interval[0, 1]:.0%})",
            *(
                _falls(float(now), float(then))
                for now, then in zip(budget.total, one.without, strict=True)
            ),
            cure(one.effect) or UNKNOWN,
        )
        for one in known[:LISTED_SOURCES]
    )
    return Table(
        "What would help most",
        (
            "if known exactly", "share of both feet (95 %)", "both feet",
            *(f"{side} foot" for side in FEET), "how",
        ),
        rows,
        "Expected CoP error before → after. The interval is that of the share in this calibration.",
    )  # fmt: skip


def _falls(now: float, then: float) -> str:
    """Both in mm; a dash where nothing changes."""
    decimals = 1 if now < 0.01 else 0
    before, after = (number(1e3 * value, decimals) for value in (now, then))
    return UNKNOWN if before == after else f"{before} → {after} mm"


def weak_table(weak: Sequence[WeakDirection], note: str = "") -> Table | None:
    """Directions that data leave open; None without any."""
    if not weak:
        return None
    rows = tuple((one.words, _known_to(one.uncertainty)) for one in weak)
    return Table("Left open by the data", ("direction", "what is known of it"), rows, note)


def _known_to(uncertainty: float) -> str:
    if not math.isfinite(uncertainty):
        return "nothing"
    return f"uncertain by {100.0 * uncertainty:.0f} %"


def left_out_table(screening: Screening) -> Table | None:
    """Samples that do not count, by run and cause; None without any."""
    if not screening.left_out:
        return None
    lost = {(one.run, one.fault): one for one in screening.left_out}
    faults = [fault for fault in Fault if any(fault is other for _, other in lost)]
    rows = []
    for run, count in screening.samples.items():
        own = [lost.get((run, fault)) for fault in faults]
        if not any(own):
            continue
        rows.append(
            (
                f"run {run}" + (" (all of it)" if run in screening.runs_left_out else ""),
                str(count),
                *(f"{one.samples} ({_percent(one.share)})" if one else UNKNOWN for one in own),
            )
        )
    return Table(
        "Samples left out",
        ("", "samples", *(cause_name(fault.value) for fault in faults)),
        tuple(rows),
        "Each counts for the first cause that was found of it.",
    )


def _percent(share: float) -> str:
    return f"{100.0 * share:.1f} %" if share >= 0.001 else "below 0.1 %"


def findings_table(screening: Screening) -> Table | None:
    """What was found before the fit; None where nothing was."""
    findings = screening.findings
    if not findings:
        return None
    rows = tuple(
        (cause_name(one.fault.value) if one.fault else "other", one.verdict, one.reason)
        for one in findings
    )
    return Table("Found before the fit", ("", "verdict", "finding"), rows)
