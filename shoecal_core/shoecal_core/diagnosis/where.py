"""Where the gap lies: in which signals, feet, runs and phases."""

from __future__ import annotations

import numpy as np

from shoecal_core.arrays import BoolArray, FloatArray, IntArray
from shoecal_core.diagnosis.result import Where
from shoecal_core.diagnosis.scoring import Scored
from shoecal_core.diagnosis.shrink import judged_runs
from shoecal_core.diagnosis.workspace import Workspace
from shoecal_core.error_sources.signals import AIR, CLOSURE, PARITY, TILT
from shoecal_core.error_sources.steps import closure_steps
from shoecal_core.shoe.shoe import FEET

PLACES: tuple[tuple[str, str | None, slice], ...] = (
    ("grf", None, slice(0, 1)),
    ("cop_x", None, slice(1, 2)),
    ("cop_y", None, slice(2, 3)),
    ("closure", None, CLOSURE),
    ("parity", FEET[0], slice(PARITY.start, PARITY.start + 1)),
    ("parity", FEET[1], slice(PARITY.start + 1, PARITY.stop)),
    ("air", None, AIR),
    ("tilt", None, TILT),
)
LEAST_SHARE = 0.02
"""Of all excess, what a signal holds at least to be listed."""
MOSTLY = 0.6
"""Share of a signal's excess in one run from which it counts as that run's."""


def where(workspace: Workspace, rest: FloatArray, chosen: Scored | None) -> tuple[Where, ...]:
    """Shares of the excess over the noise on the test runs, the largest first.

    What happens at one moment of one run is reported for that run, in whichever set it is: causes
    that were found, and steps of the closure, which need no fit.

    Args:
        rest: (T, s) residuals with nothing added.
        chosen: the explanation.
    """
    signal_model = workspace.signal_model
    rows = workspace.rows_of(judged_runs(workspace))
    over = np.where(signal_model.mask, (rest / workspace.floor) ** 2 - 1.0, 0.0)
    phases = {track.run: track.motion for track in signal_model.samples.tracks}
    sums = [
        (signal, foot, max(float(over[rows][:, part].sum()), 0.0), over[:, part].sum(axis=1))
        for signal, foot, part in PLACES
    ]
    total = sum(size for _, _, size, _ in sums)
    found = _events(chosen, phases)
    listed = {event.run for event in found}
    for step in closure_steps(signal_model):
        if step.run not in listed:
            during = phases[step.run]
            found.append(Where("closure", None, None, None, step.run, during, step.time, 0.0))
    for signal, foot, size, course in sums:
        if total <= 0.0 or size < LEAST_SHARE * total:
            continue
        run = _mostly(course, signal_model.samples.run, rows)
        phase = None if run is None else phases[run]
        found.append(Where(signal, foot, None, None, run, phase, None, size / total))
    return tuple(sorted(found, key=lambda place: -place.share))


def _events(chosen: Scored | None, phases: dict[int, str]) -> list[Where]:
    found = []
    for hypothesis, form in () if chosen is None else chosen.parts:
        shape = form.shape
        if shape.run is not None:
            foot = hypothesis.place[0] if hypothesis.place else None
            found.append(
                Where("closure", foot, None, None, shape.run, phases[shape.run], shape.onset, 0.0)
            )
    return found


def _mostly(course: FloatArray, run: IntArray, rows: BoolArray) -> int | None:
    numbers = np.unique(run[rows])
    sums = np.array([max(float(course[run == number].sum()), 0.0) for number in numbers])
    if len(numbers) < 2 or sums.max() < MOSTLY * sums.sum():
        return None
    return int(numbers[int(np.argmax(sums))])
