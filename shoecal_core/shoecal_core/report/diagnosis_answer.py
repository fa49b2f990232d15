"""The answer of a diagnosis in a few sentences, and its key figures."""

from __future__ import annotations

import math
from collections.abc import Mapping

from shoecal_core.diagnosis.result import VERDICTS, Cause, Diagnosis, Shrink
from shoecal_core.diagnosis.result import Verdict as Finding
from shoecal_core.report.diagnosis_places import left_over
from shoecal_core.report.diagnosis_words import (
    candidate_text,
    effect_text,
    listed,
    name_of,
    place_text,
    sizes_text,
    where_text,
)
from shoecal_core.report.figures.shares import percent
from shoecal_core.report.page import KeyFigure, Verdict
from shoecal_core.report.quantities import SPACE, number

LEVELS: Mapping[Finding, str] = {
    "no_gap": "PASS",
    "explained": "PASS",
    "ambiguous": "WARN",
    "partly_explained": "WARN",
    "unknown": "FAIL",
}
"""How well the question was answered, as colour and sign."""


def verdict_of(diagnosis: Diagnosis) -> Verdict:
    """The first thing to read: what, where, how big, how far it shrinks, what remains."""
    meaning = VERDICTS[diagnosis.verdict]
    return Verdict(
        level=LEVELS[diagnosis.verdict],
        label=diagnosis.verdict.replace("_", " ").capitalize(),
        meaning=f"{meaning[0].upper()}{meaning[1:]}.",
        reasons=(),
        lines=tuple(
            line
            for line in (_what(diagnosis), _where(diagnosis), _shrinks(diagnosis))
            if line
        ),
    )  # fmt: skip


def key_figures(diagnosis: Diagnosis) -> tuple[KeyFigure, ...]:
    """Gap, shrink, and what is left of the gap."""
    gap, causes = diagnosis.gap, diagnosis.causes
    runs = run_text(diagnosis)
    keys = [
        KeyFigure("CoP off the model", millimetres(gap.cop_mae_mm),
                  f"noise alone: {millimetres(gap.cop_floor_mm)}; {runs}"),
        KeyFigure("GRF off the weight", newtons(gap.grf_mae_n),
                  f"noise alone: {newtons(gap.grf_floor_n)}; {runs}"),
    ]  # fmt: skip
    keys += [
        KeyFigure(candidate_text(cause), percent(cause.probability),
                  "; ".join(filter(None, ("probability", sizes_text(cause)))))
        for cause in causes
    ]  # fmt: skip
    if causes:
        shrink = causes[0].shrink
        label = f"with {name_of(causes[0].effect)} " if len(causes) > 1 else ""
        keys.append(
            KeyFigure(
                f"{label}the gap shrinks by", shrink_text(shrink.fraction), interval_text(shrink)
            )
        )
    return tuple(keys)


def run_text(diagnosis: Diagnosis) -> str:
    """The runs that figures are told of."""
    if not diagnosis.test:
        return "no test run"
    plural = "s" if len(diagnosis.test) > 1 else ""
    return f"test run{plural} {listed([str(run) for run in diagnosis.test])}"


def _what(diagnosis: Diagnosis) -> str:
    if not diagnosis.causes:
        if diagnosis.verdict == "no_gap":
            gap = diagnosis.gap
            return (
                f"CoP and GRF are off by {millimetres(gap.cop_mae_mm)} and "
                f"{newtons(gap.grf_mae_n)}, where noise alone leaves "
                f"{millimetres(gap.cop_floor_mm)} and {newtons(gap.grf_floor_n)}."
            )
        return "No effect of the library, at any place, changes the signals as they are off."
    told = f"Found: {listed([cause_text(cause) for cause in diagnosis.causes])}."
    rivals = [candidate_text(one) for one in diagnosis.ambiguity[1:]]
    if rivals:
        told += f" Not to be told from the first: {listed(rivals, 'or')}."
    return told


def cause_text(cause: Cause) -> str:
    """What it is, where and how big."""
    place = place_text(cause.effect, cause.location)
    run = "" if cause.run is None else f", in run {cause.run}"
    size = sizes_text(cause)
    told = f"{effect_text(cause.effect)}{f' ({place}{run})' if place or run else ''}"
    return f"{told}: {size}" if size else told


def _where(diagnosis: Diagnosis) -> str:
    shown = [place for place in diagnosis.where if place.share >= 0.05][:2]
    if not shown:
        return ""
    texts = [f"{where_text(place)} ({percent(place.share)})" for place in shown]
    return f"It shows most in: {'; then '.join(texts)}."


def _shrinks(diagnosis: Diagnosis) -> str:
    if not diagnosis.causes:
        return ""
    if len(diagnosis.causes) > 1:
        each = [
            f"with {candidate_text(one)} by {shrink_text(one.shrink.fraction)} "
            f"({interval_text(one.shrink)})"
            for one in diagnosis.causes
        ]
        told = f"On runs never used for a fit ({run_text(diagnosis)}) the gap shrinks "
        return f"{told}{listed(each)}.{_remains(diagnosis)}"
    shrink, gap = diagnosis.causes[0].shrink, diagnosis.gap
    cop, grf = shrink.cop_mae_mm, shrink.grf_mae_n
    return (
        f"On runs never used for a fit ({run_text(diagnosis)}) the gap shrinks by "
        f"{shrink_text(shrink.fraction)} ({interval_text(shrink)}): the CoP's error from "
        f"{number(cop[0], 2)} to {millimetres(cop[1])}, that of the GRF from "
        f"{number(grf[0], 2)} to {newtons(grf[1])}. "
        f"Noise alone would leave {millimetres(gap.cop_floor_mm)} and {newtons(gap.grf_floor_n)}."
    )


def _remains(diagnosis: Diagnosis) -> str:
    """What is left with all causes together."""
    evidence, gap = diagnosis.evidence, diagnosis.gap
    cop, grf = (math.nan, math.nan) if evidence is None else left_over(evidence)
    if not math.isfinite(cop):
        return ""
    return (
        f" With all of it the CoP is off by {millimetres(1e3 * cop)} (noise alone: "
        f"{millimetres(gap.cop_floor_mm)}), the GRF by {newtons(grf)} "
        f"({newtons(gap.grf_floor_n)})."
    )


def shrink_text(fraction: float) -> str:
    """A shrink in per cent; it can be below nothing."""
    return f"{number(100.0 * fraction, 0)}{SPACE}%" if math.isfinite(fraction) else "–"


def interval_text(shrink: Shrink) -> str:
    """Its 95 % interval."""
    low, high = (number(100.0 * end, 0) for end in shrink.ci95)
    return f"95{SPACE}% interval {low} to {high}{SPACE}%"


def millimetres(value: float) -> str:
    """An error of the CoP."""
    return f"{number(value, 2)}{SPACE}mm"


def newtons(value: float) -> str:
    """An error of the GRF."""
    return f"{number(value, 2)}{SPACE}N"
