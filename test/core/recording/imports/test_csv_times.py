"""Time columns that are wrong are refused with line and cure; sound ones are taken as they are."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from shoecal_core.arrays import FloatArray, IntArray
from shoecal_core.errors import FieldError
from shoecal_core.recording.imports.csv_mapping import UNITS_NS
from shoecal_core.recording.imports.csv_table import CsvColumn, CsvTable, Layout
from shoecal_core.recording.imports.csv_times import no_common_time, timed

COUNTERS = [(16, "ms"), (32, "us"), (32, "ms")]
EPOCH_S = 1_764_380_000


def stamps(folder: Path, times: FloatArray | IntArray, unit: str) -> IntArray:
    """Of a table with these times in its column, in their unit [ns]; no row is left out."""
    path = folder / "table.csv"
    path.write_text("\n".join(["t", *map(str, times.tolist())]) + "\n")
    notes: list[str] = []
    found, kept = timed(CsvTable(path, Layout()), CsvColumn("t", UNITS_NS[unit]), 0, notes)
    assert not notes
    assert len(kept) == len(times)
    return found


def refused(folder: Path, times: FloatArray | IntArray, unit: str) -> str:
    """The one line on these times."""
    with pytest.raises(FieldError) as caught:
        stamps(folder, times, unit)
    assert "\n" not in str(caught.value)
    return str(caught.value)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("times")


@given(
    rate=st.sampled_from([10, 25, 50, 100, 200, 1000, 5000, 10_000]),
    start=st.sampled_from([0.0, 0.3, 5.0, 40.0, 2147.4]),
    gaps=st.lists(st.tuples(st.integers(1, 398), st.floats(0.001, 1e4)), max_size=3),
    unit=st.sampled_from(["s", "ms", "us"]),
)
def test_sound_times_are_taken_as_they_are(
    folder: Path, rate: int, start: float, gaps: list[tuple[int, float]], unit: str
) -> None:
    steps = np.full(399, 1.0 / rate)
    for place, gap in gaps:
        steps[place] += gap
    times = start + np.concatenate([[0.0], np.cumsum(steps)])
    found = stamps(folder, times * 1e9 / UNITS_NS[unit], unit)
    np.testing.assert_allclose(1e-9 * found, times, rtol=1e-9, atol=1e-9)


@given(rate=st.sampled_from([25, 100, 1000]), unit=st.sampled_from(["s", "ms", "us", "ns"]))
def test_rows_in_another_unit_name_the_likely_one(folder: Path, rate: int, unit: str) -> None:
    """Of those in which no robot is sampled so; the others are taken."""
    times = np.arange(1, 300) * 1e9 / rate / UNITS_NS[unit]
    for said in set(UNITS_NS) - {unit}:
        step = 1e-9 * UNITS_NS[said] * times[0]
        if 5e-5 <= step < 1.001:
            continue
        problem = refused(folder, times, said)
        assert "line 2: rows are " in problem
        assert f"no robot is sampled at, and {1.0 / rate:.3g} s in {unit}; correct" in problem


@pytest.mark.parametrize("first", [0, 1])
def test_numbers_of_rows_are_no_times(folder: Path, first: int) -> None:
    problem = refused(folder, np.arange(first, first + 300), "s")
    assert "rises by exactly 1 s from row to row: it numbers the rows, or is in ms" in problem


def test_rows_in_packets_are_not_taken_for_another_unit(folder: Path) -> None:
    """Read one after the other from a buffer, 20 us apart, 20 of them every 0.2 s."""
    times = np.concatenate([200_000 * packet + 20 * np.arange(20) for packet in range(30)])
    assert len(stamps(folder, times, "us")) == 600


@pytest.mark.parametrize("start_s", [0, 5, EPOCH_S])
@pytest.mark.parametrize(
    ("before", "after"),
    [("ms", "us"), ("us", "ms"), ("s", "ms"), ("s", "us"), ("us", "s"), ("ms", "ns")],
)
@pytest.mark.parametrize("said", ["before", "after"])
def test_a_unit_that_changes_is_named_with_its_line(
    folder: Path, before: str, after: str, start_s: int, said: str
) -> None:
    times = start_s + 0.01 * np.arange(1000)
    units = np.where(np.arange(1000) < 300, UNITS_NS[before], UNITS_NS[after])
    problem = refused(folder, times * 1e9 / units, before if said == "before" else after)
    assert f"line 302: from here on time is in {after}, before it in {before} (" in problem


@given(
    counter=st.sampled_from(COUNTERS), row=st.integers(1, 199), tenths=st.sampled_from([0, 3, 9])
)
def test_a_counter_printed_with_a_sign(
    folder: Path, counter: tuple[int, str], row: int, tenths: int
) -> None:
    """100 rows a second; the cure in the message makes it whole."""
    bits, unit = counter
    step = round(1e7 / UNITS_NS[unit])
    ticks = 2 ** (bits - 1) - row * step + tenths * step // 10 + step * np.arange(200)
    printed = (ticks + 2 ** (bits - 1)) % 2**bits - 2 ** (bits - 1)
    first = int(np.argmax(printed < 0))
    problem = refused(folder, printed, unit)
    period = 1e-9 * 2**bits * UNITS_NS[unit]
    assert f"line {first + 2}: time turns negative after" in problem
    assert f"printed with a sign: add {period:.10g} s to its negative times" in problem
    mended = printed + np.where(printed < 0, round(1e9 * period / UNITS_NS[unit]), 0)
    np.testing.assert_array_equal(stamps(folder, mended, unit), ticks * UNITS_NS[unit])


@pytest.mark.parametrize(("bits", "unit"), COUNTERS)
def test_a_counter_that_is_negative_all_along(folder: Path, bits: int, unit: str) -> None:
    """As in the run after the one in which its sign turned."""
    ticks = -(2 ** (bits - 1)) + 100 + round(1e7 / UNITS_NS[unit]) * np.arange(200)
    problem = refused(folder, ticks, unit)
    assert f"with a sign, add {1e-9 * 2**bits * UNITS_NS[unit]:.10g} s to its neg" in problem


@pytest.mark.parametrize("times", [np.arange(-5.0, 5.0, 0.01), np.arange(-5.005, -1.0, 0.01)])
def test_times_around_a_trigger_are_no_counter(folder: Path, times: FloatArray) -> None:
    problem = refused(folder, times, "s")
    assert "line 2: time is negative or after 2038; shift it" in problem
    assert "counter" not in problem


@pytest.mark.parametrize("rows", [40, 500, 1200])
def test_a_board_that_started_again(folder: Path, rows: int) -> None:
    """Whether few rows or many are before that."""
    ticks = np.concatenate([40_000 + 10 * np.arange(rows), 350 + 10 * np.arange(1300)])
    problem = refused(folder, ticks, "ms")
    assert f"line {rows + 2}: time goes back to that of an earlier row" in problem
    assert "a board started again" in problem
    assert "another zero of time" in problem


@pytest.mark.parametrize(("row", "tick", "line"), [(100, 350, 102), (0, 90_000, 2)])
def test_one_row_of_another_time_is_left_out(folder: Path, row: int, tick: int, line: int) -> None:
    path = folder / "one.csv"
    ticks = 40_000 + 10 * np.arange(300)
    ticks[row] = tick
    path.write_text("\n".join(["t", *map(str, ticks)]) + "\n")
    notes: list[str] = []
    found, kept = timed(CsvTable(path, Layout()), CsvColumn("t", 1e6), 0, notes)
    assert len(found) == len(kept) == 299
    assert notes == [
        f"one.csv: 1 of 300 rows left out, their time repeats or goes back (first in line {line})"
    ]


@given(first=st.integers(-3000, 3000), length=st.integers(1, 3000))
def test_files_without_a_time_in_common(first: int, length: int) -> None:
    """Both spans, and what brings both to one start; nothing where spans meet."""
    one = np.arange(1000, dtype=np.int64) * 10**7
    other = (first + np.arange(length, dtype=np.int64)) * 10**7
    problem = no_common_time(("a.csv", one), ("b.csv", other))
    assert bool(problem) == (not set(range(1000)) & set(range(first, first + length)))
    if problem:
        assert "its times are 0.000 to 9.990 s, those of b.csv " in problem
        early = "a.csv" if first > 0 else "b.csv"
        assert f"add {0.01 * abs(first):.10g} s to the times of {early}" in problem
