"""Runs that hold the same readings."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from core.screening.recordings import Recording, read_coarsely, recording
from core.screening.test_screen import screened
from shoecal_core.recording.run import Run
from shoecal_core.screening.faults import Fault
from shoecal_core.screening.twins import find_twins


def cut(run: Run, first: int, end: int) -> Run:
    """A piece of it."""
    held, part = run.readings, slice(first, end)
    arrays = ("time", "value", "status", "sequence", "temperature")
    return replace(run, readings=replace(held, **{key: getattr(held, key)[part] for key in arrays}))


@pytest.mark.parametrize("whole", [recording(), read_coarsely(recording(), 8, 0.0)])
def test_runs_of_their_own(whole: Recording) -> None:
    assert find_twins(whole.runs) == []


def test_a_robot_at_rest_repeats_itself() -> None:
    """Its readings are those of the same posture in every run, to the last digit."""
    still = recording().with_readings(lambda _, values: np.tile(values[0], (len(values), 1)))
    runs = {
        number: replace(run, readings=still.runs[1].readings) for number, run in still.runs.items()
    }
    assert find_twins(runs) == []


@pytest.mark.parametrize(
    ("first", "second", "seconds"),
    [((0, 3000), (0, 3000), 30.0), ((0, 2000), (1500, 3000), 5.0), ((0, 3000), (900, 1500), 6.0)],
)
def test_a_recording_that_is_there_twice(
    first: tuple[int, int], second: tuple[int, int], seconds: float
) -> None:
    runs = recording().runs
    runs = {1: cut(runs[1], *first), 2: runs[2], 3: cut(runs[1], *second)}
    (twins,) = find_twins(runs)
    assert twins.runs == (1, 3)
    assert twins.seconds == pytest.approx(seconds)


def test_they_are_refused() -> None:
    whole = recording()
    both = replace(whole, aligned={**whole.aligned, 4: whole.aligned[2]})
    finding = next(one for one in screened(both).findings if one.fault is Fault.TWINS)
    assert finding.verdict == "FAIL"
    assert finding.reason.startswith("runs 2 and 4 hold the same readings (30.0 s of them)")
