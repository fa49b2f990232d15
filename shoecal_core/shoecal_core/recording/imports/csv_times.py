"""Time columns of CSV tables: the stamps of their rows, and what is wrong with them."""

from __future__ import annotations

import math
from itertools import permutations

import numpy as np

from shoecal_core.arrays import BoolArray, FloatArray, IntArray
from shoecal_core.recording import messages
from shoecal_core.recording.imports.csv_mapping import UNITS_NS
from shoecal_core.recording.imports.csv_table import CsvColumn, CsvTable
from shoecal_core.recording.imports.foreign import LATEST_NS, Stamps
from shoecal_core.recording.imports.unpadded import unpadded
from shoecal_core.recording.join import few_digits, in_order

MAX_REPEATED_SHARE = 0.1
"""A time column in which more rows repeat or go back is no time column of rows in order."""
COUNTER_BITS, COUNTER_ROWS = (16, 32), 3.0
"""Of boards' counters of microseconds and milliseconds; and rows that may be missing where one
starts again."""
MOST_LOGS = 5
"""Of one file, after each of which time starts again; where it goes back more often rows are
unsorted."""
RESTART_ROWS = 10
"""That are before a board started again, and after it, at least: fewer are damaged rows."""
SLOWEST_NS, FASTEST_NS = 1e9, 5e4
"""Between rows, usually: sensors of feet are sampled at 10 Hz to 10 kHz, and no robot at more than
20 kHz. So milliseconds that are taken for microseconds are found down to 20 rows a second [ns]."""
FEWEST_NUMBERS = 20
"""Rows that are a second apart to the last digit, from which they count rows."""
USUAL_NS = 1e7
"""Of units that are possible the likely one brings steps nearest to 100 rows a second [ns]."""
EPOCH_NS = 10**18
"""In 2001: a time column that is later counts from 1970 [ns]."""
UNIT_ROWS, LIKE = 50, 1.5
"""Steps around a row that are compared where the unit of time may change there; and the factor to
which both their change and that of the time itself are the one from unit to unit."""
LEAST_STEPS = 5
"""Steps on either side without which they are not compared."""


def timed(
    table: CsvTable, time: CsvColumn, start_ns: int, notes: list[str], count: int | None = None
) -> tuple[Stamps, IntArray]:
    """When the first `count` rows of a table were sampled, without those that repeat a time.

    Args:
        table: of T rows.
        time: its time column, scaled to nanoseconds.
        start_ns: what is added to it [ns].
        notes: to which what is changed or left out is added.
        count: of rows; None: all.

    Returns:
        Stamps (k,) [ns], increasing, and the rows' places (k,) in the table.

    Raises:
        FieldError: for times that cannot be: of a counter that starts again or is printed with a
            sign, in two units, in another unit than the mapping says, before 1970 or after 2038,
            with too few digits, not in order, or of a board that started again.
    """
    nanoseconds = _nanoseconds(table, time, notes)[:count]
    _check_one_unit(table, time, nanoseconds)
    _check_counter(table, time, nanoseconds)
    outside = (nanoseconds + start_ns < 0.0) | (nanoseconds + start_ns >= LATEST_NS)
    inside = nanoseconds[~outside]
    _check_unit(table, time, inside if len(inside) > 1 else nanoseconds)
    _check_range(table, time, nanoseconds, outside, start_ns)
    stamps = np.rint(nanoseconds).astype(np.int64) + start_ns
    forward = in_order(stamps)
    _check_order(table, time, stamps, forward)
    if not forward.all():
        back = np.flatnonzero(~forward)
        notes.append(
            f"{table.path.name}: {len(back)} of {len(stamps)} rows left out, "
            f"their time repeats or goes back (first in line {table.line(int(back[0]))})"
        )
    return stamps[forward], np.flatnonzero(forward)


def no_common_time(one: tuple[str, Stamps], other: tuple[str, Stamps]) -> str:
    """What is wrong with two files of a trial whose times do not meet, and the cure; empty where
    they do.

    Args:
        one, other: name and stamps (k,) [ns], increasing, of each.
    """
    (name, stamps), (other_name, others) = one, other
    if stamps[0] <= others[-1] and others[0] <= stamps[-1]:
        return ""
    spans = [
        f"{own[0] / messages.SECOND_NS:.3f} to {own[-1] / messages.SECOND_NS:.3f} s"
        for own in (stamps, others)
    ]
    apart = int(others[0] - stamps[0]) / messages.SECOND_NS
    early, add = (name, apart) if apart > 0.0 else (other_name, -apart)
    return (
        f"its times are {spans[0]}, those of {other_name} {spans[1]}, none in common, as where "
        "each counts from the start of its own device: record both with stamps of one clock, or, "
        f"if both began together, add {add:.10g} s to the times of {early}"
    )


