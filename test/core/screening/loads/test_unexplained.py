"""Vertical forces that vary about the weight for no reason that is looked for."""

from __future__ import annotations

import numpy as np
import pytest

from core.screening.recordings import RATE, Recording, recording
from shoecal_core.arrays import FloatArray
from shoecal_core.screening.faults import Fault
from shoecal_core.screening.loads.unexplained import describe_unexplained, unexplained


def size(whole: Recording) -> float:
    return unexplained(whole.statics)


def tracking(whole: Recording) -> Recording:
    """While a cell carries little, its zero goes where the reading is, by 0.3 N/s."""
    law = whole.parameters

    def tracked(_: int, values: FloatArray) -> FloatArray:
        force = law.gain * values + law.offset
        zero = np.zeros(force.shape[1])
        for at in range(len(force)):
            force[at] -= zero
            step = np.clip(force[at], -0.3 / RATE, 0.3 / RATE)
            zero += np.where(np.abs(force[at]) < 1.5, step, 0.0)
        return np.asarray((force - law.offset) / law.gain)

    return whole.with_readings(tracked)


@pytest.mark.parametrize("seed", range(3))
def test_amplifiers_that_track_their_zeros(seed: int) -> None:
    whole = recording(seed, count=4)
    assert size(whole) == 0.0
    found = size(tracking(whole))
    assert 0.3 < found < 3.0
    (finding,) = describe_unexplained(found)
    assert (finding.verdict, finding.fault) == ("WARN", Fault.UNEXPLAINED)
    assert f"vary by {found:.1f} N (RMS)" in finding.reason
    assert describe_unexplained(0.0) == []
