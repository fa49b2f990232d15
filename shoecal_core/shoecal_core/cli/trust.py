"""How far a calibration can be trusted, for a terminal."""

from __future__ import annotations

from shoecal_core.estimation.uncertainty.assessment import Assessment
from shoecal_core.estimation.uncertainty.budget import Budget
from shoecal_core.report.calibration.assessment_tables import another_text, rms, source_name
from shoecal_core.report.quantities import quantity
from shoecal_core.report.recorded_tables import cause_name
from shoecal_core.report.weak_table import weak_lines
from shoecal_core.screening.result import Screening

LISTED = 3
"""Error sources that are named."""


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
        lines.append(another_text(assessment))
    count = sum(screening.samples.values())
    lost = sum(one.samples for one in screening.left_out)
    if lost:
        causes = dict.fromkeys(cause_name(one.fault) for one in screening.left_out)
        lines.append(
            f"left out before the fit: {lost} of {count} samples ({lost / count:.1%}): "
            + ", ".join(causes)
        )
    return lines


def budget_text(budget: Budget) -> str:
    """The largest sources of the CoP error of both feet, as the report has them."""
    sizes = {source_name(one.effect): 1e3 * rms(one.size[:1]) for one in budget.sources}
    largest = sorted(sizes, key=lambda name: sizes[name], reverse=True)[:LISTED]
    return ", ".join(f"{name} {quantity(sizes[name], 'mm', 1)}" for name in largest)
