"""Cells that do not answer in proportion to their load."""

from __future__ import annotations

import numpy as np
import pytest

from core.screening.recordings import Recording, recording
from core.screening.test_screen import screened
from shoecal_core.arrays import FloatArray
from shoecal_core.screening.cells.bending import Bending, bending
from shoecal_core.screening.faults import Fault


def found(whole: Recording) -> Bending | None:
    return bending(whole.statics)


def compressed(whole: Recording, share: float) -> Recording:
    """All cells answer by so much less at 25 N."""
    law = whole.parameters

    def bend(_: int, values: FloatArray) -> FloatArray:
        force = law.gain * values + law.offset
        return np.asarray((force / (1.0 + share * np.abs(force) / 25.0) - law.offset) / law.gain)

    return whole.with_readings(bend)


@pytest.mark.parametrize(("share", "verdict"), [(0.2, "WARN"), (0.3, "FAIL"), (-0.15, "WARN")])
def test_cells_that_bend_by_nature(share: float, verdict: str) -> None:
    (finding,) = screened(compressed(recording(2), share)).findings
    assert (finding.verdict, finding.fault) == (verdict, Fault.BENT)
    assert finding.reason.startswith("readings do not grow in proportion to the load")


def test_one_cell_that_touches_its_shell() -> None:
    whole = recording(3)
    law = whole.parameters

    def shell(_: int, values: FloatArray) -> FloatArray:
        force = law.gain[5] * values + law.offset[5]
        shared = np.where(force > 6.0, 6.0 + 0.5 * (force - 6.0), force)
        return np.asarray((shared - law.offset[5]) / law.gain[5])

    bent = found(whole.with_channel(5, shell))
    assert bent is not None
    assert bent.channels[0] == 5


@pytest.mark.parametrize("seed", range(6))
def test_sound_cells_are_straight(seed: int) -> None:
    assert found(recording(seed)) is None


def test_another_weight_is_no_bend() -> None:
    """Gains of all runs are off alike, and one run's forces."""
    whole = recording(4, count=4)
    assert found(whole.with_readings(lambda _, values: 1.07 * values)) is None
    heavier = whole.with_readings(lambda run, values: values * (1.1 if run == 2 else 1.0))
    assert found(heavier) is None
