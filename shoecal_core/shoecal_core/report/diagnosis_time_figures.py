"""The figures that show when a gap is there: residuals against time, run by run."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from shoecal_core.diagnosis.result import Diagnosis, Evidence
from shoecal_core.report.diagnosis_looks import AFTER, BEFORE, unit_of
from shoecal_core.report.diagnosis_places import noise_of, signal
from shoecal_core.report.diagnosis_words import signal_text
from shoecal_core.report.figures.run_lines import RunLine, run_lines
from shoecal_core.report.page import Picture

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

ALWAYS = ("grf", "cop_x", "cop_y")
LOUD = 1.3
"""Any other signal is drawn whose RMS is so many times its noise."""
MOST_RUNS = 16
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


def time_pictures(diagnosis: Diagnosis, evidence: Evidence) -> tuple[Picture, ...]:
    """Each signal that shows something, run by run."""
    pictures = (
        _picture(
            diagnosis, evidence, name, signal_text(name), _CAPTIONS.get(name.split("_")[0], "")
        )
        for name in loud_signals(diagnosis, evidence)
    )
    return tuple(picture for picture in pictures if picture is not None)


def test_run_pictures(diagnosis: Diagnosis, evidence: Evidence) -> tuple[Picture, ...]:
    """Force and CoP on test runs alone."""
    caption = "No fit has seen these runs: what is gone here is explained, not fitted away."
    pictures = (
        _picture(diagnosis, evidence, name, f"{signal_text(name)}, test runs", caption,
                 evidence.test)
        for name in ALWAYS
    )  # fmt: skip
    return tuple(picture for picture in pictures if picture is not None)


def _picture(
    diagnosis: Diagnosis,
    evidence: Evidence,
    name: str,
    title: str,
    caption: str,
    only: BoolArray | None = None,
) -> Picture | None:
    factor, unit = unit_of(name)
    rows = _rows(diagnosis, evidence, name, factor, only)
    if not rows:
        return None
    noise = factor * noise_of(evidence, name)
    return Picture(title, run_lines(rows, (BEFORE, AFTER), unit, noise, signal_text(name)), caption)


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


def _rows(
    diagnosis: Diagnosis,
    evidence: Evidence,
    name: str,
    factor: float,
    only: BoolArray | None = None,
) -> list[RunLine]:
    """The runs in which the signal is known; at most so many, the worst ones."""
    before = factor * signal(evidence, evidence.without, name)
    after = (
        np.empty(0)
        if evidence.explained is None
        else factor * signal(evidence, evidence.explained, name)
    )
    rows, worst = [], []
    for run in np.unique(evidence.run):
        own = evidence.run == run
        if only is not None:
            own &= only
        if not np.isfinite(before[own]).any():
            continue
        test = " · test" if evidence.test[own].any() else ""
        time = evidence.time[own]
        rows.append(
            RunLine(f"run {run}{test}", time, before[own], after[own] if len(after) else after,
                    _lifted(time, evidence.loaded[own]), _onsets(diagnosis, int(run), name))
        )  # fmt: skip
        worst.append(float(np.nanmean(before[own] ** 2)))
    chosen = sorted(np.argsort(worst)[::-1][:MOST_RUNS])
    return [rows[index] for index in chosen]


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
