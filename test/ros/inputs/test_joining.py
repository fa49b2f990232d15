from __future__ import annotations

from collections.abc import Sequence
from itertools import permutations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ros.clock import Clock
from shoecal_ros.common.codes import Code
from shoecal_ros.common.voltage_frame import VoltageFrame
from shoecal_ros.inputs.arrival_monitor import SILENT_PERIODS
from shoecal_ros.inputs.joining import (
    NO_DATA,
    FrameJoiner,
    Joined,
    JoinSettings,
    TwoSourcesError,
    UnknownCellError,
    UnsteadyCellsError,
)
from shoecal_ros.inputs.voltages import VoltageInput

CELLS = ("left/a", "left/b", "right/a", "right/b")
STEP_NS = 10_000_000
LEFT, RIGHT = (CELLS[:2], "left"), (CELLS[2:], "right")


def frame(
    index: int,
    cells: Sequence[str] = CELLS,
    source: str = "one",
    *,
    sequence: int | None = None,
    shift_ns: int = 0,
    status: int = 0,
) -> VoltageFrame:
    return VoltageFrame(
        stamp_ns=10**9 + index * STEP_NS + shift_ns,
        source=source,
        sequence=index if sequence is None else sequence,
        cells=tuple(cells),
        voltage=np.array([index + 0.1 * CELLS.index(cell) for cell in cells]),
        status=np.full(len(cells), status, dtype=np.uint8),
    )


def joiner(clock: Clock | None = None) -> FrameJoiner:
    return FrameJoiner(CELLS, hold_s=0.025, clock=clock or Clock())


def joined(found: Joined | None) -> Joined:
    assert found is not None
    return found


@given(st.permutations(CELLS))
def test_one_board_gives_every_frame_in_the_shoes_order(cells: list[str]) -> None:
    one = joined(joiner().add(frame(3, cells)))
    np.testing.assert_allclose(one.readings, 3 + 0.1 * np.arange(4))
    assert one.status.tolist() == [0, 0, 0, 0]


def test_two_boards_meet() -> None:
    join = joiner()
    first = joined(join.add(frame(0, CELLS[:2], "left")))
    assert np.isnan(first.readings[2:]).all()
    assert first.status.tolist() == [0, 0, NO_DATA, NO_DATA]
    assert join.add(frame(0, CELLS[2:], "right", shift_ns=3_000_000)) is None
    second = joined(join.add(frame(1, CELLS[:2], "left")))
    np.testing.assert_allclose(second.readings, [1.0, 1.1, 0.2, 0.3])
    assert join.missing == ()


def test_a_board_that_falls_silent_is_not_believed_for_long() -> None:
    join = joiner()
    join.add(frame(0, CELLS[:2], "left"))
    join.add(frame(0, CELLS[2:], "right"))
    for index in (1, 2):
        assert np.isfinite(joined(join.add(frame(index, CELLS[:2], "left"))).readings).all()
    late = joined(join.add(frame(3, CELLS[:2], "left")))
    assert np.isnan(late.readings[2:]).all()
    assert late.status.tolist() == [0, 0, NO_DATA, NO_DATA]


