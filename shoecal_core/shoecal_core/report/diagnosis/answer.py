"""The answer of a diagnosis in a few sentences, and its key figures."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from shoecal_core.diagnosis.result import VERDICT_TEXTS, Cause, Diagnosis, Shrink, Verdict
from shoecal_core.error_sources.effects.words import name_of
from shoecal_core.error_sources.signals import COP, GRF
from shoecal_core.estimation.series import cop_mae, grf_mae
from shoecal_core.report.diagnosis.words import (
    finding_text,
    hypothesis_text,
    listed,
    sizes_text,
    state_text,
    where_text,
)
from shoecal_core.report.page import KeyFigure, PageVerdict
from shoecal_core.report.quantities import PLUS_MINUS, SPACE, number, percent

LEVELS: Mapping[Verdict, str] = {
    "no_gap": "PASS",
    "explained": "PASS",
    "ambiguous": "WARN",
    "partly_explained": "WARN",
    "unknown": "FAIL",
}
"""How well the question was answered, as colour and sign."""


UNKNOWN_CURE = (
    "Look at that signal below: on which foot, in which run and from when on it is off. What comes "
    "to mind can be described as an effect of its own and tried: --effects-from."
)
SMALL_N = 0.095
"""Smaller errors of the GRF are given to the millinewton [N]."""
LIKELY = 0.5
"""Causes of a smaller probability are reported as a hypothesis."""
MOST_CAUSES = 2
"""Causes that have a key figure of their own."""


def verdict_of(diagnosis: Diagnosis) -> PageVerdict:
    """The first thing to read: what, where, how big, how far it shrinks, what remains."""
    found = f"{finding_text(diagnosis.named[0])}. " if diagnosis.named else ""
    meaning = VERDICT_TEXTS[diagnosis.verdict]
    return PageVerdict(
        level=LEVELS[diagnosis.verdict],
        label=diagnosis.verdict.replace("_", " ").capitalize(),
        meaning=f"{found}{meaning[0].upper()}{meaning[1:]}.",
        reasons=(),
        lines=tuple(
            filter(
                None,
                (
                    _to_do(diagnosis),
                    *_what(diagnosis),
                    _where(diagnosis),
                    _shrinks(diagnosis),
                    _against(diagnosis),
                    UNKNOWN_CURE if diagnosis.verdict == "unknown" else "",
                ),
            )
        ),
    )


def key_figures(diagnosis: Diagnosis) -> tuple[KeyFigure, ...]:
    """Gap, shrink, and what is left of the gap."""
    gap, causes = diagnosis.gap, diagnosis.causes
    runs = run_text(diagnosis)
    cop_std, grf_std = _spreads(diagnosis)
    keys = [
        KeyFigure("CoP off the model", millimetres(gap.cop_mae_mm, cop_std),
                  f"within tolerance: {millimetres(gap.cop_floor_mm)}; {runs}"),
        KeyFigure("GRF off the weight", newtons(gap.grf_mae_n, grf_std),
                  f"within tolerance: {newtons(gap.grf_floor_n)}; {runs}"),
    ]  # fmt: skip
    keys += [
        KeyFigure(hypothesis_text(cause), percent(cause.probability), "probability")
        for cause in causes[:MOST_CAUSES]
    ]
    whole = whole_shrink(diagnosis) if causes else None
    if whole is not None and math.isfinite(whole.fraction):
        keys.append(
            KeyFigure("the gap shrinks by", shrink_text(whole.fraction), interval_text(whole))
        )
    return tuple(keys)


def _spreads(diagnosis: Diagnosis) -> tuple[float, float]:
    """Standard deviations of the absolute errors of CoP [mm] and GRF [N]; NaN if not known."""
    found = diagnosis.evidence
    if found is None:
        return math.nan, math.nan
    rest = found.without.residuals[found.test if diagnosis.test else ~found.test]
    nothing = np.zeros_like(rest)
    return (
        1e3 * cop_mae(rest[:, COP], nothing[:, COP]).std,
        grf_mae(rest[:, GRF], nothing[:, GRF]).std,
    )


def run_text(diagnosis: Diagnosis) -> str:
    """The runs that the figures are of."""
    if not diagnosis.test:
        return "training runs, for want of test runs"
    plural = "s" if len(diagnosis.test) > 1 else ""
    return f"test run{plural} {listed([str(run) for run in diagnosis.test])}"


def _to_do(diagnosis: Diagnosis) -> str:
    """What to do first, and what it is expected to win."""
    if diagnosis.action is None:
        return ""
    before, after = diagnosis.action.expected_cop_mm
    won = f" It is expected to win {millimetres(before - after)} of CoP." if after < before else ""
    return f"What to do: {diagnosis.action.do}.{won}"


def _against(diagnosis: Diagnosis) -> str:
    """What speaks against it."""
    return f"Against it: {'; '.join(diagnosis.dissent)}." if diagnosis.dissent else ""


def _what(diagnosis: Diagnosis) -> list[str]:
    """A line for each cause, and what cannot be distinguished from them."""
    if not diagnosis.causes:
        if diagnosis.verdict == "no_gap":
            gap = diagnosis.gap
            off, floor = (
                f"{millimetres(cop)} and {newtons(grf)}"
                for cop, grf in ((gap.cop_mae_mm, gap.grf_mae_n),
                                 (gap.cop_floor_mm, gap.grf_floor_n))
            )  # fmt: skip
            return [f"CoP and GRF are off by {off}, where a robot within tolerance has {floor}."]
        return ["No effect of the library, at any place, changes the signals as they are off."]
    first, *others = diagnosis.causes
    lines = [_cause_line(first, "Found", "Perhaps")]
    lines += [_cause_line(one, "And", "Perhaps also") for one in others]
    chosen = {(one.effect, one.location) for one in diagnosis.causes}
    rivals: list[str] = []
    replaced: list[str] = []
    for one in diagnosis.ambiguity:
        taken = (one.effect, one.location) in chosen
        (replaced if taken else rivals).append(hypothesis_text(one))
    if rivals:
        place = f"In place of {listed(replaced)}" if replaced else "In place of one of these"
        lines.append(f"{place} it could as well be {listed(rivals, 'or')}.")
    return lines


def _cause_line(cause: Cause, likely: str, unlikely: str) -> str:
    begin = likely if cause.probability >= LIKELY else unlikely
    return f"{begin} ({percent(cause.probability)} probable): {cause_text(cause)}."


def cause_text(cause: Cause) -> str:
    """Where it is, what it does, its name and how big it is."""
    size = sizes_text(cause)
    text = f"{state_text(cause)} ({name_of(cause.effect)})"
    return f"{text}: {size}" if size else text


def _where(diagnosis: Diagnosis) -> str:
    shown = [place for place in diagnosis.where if place.share >= 0.05][:2]
    if not shown:
        return ""
    texts = [f"{where_text(place)} ({percent(place.share)})" for place in shown]
    return f"It shows most in: {'; then '.join(texts)}."


def whole_shrink(diagnosis: Diagnosis) -> Shrink:
    """With all causes together; without an interval where that was not measured.

    The shrink of one of several causes is given on top of the others: it ends where all are in.
    """
    if diagnosis.shrink is not None:
        return diagnosis.shrink
    shrink, gap = diagnosis.causes[0].shrink, diagnosis.gap
    if len(diagnosis.causes) == 1:
        return shrink
    return Shrink(
        fraction=math.nan,
        ci95=(math.nan, math.nan),
        cop_mae_mm=(gap.cop_mae_mm, shrink.cop_mae_mm[1]),
        grf_mae_n=(gap.grf_mae_n, shrink.grf_mae_n[1]),
    )


def _shrinks(diagnosis: Diagnosis) -> str:
    # Effects that somebody asked for stand by themselves: they shrink nothing together.
    if not diagnosis.causes or (len(diagnosis.causes) > 1 and not diagnosis.named):
        return ""
    shrink, gap = whole_shrink(diagnosis), diagnosis.gap
    cop, grf = shrink.cop_mae_mm, shrink.grf_mae_n
    by = (
        f" by {shrink_text(shrink.fraction)} ({interval_text(shrink)}): "
        if math.isfinite(shrink.fraction)
        else ": "
    )
    runs = (
        f"On runs never used for a fit ({run_text(diagnosis)})"
        if diagnosis.test
        else "On the very runs that were fitted, for want of test runs,"
    )
    return (
        f"{runs} the gap shrinks{by}"
        f"the CoP's error from {number(cop[0], 2)} to {millimetres(cop[1])}, that of the GRF from "
        f"{force(grf[0])} to {newtons(grf[1])}. "
        f"Noise alone would leave {millimetres(gap.cop_floor_mm)} and {newtons(gap.grf_floor_n)}."
    )


def shrink_text(fraction: float) -> str:
    """A shrink in per cent; it can be below nothing."""
    return f"{number(100.0 * fraction, 0)}{SPACE}%" if math.isfinite(fraction) else "–"


def interval_text(shrink: Shrink) -> str:
    """Its 95 % interval."""
    if not all(map(math.isfinite, shrink.ci95)):
        return ""
    low, high = (number(100.0 * end, 0) for end in shrink.ci95)
    return f"95{SPACE}% interval {low} to {high}{SPACE}%"


def millimetres(value: float, std: float = math.nan) -> str:
    """An error of the CoP, with its standard deviation where that is known."""
    spread = f"{PLUS_MINUS}{number(std, 2)}" if math.isfinite(std) else ""
    return f"{number(value, 2)}{spread}{SPACE}mm"


def newtons(value: float, std: float = math.nan) -> str:
    """An error of the GRF, likewise."""
    decimals = _decimals(value)
    spread = f"{PLUS_MINUS}{number(std, decimals)}" if math.isfinite(std) else ""
    return f"{number(value, decimals)}{spread}{SPACE}N"


def force(value: float) -> str:
    """Its number; errors of heavy cells are small."""
    return number(value, _decimals(value))


def _decimals(value: float) -> int:
    return 2 if abs(value) >= SMALL_N else 3
