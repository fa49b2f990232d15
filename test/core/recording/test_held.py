"""Readings that a board sends again are none; what stays by itself is."""

from __future__ import annotations

import numpy as np
import pytest

from shoecal_core.recording.readings import held

STAMPS = np.arange(1000) * 10_000_000
RNG = np.random.default_rng(2)
NOISY = RNG.normal(size=(1000, 6)) + np.sin(STAMPS / 1e9)[:, None]


def test_readings_that_move_are_not_held() -> None:
    assert not held(STAMPS, NOISY).any()
    assert not held(STAMPS[:1], NOISY[:1]).any()


@pytest.mark.parametrize(("length", "found"), [(8, False), (10, True), (200, True)])
def test_a_board_that_holds_all_its_channels(length: int, found: bool) -> None:
    values = NOISY.copy()
    values[300 : 301 + length] = values[300]
    again = np.flatnonzero(held(STAMPS, values)).tolist()
    # The reading that is sent again was right once.
    assert again == (list(range(301, 301 + length)) if found else [])


def test_one_channel_that_moves_on_tells_that_the_board_does_not_hold() -> None:
    values = NOISY.copy()
    values[300:500, :5] = values[300, :5]
    assert not held(STAMPS, values).any()


def test_coarse_converters_stay_while_nothing_moves() -> None:
    coarse = np.round(0.3 * NOISY)
    coarse[300:600] = coarse[300]
    assert not held(STAMPS, coarse).any()


def test_a_hold_at_the_end() -> None:
    values = NOISY.copy()
    values[900:] = values[900]
    assert np.flatnonzero(held(STAMPS, values)).tolist() == list(range(901, 1000))