def _nanoseconds(table: CsvTable, time: CsvColumn, notes: list[str]) -> FloatArray:
    """Numbers (T,) of a time column [ns].

    Where the leading zeros of decimals were not printed they are put in, with a note: not a digit
    is lost, and a recording can rarely be made again.
    """
    numbers, texts = table.read(time), table.texts(time)
    meant = unpadded(texts, table.decimal)
    if meant is None:
        return numbers
    line = table.line(meant.first)
    notes.append(f"{table.path.name}: {meant.describe(texts[meant.first].strip(), line)}")
    return meant.times * time.scale


def _check_one_unit(table: CsvTable, time: CsvColumn, nanoseconds: FloatArray) -> None:
    """Refuse a column whose unit changes from some row on.

    There both time itself and the steps between rows change by the factor from unit to unit.
    """
    for row in _jumps(nanoseconds):
        found = [
            float(np.median(np.abs(np.diff(part))))
            for part in (
                nanoseconds[max(0, row - UNIT_ROWS) : row],
                nanoseconds[row : row + UNIT_ROWS],
            )
            if len(part) > LEAST_STEPS
        ]
        if len(found) < 2 or not all(found):
            continue
        before, after = (step / time.scale for step in found)
        units = [
            (_unlikely(before * UNITS_NS[one]), one, other)
            for one, other in permutations(UNITS_NS, 2)
            if _like(after / before, UNITS_NS[one] / UNITS_NS[other])
            and _like(
                float(nanoseconds[row] / nanoseconds[row - 1]), UNITS_NS[one] / UNITS_NS[other]
            )
        ]
        if units:
            _, one, other = min(units)
            raise table.error(
                time.name,
                row,
                f"from here on time is in {other}, before it in {one} (rows are usually "
                f"{before:.6g} apart before and {after:.6g} after): write all of it in one unit, "
                "and give the mapping that one",
            )


def _jumps(nanoseconds: FloatArray) -> list[int]:
    """Rows whose time [ns] is many times the one before, or as small a part of it."""
    least = min(UNITS_NS["s"] / UNITS_NS["ms"], UNITS_NS["ms"] / UNITS_NS["us"]) / LIKE
    positive = (nanoseconds[1:] > 0.0) & (nanoseconds[:-1] > 0.0)
    size = np.zeros(len(positive))
    size[positive] = np.abs(np.log(nanoseconds[1:][positive] / nanoseconds[:-1][positive]))
    return [int(row) + 1 for row in np.flatnonzero(size >= math.log(least))]


def _like(ratio: float, factor: float) -> bool:
    return ratio > 0.0 and abs(math.log(ratio / factor)) <= math.log(LIKE)


def _unlikely(step_ns: float) -> float:
    """How far a step [ns] is from USUAL_NS, in powers."""
    return abs(math.log(step_ns / USUAL_NS))


def _usual(steps: FloatArray) -> float:
    """Size of most steps [ns]; zero without any."""
    return float(np.median(np.abs(steps))) if len(steps) else 0.0


def _check_counter(table: CsvTable, time: CsvColumn, nanoseconds: FloatArray) -> None:
    """Refuse a board's counter that starts again, or goes on with a sign."""
    steps = np.diff(nanoseconds)
    usual = _usual(steps)
    for row in np.flatnonzero(steps < 0.0).tolist():
        period = _period_of_counter(usual - float(steps[row]), usual)
        if period is None:
            continue
        if nanoseconds[row + 1] < 0.0 <= nanoseconds[row]:
            problem = (
                f"time turns negative after {1e-9 * nanoseconds[row]:.10g} s, as a board's "
                f"counter does that is printed with a sign: add {period:.10g} s to its negative "
                "times, in each file of that board, and print it unsigned"
            )
        else:
            problem = (
                f"time starts again after {period:.10g} s, as a board's counter does that has no "
                f"more bits: add {period:.10g} s from this line on, and export the file again"
            )
        raise table.error(time.name, row + 1, problem)


def _period_of_counter(step: float, usual: float) -> float | None:
    """Of counters of COUNTER_BITS that count us or ms: the one that starts again after a step [s].

    Args:
        step, usual: between two rows, if it did, and between most rows [ns].
    """
    for bits in COUNTER_BITS:
        for tick in (UNITS_NS["us"], UNITS_NS["ms"]):
            if abs(step - 2.0**bits * tick) <= COUNTER_ROWS * usual:
                return 1e-9 * 2.0**bits * tick
    return None


