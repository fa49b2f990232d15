"""The figures on candidates, and on how far a gap shrinks."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from shoecal_core.diagnosis.result import Diagnosis, Evidence, Fitted
from shoecal_core.report import palette
from shoecal_core.report.diagnosis_answer import whole_shrink
from shoecal_core.report.diagnosis_looks import AFTER, BEFORE, unit_of
from shoecal_core.report.diagnosis_places import cop_residual, noise_of, signal
from shoecal_core.report.diagnosis_words import (
    candidate_text,
    label_text,
    signal_text,
    where_text,
)
from shoecal_core.report.figures.added_variable import Added, added_variables
from shoecal_core.report.figures.shares import Share, share_bars
from shoecal_core.report.figures.shrinks import Gone, Pair, Quantity, before_and_after
from shoecal_core.report.page import Picture

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

MOST_RIVALS = 4
MOST_SHARES = 10
LEAST_PROBABLE = 1e-3
"""Candidates beyond the best few are shown from here on."""
MOST_SIGNALS = 3


def share_picture(diagnosis: Diagnosis) -> Picture | None:
    """Shares of the gap; None where there are none."""
    shares = [
        Share(where_text(place), place.share, palette.BLUE)
        for place in diagnosis.where[:MOST_SHARES]
        if place.share > 0.0
    ]
    if not shares:
        return None
    return Picture(
        "Shares of the gap",
        share_bars(shares, "Shares of the gap"),
        "Of all that is more than noise on the runs judged: which signal holds it, and as near as "
        "it is known, at which foot, cell or joint, in which run, from when on.",
    )


def ranking_picture(diagnosis: Diagnosis) -> Picture | None:
    """Probabilities of the hypotheses; None where none was ranked."""
    if not diagnosis.ranking:
        return None
    chosen = {(one.effect, one.location) for one in diagnosis.causes}
    alike = {(one.effect, one.location) for one in diagnosis.ambiguity}
    shares = []
    for place, one in enumerate(diagnosis.ranking[:MOST_SHARES]):
        if place >= MOST_RIVALS and one.probability < LEAST_PROBABLE:
            break
        key = (one.effect, one.location)
        colour, kind = palette.SLATE, "another candidate"
        if key in chosen:
            colour, kind = palette.TEAL, "chosen"
        elif key in alike:
            colour, kind = palette.WARN, "as good as a chosen one"
        shares.append(Share(candidate_text(one), one.probability, colour, kind))
    caption = (
        "By how well each predicts runs that were left out of its fit, everything else refitted "
        "with it. "
    )
    if diagnosis.causes:
        caption += "Of candidates with a probability of 80 %, about 80 of 100 should be right."
    else:
        caption += "Probable as against each other only: none of them makes the gap small."
    return Picture(
        "How probable each candidate is",
        share_bars(shares, "Probabilities of the candidates"),
        caption,
    )


def candidate_pictures(evidence: Evidence) -> tuple[Picture, ...]:
    """Residual against what each of the best candidates changes in it, by signal."""
    rivals = evidence.rivals[:MOST_RIVALS]
    if not rivals:
        return ()
    rows = evidence.test if evidence.test.any() else np.ones(len(evidence.time), dtype=bool)
    names = sorted(evidence.signals, key=lambda name: -_moved(evidence, rivals, name, rows))
    pictures = []
    for name in names[:MOST_SIGNALS]:
        if not _moved(evidence, rivals, name, rows) > 0.0:
            continue
        factor, unit = unit_of(name)
        title = signal_text(name)
        panels = [_added(evidence, rival, name, rows, factor) for rival in rivals]
        pictures.append(
            Picture(
                title,
                added_variables(
                    [one for one in panels if len(one.change)], (BEFORE, AFTER), unit, title
                ),
                "Right candidate: without it the dots climb like the dashed line, with it they lie "
                "flat. A narrow column: this candidate can change next to nothing here.",
                tall=True,
            )
        )
    return tuple(pictures)


def _moved(evidence: Evidence, rivals: tuple[Fitted, ...], name: str, rows: BoolArray) -> float:
    """How much the best candidate changes a signal, in standard deviations of its noise."""
    change = (signal(evidence, evidence.without, name) - signal(evidence, rivals[0], name))[rows]
    known = change[np.isfinite(change)]
    noise = noise_of(evidence, name)
    if len(known) < 10 or not noise > 0.0:
        return 0.0
    return float(np.sqrt(np.mean(known**2))) / noise


def _added(evidence: Evidence, rival: Fitted, name: str, rows: BoolArray, factor: float) -> Added:
    before = factor * signal(evidence, evidence.without, name)[rows]
    after = factor * signal(evidence, rival, name)[rows]
    known = np.isfinite(before) & np.isfinite(after)
    before, after = before[known], after[known]
    return Added(label_text(rival.label), before - after, before, after)


def shrink_picture(diagnosis: Diagnosis) -> Picture:
    """Errors before and after on test runs, measured and simulated."""
    whole = whole_shrink(diagnosis)
    simulated = next((one.simulated for one in diagnosis.causes if one.simulated is not None), None)
    gone = [Gone("measured", whole.fraction, whole.ci95)] if np.isfinite(whole.fraction) else []
    cop, grf = [Pair("measured", *whole.cop_mae_mm)], [Pair("measured", *whole.grf_mae_n)]
    volts = []
    if simulated is not None:
        gone.append(Gone("simulated", simulated.fraction, (np.nan, np.nan)))
        cop.append(Pair("simulated", *simulated.cop_mae_mm))
        grf.append(Pair("simulated", *simulated.grf_mae_n))
        volts.append(Pair("simulated", *simulated.voltage_mae))
    gap = diagnosis.gap
    panels = [
        Quantity("CoP error, mean (mm)", tuple(cop), gap.cop_floor_mm),
        Quantity("GRF error, mean (N)", tuple(grf), gap.grf_floor_n),
    ]
    if volts:
        panels.append(Quantity("readings, mean error (unit of the shoe)", tuple(volts), np.nan))
    caption = (
        "Measured: recording against the model, without and with what was found. "
        "The nearer to the dashed line, the less is left to explain."
    )
    if volts:
        caption += (
            " Simulated: the recording against a simulated robot that replays the same commands, "
            "without and with what was found; it differs from the real one in other ways too."
        )
    return Picture(
        "Error before and after",
        before_and_after(gone, panels, (BEFORE, AFTER)),
        caption,
    )


def hidden_rms_mm(evidence: Evidence) -> tuple[float, float]:
    """RMS of what the best explanation adds to the CoP, and of what of it still shows [mm].

    The rest is what gains and offsets can imitate.
    """
    if evidence.explained is None or not {"cop_x", "cop_y"} <= set(evidence.signals):
        return float("nan"), float("nan")
    columns = [evidence.signals.index(name) for name in ("cop_x", "cop_y")]
    added = evidence.explained.contribution[:, columns]
    shown = cop_residual(evidence, evidence.without) - cop_residual(evidence, evidence.explained)
    return _rms_mm(added), _rms_mm(shown)


def _rms_mm(off: FloatArray) -> float:
    """Of lengths (T, 2) [mm]; NaN where none is known."""
    known = off[np.isfinite(off).all(axis=1)]
    return 1e3 * float(np.sqrt(np.mean(np.sum(known**2, axis=1)))) if len(known) else float("nan")
