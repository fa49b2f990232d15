"""The figures of a diagnosis against time, and on its hypotheses."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from matplotlib.artist import Artist

from shoecal_core.arrays import BoolArray, FloatArray
from shoecal_core.diagnosis.result import Diagnosis, Evidence
from shoecal_core.report import palette
from shoecal_core.report.diagnosis.places import cop_residual, noise_of, signal
from shoecal_core.report.diagnosis.words import (
    hypothesis_text,
    signal_text,
    where_text,
)
from shoecal_core.report.figures.named_bars import NamedBar, named_bars
from shoecal_core.report.figures.strips import Strip, strips
from shoecal_core.report.page import Picture
from shoecal_core.report.palette import AFTER, BEFORE, ONSET
from shoecal_core.report.quantities import LEAST_PERCENT, UNKNOWN, percent, size
from shoecal_core.report.svg import area_key, line_key

_LENGTH, _ANGLE, _FORCE = (1e3, "mm"), (180.0 / math.pi, "°"), (1.0, "N")
_UNITS = {
    "grf": _FORCE, "cop": _LENGTH, "air_f": _FORCE, "air_m": (1.0, "N m"),
    "closure_roll": _ANGLE, "closure_pitch": _ANGLE, "closure_yaw": _ANGLE,
    "closure": _LENGTH, "parity": _FORCE, "tilt": _ANGLE,
}  # fmt: skip
"""By the beginning of a signal's name, the first that fits: factor and unit for a person."""
MOST_SHARES = 10
ALWAYS = ("grf", "cop_x", "cop_y")
LOUD = 1.3
"""Any other signal is drawn whose RMS is so many times its noise."""
MOST_RUNS = 16
TALL = 32.0
"""Height of one run's row."""
BAND = 2.0
"""Standard deviations of the noise that the band shows to each side."""
MOST_SIGNALS = 9
_CAPTIONS = {
    "grf": "Measured minus the robot's weight. A run that is off as a whole: a drift or another "
    "weight. Off with the motion: cells. Off from an instant on: a step.",
    "cop": "Measured minus modelled, in the sole's frame.",
    "closure": "Joints alone: while both feet stand, the pose of one sole in the other must not "
    "change. No force sensor takes part: what shows here lies in joints or in a foot that moved.",
    "parity": "Under a stiff plate three cells give the fourth: what shows here lies in cells.",
    "tilt": "By the inertial sensor and by joints and model.",
    "air": "A foot in the air must feel nothing but its own weight.",
}


def unit_of(name: str) -> tuple[float, str]:
    """Factor and unit that a signal is shown in."""
    return next((unit for start, unit in _UNITS.items() if name.startswith(start)), (1.0, ""))


