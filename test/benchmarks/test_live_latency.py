from __future__ import annotations

import numpy as np
import pytest

from live import bodies
from live.latency import LONGEST_NS, Turn, latencies_ms, summary
from live.line import Sent
from shoecal_core.errors import ShoecalError

VOLTS_PER_COUNT = 10.0 / 2**24


def test_a_frames_number_is_read_from_its_cop() -> None:
    counts = bodies.numbered_counts(VOLTS_PER_COUNT)
    assert np.abs(counts).max() < 2**23
    cop = bodies.cop_of(counts, VOLTS_PER_COUNT)
    np.testing.assert_array_equal(bodies.numbers_of(cop, cop), np.arange(bodies.NUMBERS))


def test_each_frame_gets_its_own_time() -> None:
    # Numbers begin anew after NUMBERS; the third frame is lost, the fourth comes too late.
    sent = [Sent(bodies.NUMBERS - 1 + index, 10_000_000 * index) for index in range(4)]
    at_ns = np.array([1_000_000, 12_500_000, 31_000_000 + LONGEST_NS])
    numbers = np.array([bodies.NUMBERS - 1, 0, 2])
    found = latencies_ms(sent, at_ns, numbers)
    np.testing.assert_allclose(found, [1.0, 2.5, np.nan, np.nan])


def test_ratios_are_of_the_same_rate() -> None:
    def turn(chain: str, rate: float, *latency_ms: float) -> Turn:
        return Turn(chain, rate, [], np.array(latency_ms))

    turns = [
        turn("shoecal", 100.0, 3.0, np.nan), turn("shoecal", 100.0, 3.0),
        turn("bare", 100.0, 2.0), turn("shoecal", 1000.0, np.nan),
    ]  # fmt: skip
    found = summary(turns, 100.0)
    assert found["ratio, median"] == found["ratio, 99 %"] == 1.5
    assert (found["lost"], found["bare lost"]) == (1.0, 0.0)
    with pytest.raises(ShoecalError, match="nothing was heard of the chain shoecal"):
        summary(turns, 1000.0)
