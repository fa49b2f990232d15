from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from shoecal_core.recording.join import Piece
from shoecal_core.recording.resample import at_common_instants, sampled_apart

QUANTITIES = ("value", "status", "sequence", "temperature")
MS = 1_000_000


def piece(
    stamps_ms: list[int], column: int, value: list[float], status: list[float] | None = None
) -> Piece:
    def column_of(numbers: list[float]) -> NDArray[np.float64]:
        return np.array(numbers, dtype=np.float64)[:, None]

    count = len(stamps_ms)
    values = {
        "value": column_of(value),
        "status": column_of(status or [0.0] * count),
        "sequence": column_of([float(index) for index in range(count)]),
        "temperature": column_of([20.0] * count),
    }
    return Piece(np.array(stamps_ms) * MS, np.array([column]), values)


def test_boards_of_one_clock_are_left_as_they_are() -> None:
    left, right = piece([0, 10, 20, 30], 0, [1.0] * 4), piece([0, 20], 1, [1.0] * 2)
    assert not sampled_apart([[left], [right]])
    assert not sampled_apart([[left]])
    assert sampled_apart([[left], [piece([1, 11, 20, 31], 1, [1.0] * 4)]])


def test_values_are_interpolated_by_their_times() -> None:
    """Never beyond a source's own time, never over a gap; the worse status counts."""
    fast = piece(
        [0, 10, 13, 30, 40, 400, 410], 0, [0.0, 10.0, 13.0, 30.0, 40.0, 400.0, 410.0],
        [0, 0, 0, 1, 0, 0, 0],
    )  # fmt: skip
    slow = piece([-5, 5, 20, 40, 200, 405], 1, [1.0] * 6)
    left, right = at_common_instants([[fast], [slow]], 2, QUANTITIES)
    np.testing.assert_array_equal(left.stamp_ns, slow.stamp_ns)
    np.testing.assert_array_equal(right.values["value"], slow.values["value"])
    nan = np.nan
    np.testing.assert_allclose(left.values["value"][:, 0], [nan, 5.0, 20.0, 40.0, nan, 405.0])
    np.testing.assert_array_equal(left.values["status"][:, 0], [nan, 0, 1, 0, nan, 0])
    np.testing.assert_array_equal(left.values["sequence"][:, 0], [nan, 0, 2, 4, nan, 5])


def test_slow_converters_have_no_gaps() -> None:
    """Ten samples a second: their own period is no gap."""
    stamps = list(range(0, 2000, 120))
    slow = piece(stamps, 0, [float(stamp) for stamp in stamps])
    other = piece([stamp + 50 for stamp in stamps[:-1]], 1, [0.0] * (len(stamps) - 1))
    found, _ = at_common_instants([[slow], [other]], 2, QUANTITIES)
    np.testing.assert_allclose(found.values["value"][:, 0], [stamp + 50 for stamp in stamps[:-1]])