@given(
    period_ms=st.integers(1, 100),
    lag=st.floats(0.0, 0.99),
    slower=st.integers(1, 4),
    jitter=st.lists(st.floats(-0.1, 0.1), min_size=40, max_size=40),
)
def test_two_boards_meet_where_they_are_slow(
    period_ms: int, lag: float, slower: int, jitter: list[float]
) -> None:
    join = joiner()
    period_ns = period_ms * 1_000_000 // slower
    reported = []
    for board, cells, period, begin in (
        ("left", CELLS[:2], period_ns, 0.0),
        ("right", CELLS[2:], slower * period_ns, lag * slower * period_ns),
    ):
        for index in range(40 // (slower if board == "right" else 1)):
            shift = begin + (index + jitter[index]) * period
            reported.append(frame(0, cells, board, sequence=index, shift_ns=round(shift)))
    last = max(one.stamp_ns for one in reported if one.source == "right")
    # Once both periods are known.
    known = 10**9 + (4 + lag) * slower * period_ns
    instants = 0
    for one in sorted(reported, key=lambda one: one.stamp_ns):
        found = join.add(one)
        if known < one.stamp_ns <= last and found is not None:
            assert np.isfinite(found.readings).all()
            instants += 1
    assert instants >= 40 // slower - 6, "as many as the slower board's frames, known by then"


def test_the_other_board_goes_on_alone() -> None:
    join = joiner()
    join.add(frame(0, CELLS[:2], "left"))
    join.add(frame(0, CELLS[2:], "right"))
    found = [join.add(frame(index, CELLS[2:], "right")) for index in range(1, 8)]
    assert joined(found[-1]).status.tolist() == [NO_DATA, NO_DATA, 0, 0]


def test_a_board_with_a_bad_line_holds_nobody_up() -> None:
    """It was heard first: its frames would give the instants."""
    join = joiner()
    instants = []
    for index in range(1000):
        if index % 200 == 0:
            join.add(frame(index, CELLS[:2], "left"))
        one = join.add(frame(index, CELLS[2:], "right", shift_ns=1))
        if one is not None:
            instants.append(one)
            age_ns = one.stamp_ns - (10**9 + index // 200 * 200 * STEP_NS)
            assert age_ns <= 150_000_001 or np.isnan(one.readings[:2]).all(), "it is old"
            assert one.new.tolist() == [index % 200 == 0] * 2 + [True] * 2
    assert len(instants) > 990


@pytest.mark.parametrize(("ahead_s", "most_s"), [(0.5, 0.6), (3600.0, 1.1)])
def test_a_board_whose_clock_was_ahead_holds_nobody_up_when_it_is_gone(
    ahead_s: float, most_s: float
) -> None:
    clock = Clock()
    join = joiner(clock)
    ahead_ns = round(ahead_s * 1e9)
    stamps = []
    for index in range(300):
        clock.now += 0.01
        if index < 50:
            one = join.add(frame(index, *LEFT, shift_ns=ahead_ns))
            assert one is not None
        one = join.add(frame(index, *RIGHT))
        if one is not None and index >= 50:
            stamps.append(one.stamp_ns - 10**9)
            assert np.isnan(one.readings[:2]).all()
            assert np.isfinite(one.readings[2:]).all()
    assert stamps[0] < 50 * STEP_NS + most_s * 1e9
    assert np.diff(stamps).max() == STEP_NS


@pytest.mark.parametrize("behind_s", [0.02, 0.05, 0.1, 0.4, 5.0])
def test_boards_of_two_clocks_are_told_and_no_frame_counts_as_lost(behind_s: float) -> None:
    clock = Clock()
    join = joiner(clock)
    voltages = VoltageInput(join, 0.5, of_foot=[np.arange(2), np.arange(2, 4)])
    reported = []
    stamps = []
    for index in range(500):
        # Now and then the program itself stands still, and finds the late board's frame first.
        pause = index % 80 == 79 and behind_s > 0.03
        clock.now += 0.2 if pause else 0.01
        pair = [frame(index, *LEFT), frame(index, *RIGHT, shift_ns=-round(behind_s * 1e9))]
        instants = voltages.take(pair[::-1] if pause else pair)
        stamps += [one.stamp_ns for one in instants]
        problem = voltages.problem
        reported.append(problem is not None and problem.code == "boards-apart")
    assert not any(reported[:75])
    assert all(reported[130:])
    line = f"right/a, right/b are {behind_s:.2f} s behind those of the other cells"
    assert line in str(voltages.problem)
    assert np.diff(stamps).min() == STEP_NS
    assert voltages.condition.values["lost_frames"] == "0"
    assert [foot.silent for foot in voltages.feet] == [False, True], "nothing is made of that one"


def test_a_board_that_was_late_once_has_no_other_clock_when_it_is_late_again() -> None:
    clock = Clock()
    join = joiner(clock)
    join.add(frame(0, *LEFT))
    join.add(frame(0, *RIGHT, shift_ns=-44_000_000))
    # The program stands still, and finds the other board's frame first: that one leads from now.
    for index in range(10, 400):
        clock.now += 0.01
        for board in (RIGHT, LEFT):
            join.add(frame(index, *board))
    clock.now += 0.1
    join.add(frame(410, *LEFT))
    join.add(frame(410, *RIGHT, sequence=400, shift_ns=-44_000_000))


@pytest.mark.parametrize("rate_hz", [30, 40, 45, 50, 55, 60, 100])
@pytest.mark.parametrize("phase", [0.0, 0.2, 0.4, 0.5, 0.6, 0.8])
def test_boards_meet_though_an_adapter_hands_over_each_16_ms_only(
    rate_hz: int, phase: float
) -> None:
    clock = Clock()
    join = FrameJoiner(CELLS, hold_s=JoinSettings().hold_s, clock=clock)
    voltages = VoltageInput(join, 0.5, of_foot=[np.arange(2), np.arange(2, 4)])
    coming = []
    for index in range(10 * rate_hz):
        for board, after, each_s in ((LEFT, 0.0, 0.001), (RIGHT, phase, 0.016)):
            sent_s = (index + after) / rate_hz * (1.0 + 2e-4 * (board is RIGHT))
            at_s = (np.floor(sent_s / each_s) + 1.0) * each_s
            one = frame(0, *board, sequence=index, shift_ns=round(at_s * 1e9))
            coming.append((at_s, board is RIGHT, one))
    begin = clock.now
    instants: list[Joined] = []
    for at_s, _, one in sorted(coming, key=lambda each: each[:2]):
        clock.now = begin + at_s
        instants += voltages.take([one])
        assert at_s < 1.0 or not any(foot.silent for foot in voltages.feet)
    assert voltages.problem is None
    assert np.isfinite([one.readings for one in instants[rate_hz:]]).all()


@pytest.mark.parametrize("lag", [0.0, 0.2, 0.5, 0.8])
@pytest.mark.parametrize("first", [LEFT, RIGHT])
def test_boards_that_send_in_turns_are_not_silent_where_frames_are_a_period_late(
    first: tuple[tuple[str, ...], str], lag: float
) -> None:
    clock = Clock()
    voltages = VoltageInput(joiner(clock), 0.5, of_foot=[np.arange(2), np.arange(2, 4)])
    rng = np.random.default_rng(1)
    period_ms, begin = 50, clock.now
    second = RIGHT if first is LEFT else LEFT
    coming = []
    for index in range(400):
        for board, after in ((first, 0.0), (second, lag)):
            sent_ms = round((index + after) * period_ms)
            late_ms = period_ms * float(rng.uniform(0.0, 1.0)) if index % 7 == 3 else 0.0
            one = frame(0, *board, sequence=index, shift_ns=sent_ms * 10**6)
            coming.append((sent_ms + late_ms, index, one))
    for at_ms, _, one in sorted(coming, key=lambda each: each[0]):
        clock.now = max(clock.now, begin + at_ms / 1e3)
        assert at_ms < 1000.0 or not any(foot.silent for foot in voltages.feet), at_ms
        voltages.take([one])


def test_a_late_frame_now_and_then_is_of_no_other_clock() -> None:
    clock = Clock()
    join = joiner(clock)
    for index in range(500):
        clock.now += 0.01
        join.add(frame(index, *LEFT))
        if index % 200 == 100:
            join.add(frame(index, *RIGHT, shift_ns=-round(1e6 * index)))


def test_a_board_that_catches_up_has_no_other_clock() -> None:
    clock = Clock()
    join = joiner(clock)
    for index in range(500):
        clock.now += 0.01
        join.add(frame(index, *LEFT))
        if index % 90 == 89:
            # All of nearly a second at once.
            for late in range(index - 89, index + 1):
                join.add(frame(late, *RIGHT))


def test_the_slower_board_does_not_set_the_pace() -> None:
    join = joiner()
    instants = []
    for index in range(100):
        if index % 8 == 0:
            join.add(frame(index, CELLS[:2], "left"))
        if index >= 50:
            instants.append(join.add(frame(index, CELLS[2:], "right", shift_ns=1)))
    assert len([one for one in instants if one is not None]) > 40


def test_one_device_may_send_its_cells_in_turns() -> None:
    join = joiner()
    parts = [CELLS[:2], CELLS[2:]]
    found = [join.add(frame(index, parts[index % 2])) for index in range(10)]
    assert all(one is None for one in found[1::2])
    assert all(np.isfinite(joined(one).readings).all() for one in found[2::2])


def test_two_sources_of_one_cell_are_told_apart() -> None:
    join = joiner()
    join.add(frame(0, CELLS, "one"))
    with pytest.raises(TwoSourcesError, match="'left/b' comes from 'one' and from 'two'"):
        join.add(frame(0, CELLS[1:2], "two"))


def test_a_source_that_has_gone_gives_its_cells_back() -> None:
    clock = Clock()
    join = FrameJoiner(CELLS, hold_s=0.025, clock=clock)
    join.add(frame(0, CELLS[1:2], "stray"))
    with pytest.raises(TwoSourcesError, match="from 'stray' and from 'driver'"):
        join.add(frame(0, CELLS, "driver"))
    clock.now += 1.1
    assert joined(join.add(frame(1, CELLS, "driver"))).readings[1] == pytest.approx(1.1)
    with pytest.raises(TwoSourcesError, match="from 'driver' and from 'stray'"):
        join.add(frame(2, CELLS[1:2], "stray"))


def test_two_drivers_of_one_name_are_found_by_their_counters() -> None:
    join = joiner()

    def listen() -> None:
        for index in range(20):
            join.add(frame(index))
            join.add(frame(index, sequence=5000 - index, shift_ns=1000))

    with pytest.raises(TwoSourcesError, match="two drivers named 'one'"):
        listen()
    # Nothing of either counts as long as both send.
    for index in range(20, 40):
        for sequence in (index, 5000 - index):
            with pytest.raises(TwoSourcesError):
                join.add(frame(index, sequence=sequence))


def test_a_device_that_starts_anew_is_no_second_one() -> None:
    join = joiner()
    for index in range(100):
        join.add(frame(index, sequence=index % 40))


@given(st.integers(2**32 - 50, 2**32 - 1))
def test_a_counter_may_overflow(start: int) -> None:
    join = joiner()
    for index in range(100):
        assert join.add(frame(index, sequence=(start + index) % 2**32)) is not None


def test_a_cell_the_shoe_does_not_have() -> None:
    odd = VoltageFrame(10**9, "one", 0, ("left/z",), np.zeros(1), np.zeros(1, dtype=np.uint8))
    with pytest.raises(UnknownCellError, match=r"left/z.*left/a, left/b"):
        joiner().add(odd)


def test_ever_other_sets_of_cells_fill_no_memory() -> None:
    names = tuple(f"left/{number}" for number in range(6))
    join = FrameJoiner(names, hold_s=0.025)

    def listen() -> None:
        for index, order in enumerate(permutations(names)):
            frame = VoltageFrame(index + 1, "one", index, order, np.zeros(6), np.zeros(6, np.uint8))
            join.add(frame)

    with pytest.raises(UnsteadyCellsError, match="'one' sends ever other sets of cells"):
        listen()


def test_stamps_that_go_back_a_little_are_left_out() -> None:
    join = joiner()
    join.add(frame(5))
    assert join.add(frame(4, sequence=6)) is None
    assert join.left_out == 1, "nothing is left out uncounted"
    assert join.add(frame(6, sequence=7)) is not None
    assert join.left_out == 1


def test_a_frame_of_channels_that_nobody_named_gives_nothing() -> None:
    join = joiner()
    join.add(frame(5))
    assert join.add(frame(6, ())) is None
    assert join.add(frame(7)) is not None


def test_time_may_begin_anew() -> None:
    join = joiner()
    join.add(frame(500))
    again = joined(join.add(frame(1, sequence=501)))
    np.testing.assert_allclose(again.readings, 1 + 0.1 * np.arange(4))


@pytest.mark.parametrize(
    ("away", "there", "silent"), [(RIGHT, LEFT, [False, True]), (LEFT, RIGHT, [True, False])]
)
def test_a_foot_whose_board_falls_silent_is_told_beside_the_other(
    away: tuple[tuple[str, ...], str], there: tuple[tuple[str, ...], str], silent: list[bool]
) -> None:
    clock = Clock()
    voltages = VoltageInput(joiner(clock), 0.5, of_foot=[np.arange(2), np.arange(2, 4)])
    for index in range(20):
        clock.now += 0.01
        voltages.take([frame(index, CELLS[:2], "left"), frame(index, CELLS[2:], "right")])
    assert [foot.silent for foot in voltages.feet] == [False, False]
    for index in range(20, 32):
        clock.now += 0.01
        voltages.take([frame(index, *there)])
    assert [foot.silent for foot in voltages.feet] == silent
    assert not voltages.heard.silent
    for index in (32, 33):
        voltages.take([frame(index, *there), frame(index, *away)])
    assert [foot.silent for foot in voltages.feet] == [False, False]


@pytest.mark.parametrize("period_ms", [5, 20, 33, 50, 100])
@pytest.mark.parametrize(("away", "there", "foot"), [(RIGHT, LEFT, 1), (LEFT, RIGHT, 0)])
def test_a_foot_falls_silent_within_three_periods_of_its_last_frame(
    away: tuple[tuple[str, ...], str], there: tuple[tuple[str, ...], str], foot: int, period_ms: int
) -> None:
    def at(now_ms: int, board: tuple[tuple[str, ...], str]) -> VoltageFrame:
        return frame(0, *board, sequence=now_ms, shift_ns=now_ms * 10**6)

    clock, step = Clock(), 0.001
    voltages = VoltageInput(joiner(clock), 0.5, of_foot=[np.arange(2), np.arange(2, 4)])
    learnt = 20 * period_ms
    for now in range(learnt):
        if now % period_ms == 0:
            voltages.take([at(now, LEFT), at(now, RIGHT)])
        clock.now += step
    gone = now = learnt - period_ms
    now = learnt
    while not voltages.feet[foot].silent:
        if now % period_ms == 0:
            voltages.take([at(now, there)])
        clock.now += step
        now += 1
        assert now - gone <= max(100, 3 * period_ms)
    assert now - gone >= max(80, SILENT_PERIODS * period_ms), "not before"


def code(voltages: VoltageInput) -> str:
    assert voltages.problem is not None
    return voltages.problem.code


def test_what_is_wrong_with_voltages_is_told_in_turn() -> None:
    clock = Clock()
    voltages = VoltageInput(joiner(clock), 0.5)
    assert "start shoe_driver" in str(voltages.problem)
    assert code(voltages) == Code.NO_VOLTAGES
    voltages.take([frame(0, CELLS[:2])])
    assert voltages.problem is None
    clock.now += 10.0
    assert "no voltages for 10 s" in str(voltages.problem)
    assert code(voltages) == Code.VOLTAGES_STALE
    voltages.take([frame(1, CELLS[:2])])
    assert "no device sends the voltage of right/a, right/b" in str(voltages.problem)
    assert code(voltages) == Code.CELL_NOT_SENT
    voltages.take([frame(2, CELLS)])
    assert voltages.problem is None
    voltages.take([frame(3, CELLS, "two")])
    assert "give each cell one source" in str(voltages.problem)
    assert code(voltages) == "two-sources"
    clock.now += 4.0
    voltages.take([frame(4, CELLS)])
    assert voltages.problem is None
