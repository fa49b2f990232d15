"""Samples that are stamped when their packet is received."""

from __future__ import annotations

import numpy as np
import pytest

from shoecal_core.arrays import FloatArray
from shoecal_core.recording.packets import ANGLES_S, READINGS_S, find_packets

RATE = 100.0


def sampled(seconds: float = 20.0) -> FloatArray:
    return np.arange(round(seconds * RATE)) / RATE


def received(apart: float, within: float = 2e-4, jitter: float = 0.0) -> FloatArray:
    """Stamps of samples that come in packets so far apart [s]."""
    packet = np.floor(sampled() / apart + 1e-6)
    place = np.arange(len(packet)) - np.searchsorted(packet, packet)
    late = jitter * np.random.default_rng(1).uniform(size=int(packet[-1]) + 1)
    return np.asarray((packet + 1.0) * apart + late[packet.astype(int)] + within * place)


@pytest.mark.parametrize("apart", [0.4, 0.8])
@pytest.mark.parametrize("jitter", [0.0, 0.1])
def test_packets_are_found_with_size_and_distance(apart: float, jitter: float) -> None:
    found = find_packets(received(apart, jitter=jitter), READINGS_S)
    assert found is not None
    assert found.size == round(apart * RATE)
    assert found.apart == pytest.approx(apart, abs=0.03)
    assert f"packets of {found.size} every" in found.describe("readings")


@pytest.mark.parametrize("apart", [0.016, 0.04, 0.1, 0.15])
def test_small_packets_do_no_harm(apart: float) -> None:
    assert find_packets(received(apart), READINGS_S) is None


def test_angles_bear_less() -> None:
    assert find_packets(received(0.15), ANGLES_S) is not None


@pytest.mark.parametrize("seed", range(5))
def test_other_stamps_are_no_packets(seed: int) -> None:
    rng = np.random.default_rng(seed)
    time = sampled()
    assert find_packets(time, READINGS_S) is None
    assert find_packets(np.cumsum(rng.exponential(1.0 / RATE, 2000)), READINGS_S) is None
    assert find_packets(np.sort(time + rng.normal(0.0, 0.01, len(time))), READINGS_S) is None
    # A connection that breaks off for a while, at random.
    starts = rng.uniform(0.0, 20.0, 12)
    lost = (np.abs(time[:, None] - starts - 0.5) < 0.5).any(axis=1)
    assert find_packets(time[~lost], READINGS_S) is None


def test_a_sound_rate_with_regular_gaps_is_no_packet() -> None:
    time = sampled()
    assert find_packets(time[time % 1.0 < 0.4], READINGS_S) is None
