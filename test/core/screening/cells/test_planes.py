"""Four cells of a rigid sole, which keep to one plane."""

from __future__ import annotations

import numpy as np
import pytest

from core.screening.recordings import NOISE_N, Recording, recording
from core.screening.test_screen import screened
from shoecal_core.screening.cells.planes import cell_forces, changed_plane, off_plane
from shoecal_core.screening.faults import Fault


def otherwise(whole: Recording, channels: tuple[int, ...], share: float, first: int) -> Recording:
    """Other gains of some channels from a run on."""
    own = np.isin(np.arange(len(whole.shoe.names)), channels)
    return whole.with_readings(lambda run, values: values * (1.0 - share * own * (run >= first)))


@pytest.mark.parametrize("seed", range(5))
def test_cells_of_a_sound_sole_keep_to_their_plane(seed: int) -> None:
    whole = recording(seed, count=4)
    assert changed_plane(whole.statics) is None
    for foot in (0, 1):
        force = np.concatenate(list(cell_forces(whole.statics, foot).values()))
        assert np.sqrt(off_plane(force)[0] / len(force)) < 5.0 * NOISE_N


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("channels", [(4, 6), (5,)], ids=str)
def test_a_board_with_other_gains_from_a_run_on(seed: int, channels: tuple[int, ...]) -> None:
    spoilt = otherwise(recording(seed, count=4), channels, 0.06, 3)
    found = changed_plane(spoilt.statics)
    assert found is not None
    assert (found.foot, found.runs, found.rest) == (1, (3, 4), (1, 2))
    (finding,) = screened(spoilt).findings
    assert (finding.verdict, finding.fault) == ("WARN", Fault.CHANGED_GAINS)
    assert "cells of the right foot answer otherwise in runs 3 and 4" in finding.reason


def test_three_cells_have_no_plane() -> None:
    whole = recording(count=4, shoe="odd_shoe")
    assert any(not cell_forces(whole.statics, foot) for foot in (0, 1))
    assert changed_plane(recording(count=2).statics) is None