def _check_range(
    table: CsvTable, time: CsvColumn, nanoseconds: FloatArray, outside: BoolArray, start_ns: int
) -> None:
    """Refuse times that no stamp holds: those (T,) `outside`."""
    if not outside.any():
        return
    cure = "shift it, check its unit"
    if start_ns and ((nanoseconds >= EPOCH_NS) & (nanoseconds < LATEST_NS)).all():
        cure = "it counts from 1970 already: leave the trial's 'start' out"
    elif (period := _period_of_sign(nanoseconds / time.scale, time.scale)) is not None:
        cure = (
            f"if it is a board's counter that is printed with a sign, add {period:.10g} s to its "
            "negative times, in each file of that board, and print it unsigned; else shift it, "
            "check its unit"
        )
    place = int(np.flatnonzero(outside)[0])
    raise table.error(time.name, place, f"time is negative or after 2038; {cure}")


def _period_of_sign(ticks: FloatArray, scale: float) -> float | None:
    """Of a counter of us or ms whose values (T,) [ticks] are all in the half that is negative where
    it is printed with a sign: when it starts again [s]. None of any other.
    """
    counts = scale in (UNITS_NS["us"], UNITS_NS["ms"]) and bool((ticks == np.rint(ticks)).all())
    for bits in COUNTER_BITS:
        if counts and -(2.0 ** (bits - 1)) <= ticks.min() and ticks.max() < 0.0:
            return 1e-9 * 2.0**bits * scale
    return None


def _check_unit(table: CsvTable, time: CsvColumn, nanoseconds: FloatArray) -> None:
    """Refuse rows that are further apart, or nearer to each other, than those of any robot.

    Rows that come in packets are near to each other, too, though not on average.
    """
    steps = np.abs(np.diff(nanoseconds))
    if len(steps) > FEWEST_NUMBERS and (steps == UNITS_NS["s"]).all():
        raise table.error(
            time.name,
            0,
            "rises by exactly 1 s from row to row: it numbers the rows, or is in ms, of 1000 rows "
            "a second; name the column that has the times, or correct the unit of this one",
        )
    usual, mean = _usual(steps), float(steps.mean()) if len(steps) else 0.0
    if not (usual > SLOWEST_NS or (0.0 < usual < FASTEST_NS and mean < FASTEST_NS)):
        return
    possible = {
        unit: own
        for unit, factor in UNITS_NS.items()
        if FASTEST_NS <= (own := usual / time.scale * factor) <= SLOWEST_NS
    }
    likely = min(possible, key=lambda unit: _unlikely(possible[unit]), default="")
    other = f", and {1e-9 * possible[likely]:.3g} s in {likely}" if likely else ""
    raise table.error(
        time.name,
        0,
        f"rows are {1e-9 * usual:.3g} s apart, which no robot is sampled at{other}; correct the "
        "unit of the time column, or write this file in the unit of the other trials",
    )


def _check_order(table: CsvTable, time: CsvColumn, stamps: Stamps, forward: BoolArray) -> None:
    """Refuse stamps (T,) [ns] that repeat or go back too often, or start again.

    Args:
        forward: (T,) rows that are kept.
    """
    back = np.flatnonzero(~forward)
    drops = np.flatnonzero(np.diff(stamps) < 0)
    often = len(back) > MAX_REPEATED_SHARE * len(stamps)
    if often and few_digits(stamps):
        raise table.error(
            time.name,
            int(back[0]),
            f"{len(back)} of {len(stamps)} times are those of the row before: they were "
            "written with too few digits; write them to a millisecond or better and export the "
            "file again",
        )
    if (often and 0 < len(drops) <= MOST_LOGS) or _started_again(stamps, drops):
        raise table.error(
            time.name,
            int(drops[0]) + 1,
            "time goes back to that of an earlier row, as where several logs are in one file or a "
            "board started again (the rest then counts from another zero of time, in all files of "
            "that board): cut it there, and make each a trial of its own",
        )
    if often:
        raise table.error(time.name, int(back[0]), "time repeats or goes back; sort the rows")


def _started_again(stamps: Stamps, drops: IntArray) -> bool:
    """Whether stamps (T,) [ns] go back once to before the first, and on from there."""
    if len(drops) != 1 or drops[0] + 1 < RESTART_ROWS:
        return False
    after = stamps[drops[0] + 1 :][:RESTART_ROWS]
    return len(after) == RESTART_ROWS and bool((after < stamps[0]).all())
