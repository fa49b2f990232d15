"""Converters that lack codes, and drivers that hold their values."""

from __future__ import annotations

import numpy as np
import pytest

from core.screening.recordings import SETTINGS, WEIGHT, Recording, read_coarsely, recording
from shoecal_core.arrays import FloatArray
from shoecal_core.screening.cells.codes import dead_bands, missing_codes
from shoecal_core.screening.faults import Fault
from shoecal_core.screening.screen import screen
from shoecal_core.screening.verdict import Finding


def findings(whole: Recording) -> tuple[Finding, ...]:
    return screen(whole.runs, whole.aligned, whole.shoe, WEIGHT, SETTINGS).findings


def without_bit(whole: Recording, channel: int, share: float, value: int) -> Recording:
    """One bit of a channel's converter has always this value.

    Args:
        share: size of the bit over the channel's range.
    """
    values = np.concatenate([one.readings[:, channel] for one in whole.aligned.values()])
    unit = share * float(np.ptp(values)) / 2**12

    def read(_: int, one: FloatArray) -> FloatArray:
        codes = np.rint(one / unit).astype(np.int64)
        return np.asarray((codes | 1 << 12 if value else codes & ~(1 << 12)) * unit)

    return whole.with_channel(channel, read)


def held(whole: Recording, share: float) -> Recording:
    """Values are sent once they have changed by this share of a channel's range."""

    def hold(_: int, values: FloatArray) -> FloatArray:
        sent, least = values.copy(), share * np.ptp(values, axis=0)
        for at in range(1, len(values)):
            sent[at] = np.where(np.abs(values[at] - sent[at - 1]) > least, values[at], sent[at - 1])
        return sent

    return whole.with_readings(hold)


@pytest.mark.parametrize("value", [0, 1])
@pytest.mark.parametrize("share", [0.15, 0.2, 0.3])
def test_a_bit_that_does_not_change(value: int, share: float) -> None:
    whole = without_bit(recording(3), 6, share, value)
    (one,) = missing_codes(whole.runs)
    assert one.channel == 6
    values = np.concatenate([one.readings[:, 6] for one in recording(3).aligned.values()])
    assert one.high - one.low == pytest.approx(share * np.ptp(values), rel=0.02)
    (finding,) = findings(whole)
    assert (finding.verdict, finding.fault) == ("FAIL", Fault.CODES)
    assert finding.reason.startswith(f"{whole.shoe.names[6]} never reads between")


@pytest.mark.parametrize(("share", "verdict"), [(0.08, "FAIL"), (0.025, "WARN")])
def test_a_driver_that_sends_changes_only(share: float, verdict: str) -> None:
    whole = held(recording(4), share)
    assert len(dead_bands(whole.runs)) == len(whole.shoe.names)
    finding = next(one for one in findings(whole) if one.fault is Fault.CODES)
    assert finding.verdict == verdict
    assert finding.reason.startswith("all channels repeat")


@pytest.mark.parametrize("bits", [8, 10, 12])
def test_coarse_converters_and_slow_ones_are_sound(bits: int) -> None:
    whole = recording(5)
    slow = whole.with_readings(lambda _, values: np.repeat(values[::10], 10, axis=0))
    for one in (whole, slow, read_coarsely(whole, bits, 0.0), read_coarsely(whole, bits, 0.01)):
        assert missing_codes(one.runs) == []
        assert dead_bands(one.runs) == []


def test_a_sensor_that_answers_from_a_threshold_on_lacks_no_codes() -> None:
    def answers(_: int, values: FloatArray) -> FloatArray:
        low, high = values.min(), values.max()
        return np.where(values < low + 0.3 * (high - low), low, values)

    assert missing_codes(recording(6).with_channel(0, answers).runs) == []


def test_a_foot_that_is_put_down_lacks_no_codes() -> None:
    def stepping(_: int, values: FloatArray) -> FloatArray:
        down = np.arange(len(values)) % 100 < 50
        return values + 3.0 * down[:, None] * (np.arange(8) < 4)

    assert missing_codes(recording(6).with_readings(stepping).runs) == []


def test_spikes_and_steps_of_load_lack_no_codes() -> None:
    def hit(_: int, values: FloatArray) -> FloatArray:
        values[::200] += 2.0
        values[1500:, 1] += 1.5
        return values

    assert missing_codes(recording(6).with_readings(hit).runs) == []
