"""Channels that follow the others by a law that is known, and some that stop."""

from __future__ import annotations

import numpy as np
import pytest

from core.shoe import shoes
from shoecal_core.arrays import FloatArray
from shoecal_core.screening.cells.following import StuckBlocks, all_stuck, neighbours

BLOCKS = 1200
NOISE = 1e-3
LAW = np.array([0.3, -0.5, 0.8, 0.4, -0.2, 0.1, 0.25])
"""By which the first channel follows all others."""
SHOE = shoes.shoe("nao_shoe")


def session(seed: int = 0) -> FloatArray:
    """(B, 8) channels that go their own slow ways, and a first one that follows them."""
    rng = np.random.default_rng(seed)
    time = 0.2 * np.arange(BLOCKS)[:, None]
    pace = 2.0 * np.pi / rng.uniform(8.0, 30.0, (2, 7))
    others = np.sum(np.sin(pace[:, None] * time + rng.uniform(0.0, 6.0, (2, 1, 7))), axis=0)
    first = 0.7 + others @ LAW + NOISE * rng.standard_normal(BLOCKS)
    return np.column_stack((first, others))


def held(readings: FloatArray, first: int, end: int, share: float = 1.0) -> FloatArray:
    """The first channel keeps a share of its reading from one block to before another."""
    shown = readings.copy()
    shown[first:end, 0] -= share * (readings[first:end, 0] - readings[first, 0])
    return shown


def found(readings: FloatArray) -> list[StuckBlocks]:
    return all_stuck(SHOE, readings, np.full(8, NOISE), range(8))


@pytest.mark.parametrize("seed", range(4))
def test_channels_that_follow_are_not_stuck(seed: int) -> None:
    assert found(session(seed)) == []


@pytest.mark.parametrize("share", [0.7, 0.85, 1.0])
@pytest.mark.parametrize(
    ("first", "end"), [(0, 40), (0, 1100), (240, 1200), (500, 530), (600, 700), (1180, 1200)]
)
def test_a_stretch_is_found_with_its_share_and_its_law(first: int, end: int, share: float) -> None:
    readings = session()
    (stuck,) = found(held(readings, first, end, share))
    assert stuck.channel == 0
    assert stuck.share == pytest.approx(share, abs=0.02)
    still = np.flatnonzero(stuck.still)
    assert still[0] == pytest.approx(first, abs=4)
    assert still[-1] == pytest.approx(end - 1, abs=4)
    np.testing.assert_allclose(stuck.law[2:], LAW, atol=0.02)
    np.testing.assert_allclose(stuck.expected, readings[:, 0], atol=0.05)


def test_a_channel_that_goes_on_by_another_law_is_not_stuck() -> None:
    """A hand or a rope breaks the law of a channel, which does not stop it."""
    readings, part = session(), slice(500, 560)
    rng = np.random.default_rng(5)
    readings[:, 0] += 0.12 * rng.standard_normal(BLOCKS)
    law = readings[part, 1:] @ LAW
    readings[part, 1:] = 1.6 / np.std(law) * (readings[part, 1:] - readings[500, 1:])
    readings[part, 0] = readings[500, 0] + 0.5 * np.sin(np.linspace(0.0, 6.0, 60))
    assert found(readings) == []


def test_an_open_input_rests_at_a_level_of_its_own() -> None:
    """It is far from the law while little motion is missed."""
    rng = np.random.default_rng(5)
    readings, part = session(), slice(500, 530)
    readings[:, 0] += 0.04 * rng.standard_normal(BLOCKS)
    moved = readings[part, 1:] - readings[500, 1:]
    calm = readings[500, 1:] + 0.15 / np.std(moved @ LAW) * moved
    readings[part] = np.column_stack((np.full(30, readings[500, 0] + 1.3), calm))
    assert [one.channel for one in found(readings)] == [0]
    readings[part, 0] = readings[500, 0] + 1.3 + (calm - readings[500, 1:]) @ LAW
    assert 0 not in [one.channel for one in found(readings)]


def test_a_channel_may_stick_again_and_again() -> None:
    readings = session()
    for first in range(100, 1200, 200):
        readings = held(readings, first, first + 120)
    (stuck,) = found(readings)
    assert stuck.channel == 0
    assert np.count_nonzero(np.diff(stuck.still.astype(int)) == 1) == 6
    assert stuck.still.sum() == pytest.approx(720, abs=40)


@pytest.mark.parametrize("share", [0.3, 0.5])
def test_a_smaller_gain_is_not_stuck(share: float) -> None:
    assert found(held(session(), 400, 800, share)) == []


def test_a_foot_that_hangs_is_not_stuck() -> None:
    # The other foot goes on meanwhile, and a law that holds on the floor says that this one does.
    readings = session()
    readings[500:530, :4] = readings[500, :4]
    readings[[500, 529], 1:4] += 1.0
    assert found(readings) == []


def test_where_nothing_moves_nothing_is_stuck() -> None:
    readings = session()
    readings[500:700] = readings[500]
    readings[500:700] += NOISE * np.random.default_rng(1).standard_normal((200, 8))
    assert found(readings) == []


def test_a_law_does_not_reach_beyond_what_it_was_fitted_to() -> None:
    """Others move in a way they never did before: the first need not follow by the same law."""
    readings = NOISE * np.random.default_rng(2).standard_normal((BLOCKS, 8))
    readings[600:, 1:] += session()[600:, 1:]
    assert found(readings) == []


def test_a_short_recording_has_no_law() -> None:
    assert found(session()[:20]) == []


def test_only_like_channels_of_one_foot_are_neighbours() -> None:
    assert neighbours(SHOE, 5).tolist() == [4, 6, 7]


@pytest.mark.parametrize("share", [0.0, 0.2])
def test_a_jolt_that_a_channel_does_not_follow_is_no_stuck_stretch(share: float) -> None:
    """A single motion that is over at once: any share of it fits."""
    readings = session()
    readings[500:520] = readings[500] + NOISE * np.random.default_rng(3).standard_normal((20, 8))
    readings[505:508, 1:] += 2.0
    readings[505:508, 0] += 2.0 * share * LAW.sum()
    assert found(readings) == []
