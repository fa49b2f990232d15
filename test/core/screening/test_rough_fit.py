"""Gains without a word about signs, in spite of one bad run."""

from __future__ import annotations

import numpy as np
import pytest

from core.screening.recordings import Recording, recording
from shoecal_core.screening.blocks import blocks


def gains(whole: Recording) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    return whole.statics.fit.parameters.gain


def test_blocks_are_medians() -> None:
    whole = recording()
    one = blocks(whole.aligned[1], whole.shoe)
    assert one.period == pytest.approx(0.2)
    np.testing.assert_allclose(one.readings[3], np.median(whole.aligned[1].readings[60:80], axis=0))
    spiky = whole.with_channel(2, lambda _, values: np.where(np.arange(len(values)) % 9, values, 9))
    again = blocks(spiky.aligned[1], whole.shoe)
    assert np.abs(again.readings - one.readings).max() < 0.01


@pytest.mark.parametrize("shoe", ["nao_shoe", "odd_shoe"])
def test_gains_are_found_with_their_signs(shoe: str) -> None:
    whole = recording(count=5, shoe=shoe)
    np.testing.assert_allclose(gains(whole), whole.parameters.gain, rtol=0.1)


def test_the_equations_are_met_by_the_truth() -> None:
    whole = recording(noise=0.0)
    vector = np.concatenate((whole.parameters.gain, whole.parameters.offset))
    for rows in whole.statics.rows.values():
        force, *moments = rows.off(vector)
        # The cells' medians are not all of one instant.
        assert np.abs(force).max() < 0.2
        # The model's error of 1.5 mm, in its standard deviations of 2.5 mm.
        assert np.abs(moments).max() < 1.0


def test_blocks_that_do_not_fit_count_less() -> None:
    whole = recording(count=5)
    late = slice(2000, 2600)

    def held(run: int, readings: np.ndarray[tuple[int, int], np.dtype[np.float64]]):  # type: ignore[no-untyped-def]
        if run == 2:
            readings[late] -= 1.0 / whole.parameters.gain
        return readings

    np.testing.assert_allclose(gains(whole.with_readings(held)), gains(whole), rtol=0.01)