def share_picture(diagnosis: Diagnosis) -> Picture | None:
    """Shares of the gap; None where there are none."""
    shares = [
        NamedBar(where_text(place), percent(place.share), place.share, palette.PLAIN)
        for place in diagnosis.where[:MOST_SHARES]
        if place.share > 0.0
    ]
    if not shares:
        return None
    return Picture(
        "Shares of the gap",
        named_bars(shares, "Shares of the gap"),
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
        key = (one.effect, one.location)
        if place > 0 and one.probability < LEAST_PERCENT and key not in chosen | alike:
            continue
        colour, mark, kind = palette.PLAIN, "", "another hypothesis"
        if key in chosen:
            colour, mark, kind = palette.FOUND, "✓ ", "chosen"
        elif key in alike:
            colour, mark, kind = palette.WARN, "= ", "as good as a chosen one"
        name, number = mark + hypothesis_text(one), percent(one.probability)
        shares.append(NamedBar(name, number, one.probability, colour, mark + kind))
    caption = (
        "By how well each predicts runs that were left out of its fit, everything else refitted "
        "with it. "
    )
    if diagnosis.causes:
        caption += "Of hypotheses with a probability of 80 %, about 80 of 100 should be right."
    else:
        caption += "Probable as against each other only: none of them makes the gap small."
    if len(shares) < len(diagnosis.ranking):
        least = f"at most {shares[-1].number}" if len(shares) == MOST_SHARES else "below 1 %"
        caption += f" All others: {least}."
    return Picture(
        "How probable each hypothesis is",
        named_bars(shares, "Probabilities of the hypotheses"),
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


def time_pictures(diagnosis: Diagnosis, evidence: Evidence) -> tuple[Picture, ...]:
    """Each signal that shows something, run by run; those that hold most of the gap first."""
    held = [place.signal for place in diagnosis.where]

    def rank(name: str) -> int:
        return next((at for at, one in enumerate(held) if name.startswith(one)), len(held))

    names = sorted(loud_signals(diagnosis, evidence), key=rank)
    pictures = (_picture(diagnosis, evidence, name) for name in names)
    return tuple(picture for picture in pictures if picture is not None)


def _picture(diagnosis: Diagnosis, evidence: Evidence, name: str) -> Picture | None:
    """The runs in which the signal is known; at most so many, the worst ones."""
    factor, unit = unit_of(name)
    fitted = [one for one in (evidence.without, evidence.explained) if one is not None]
    values = [factor * signal(evidence, one, name) for one in fitted]
    runs = _worst_runs(evidence, values[0])
    if not runs:
        return None
    noise = factor * noise_of(evidence, name)
    edge = _edge(np.concatenate([one[np.isin(evidence.run, runs)] for one in values]), noise)
    rows = []
    for run in runs:
        own = evidence.run == run
        test = " · test" if evidence.test[own].any() else ""
        time, residuals = evidence.time[own], [one[own] for one in values]
        rows.append(
            Strip(f"run {run}{test}", time, tuple(zip((BEFORE, AFTER), residuals, strict=False)),
                  -edge, edge, rms_text(residuals), limits=(0.0,),
                  band=(-BAND * noise, BAND * noise), lifted=_lifted(time, evidence.loaded[own]),
                  onsets=_onsets(diagnosis, run, name))
        )  # fmt: skip
    drawn = strips(
        rows, residual_keys(rows), f"each row: ±{edge:.2g} {unit}", f"RMS ({unit})", TALL
    )
    return Picture(signal_text(name), drawn, _CAPTIONS.get(name.partition("_")[0], ""))


def residual_keys(rows: Sequence[Strip]) -> list[Artist]:
    """Legend of residuals run by run."""
    keys: list[Artist] = [line_key(BEFORE, "nothing added")]
    if any(len(row.lines) > 1 for row in rows):
        keys.append(line_key(AFTER, "with what was found"))
    keys.append(area_key(palette.SOLE, "noise (±2 σ)"))
    if any(row.lifted for row in rows):
        keys.append(area_key(palette.RULE, "one foot lifted"))
    if any(row.onsets for row in rows):
        keys.append(line_key(ONSET, "something begins"))
    return keys


def rms_text(residuals: Sequence[FloatArray]) -> str:
    """RMS of residuals (T,) in the order given."""
    known = [values[np.isfinite(values)] for values in residuals]
    texts = [size(float(np.sqrt(np.mean(one**2))), "1") for one in known if len(one)]
    return " → ".join(texts) or UNKNOWN


def _edge(values: FloatArray, noise: float) -> float:
    """What the rows show to each side: nearly all, and no less than the noise's band."""
    known = np.abs(values[np.isfinite(values)])
    return max(float(np.quantile(known, 0.995)) if len(known) else 0.0, 1.6 * BAND * noise, 1e-12)


def _worst_runs(evidence: Evidence, values: FloatArray) -> list[int]:
    """Numbers of the runs with known residuals (T,), at most MOST_RUNS, in their order."""
    squares = {
        int(run): float(np.nanmean(values[evidence.run == run] ** 2))
        for run in np.unique(evidence.run)
        if np.isfinite(values[evidence.run == run]).any()
    }
    return sorted(sorted(squares, key=lambda run: -squares[run])[:MOST_RUNS])


def loud_signals(diagnosis: Diagnosis, evidence: Evidence) -> list[str]:
    """Force and CoP always, of the others the loudest, where something is in them."""
    named = {place.signal for place in diagnosis.where}
    loud = {name: _loudness(evidence, name) for name in evidence.signals}
    heard = [
        name
        for name in evidence.signals
        if loud[name] > (0.0 if name in {*ALWAYS, *named} else LOUD)
    ]
    heard.sort(key=lambda name: (name not in ALWAYS, -loud[name]))
    return sorted(heard[:MOST_SIGNALS], key=evidence.signals.index)


def _loudness(evidence: Evidence, name: str) -> float:
    """RMS of a signal in standard deviations of its noise; 0 where it was not there."""
    values = signal(evidence, evidence.without, name)
    known = values[np.isfinite(values)]
    return float(np.sqrt(np.mean(known**2))) / noise_of(evidence, name) if len(known) else 0.0


def quiet_signals(diagnosis: Diagnosis, evidence: Evidence) -> list[str]:
    """Signals that were there and showed nothing but noise."""
    return [
        name for name in evidence.signals
        if name not in ALWAYS and 0.0 < _loudness(evidence, name) <= LOUD
        and name not in {place.signal for place in diagnosis.where}
    ]  # fmt: skip


def _lifted(time: FloatArray, loaded: BoolArray) -> tuple[tuple[float, float], ...]:
    edges = np.flatnonzero(np.diff(np.concatenate(([False], ~loaded.all(axis=1), [False]))))
    return tuple(
        (float(time[first]), float(time[min(last, len(time) - 1)]))
        for first, last in zip(edges[::2], edges[1::2], strict=True)
    )


def _onsets(diagnosis: Diagnosis, run: int, name: str) -> tuple[float, ...]:
    """When something begins in a run, by `where` and by causes that have their time."""
    found = [
        place.onset_s
        for place in diagnosis.where
        if place.run == run and place.onset_s is not None and name.startswith(place.signal)
    ]
    found += [
        cause.size["time"].value
        for cause in diagnosis.causes
        if cause.run == run and cause.effect == "slip" and "time" in cause.size
    ]
    return tuple(sorted({round(onset, 1) for onset in found}))
