"""Scoring a round: opens the answers, once everything has been submitted."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from pathlib import Path

from blind.answers import check_seal
from blind.cases import Case, load_cases, variant_cases
from blind.chart import write_chart
from blind.entries import compared
from blind.figures import AS_BUILT, CLEAN, Figure, figures, shrink_figures
from blind.layout import Round
from blind.page import FIGURE, write
from blind.variants import LANDMARKS, TRUE, WITHOUT, run_variants

WHOLE = "everything"


def score(
    place: Round, jobs: int, *, command: str, ablations: int, project: Path | None
) -> dict[str, dict[str, Figure]]:
    """Every figure of a round, by kind of worlds; for a project its page, picture and JSON too.

    Args:
        place: of the round, all sets diagnosed.
        jobs: processes for the further looks.
        command: that makes the round, for the page.
        ablations: single sets that are looked at with something switched off; 0: none, and
            true effects are not looked at.
        project: whose docs/evidence/diagnosis.md and out/blind.json are written; None: nothing is.
    """
    cases, floors, failed = load_cases(place)
    if ablations:
        run_variants(place, cases, jobs, ablations)
    found = {}
    for name, as_built, aim in (("as built", True, AS_BUILT), ("clean", False, CLEAN)):
        own = [case for case in cases if case.answer.as_built is as_built]
        found[name] = figures(own, aim) | shrink_figures(_pairs(place, own))
    without = _ablations(place, cases, [*WITHOUT, LANDMARKS]) if ablations else {}
    if project is not None:
        write_chart(cases, project / FIGURE)
        counts = Counter(case.answer.category for case in cases)
        (cop, grf), (clean_cop, clean_grf) = (floors[kind].with_noise for kind in (True, False))
        about = {
            "command": command,
            "answers, SHA-256": check_seal(place),
            "sets": ", ".join(f"{count} {name}" for name, count in sorted(counts.items())),
            "laws of cells and timing": "drawn for each set",
            "worlds as built": sum(case.answer.as_built for case in cases),
            "sets that could not be simulated (the robot fell)": failed,
            "floor, as built: CoP [mm], GRF [N]": f"{cop:.2f}, {grf:.3f}",
            "floor, clean: CoP [mm], GRF [N]": f"{clean_cop:.2f}, {clean_grf:.3f}",
        }
        write(about, found, cases, without, compared(place, cases), project)
    return found


def _pairs(place: Round, cases: Sequence[Case]) -> list[tuple[Case, Case]]:
    """Single sets as diagnosed, and with the true effect given."""
    given = {case.answer.number: case for case in variant_cases(place, cases, _folder(TRUE))}
    return [(case, given[case.answer.number]) for case in cases if case.answer.number in given]


def _ablations(
    place: Round, cases: Sequence[Case], names: Sequence[str]
) -> dict[str, dict[str, Figure]]:
    """Figures of the same sets, whole and with something switched off."""
    told: dict[str, dict[str, Figure]] = {}
    for name in names:
        seen = variant_cases(place, cases, _folder(name))
        if seen and not told:
            numbers = {case.answer.number for case in seen}
            told[WHOLE] = figures([case for case in cases if case.answer.number in numbers])
        if seen:
            told[name] = figures(seen)
    return told


def _folder(variant: str) -> str:
    return variant.replace(" ", "_")
