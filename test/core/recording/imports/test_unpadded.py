"""Times whose decimals lost their leading zeros."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from shoecal_core.arrays import IntArray
from shoecal_core.recording.imports.unpadded import unpadded

DIGITS = st.sampled_from([3, 6, 9])


@st.composite
def clocks(draw: st.DrawFn) -> tuple[IntArray, int]:
    """Times (T,) of three seconds and more, in the unit of so many decimals."""
    digits, rate = draw(DIGITS), draw(st.integers(25, 400))
    generator = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    count = int(rate * draw(st.floats(3.0, 6.0)))
    jitter = draw(st.floats(0.0, 0.4)) * generator.random(count)
    start = draw(st.integers(0, 2 * 10**9)) + generator.random()
    since = np.rint((np.arange(count) + jitter) / rate * 10**digits).astype(np.int64)
    return since + int(start * 10**digits), digits


@given(clocks(), st.sampled_from(".,"))
def test_times_are_read_as_they_were_meant(clock: tuple[IntArray, int], decimal: str) -> None:
    ticks, digits = clock
    parts = [divmod(tick, 10**digits) for tick in ticks.tolist()]
    found = unpadded([f"{second}{decimal}{rest}" for second, rest in parts], decimal)
    assert found is not None
    assert found.digits == digits
    meant = [float(f"{second}.{rest:0{digits}d}") for second, rest in parts]
    assert found.times.tolist() == meant
    assert parts[found.first][1] < 10 ** (digits - 1)


@given(clocks())
def test_times_that_are_padded_or_shortened_stay(clock: tuple[IntArray, int]) -> None:
    """Whatever else is wrong with them: two logs in one file, or rows that changed places."""
    ticks, digits = clock
    texts = [f"{tick // 10**digits}.{tick % 10**digits:0{digits}d}" for tick in ticks.tolist()]
    short = [text.rstrip("0") + "0" * text.endswith(".") for text in texts]
    for written in (texts, short):
        assert unpadded(written, ".") is None
        assert unpadded([*written, *written], ".") is None
        assert unpadded([*written[1::2], *written[::2]], ".") is None
        assert unpadded([*written, ""], ".") is None


@given(st.integers(12, 60), st.integers(3, 6))
def test_rows_counted_in_each_second_are_no_decimals(rate: int, seconds: int) -> None:
    """`3.7` may be the seventh row of that second: unless a hundred make one, it says no time."""
    texts = [f"{second}.{row}" for second in range(seconds) for row in range(rate)]
    assert unpadded(texts, ".") is None


def test_one_row_may_be_at_fault() -> None:
    ticks = [*range(2_990, 5_500, 10)]
    ticks.insert(60, ticks[59])
    texts = [f"{tick // 1000}.{tick % 1000}" for tick in ticks]
    found = unpadded(texts, ".")
    assert found is not None
    assert found.describe("3.10", 4) == (
        "times were printed without the decimals' leading zeros: 3.10 (line 4) is read as 3.010 "
        "(print decimals with `%03d`)"
    )
    assert found.first == 2
