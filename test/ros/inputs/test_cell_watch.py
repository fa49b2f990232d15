from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from shoecal_msgs.msg import ShoeVoltages

from ros.bodies import nao_shoe
from shoecal_ros.common.codes import Code
from shoecal_ros.common.health import Level
from shoecal_ros.inputs.cell_watch import CellWatch
from shoecal_ros.inputs.joining import Joined

COUNT, CELL = 8, 2
NAME = nao_shoe().names[CELL]
NEW = np.ones(COUNT, dtype=np.bool_)


def stream(rate: float = 100.0, seconds: float = 2.0, noise: float = 1e-3) -> list[Joined]:
    """A robot that sways over its feet, as good converters see it."""
    rng = np.random.default_rng(1)
    times = np.arange(round(rate * seconds)) / rate
    sway = np.sin(2.0 * np.pi * times)[:, None] * np.linspace(-0.5, 0.5, COUNT)
    values = 1.0 + sway + noise * rng.standard_normal((len(times), COUNT))
    return [
        Joined(round(1e9 * (1.0 + time)), row, np.zeros(COUNT, dtype=np.uint8), NEW)
        for time, row in zip(times.tolist(), values, strict=True)
    ]


def spoilt(readings: list[Joined], change: Callable[[int, float], float]) -> list[Joined]:
    """One cell's readings changed from the middle on."""
    half = len(readings) // 2
    for number, one in enumerate(readings[half:]):
        one.readings[CELL] = change(number, float(one.readings[CELL]))
    return readings


def taken(watch: CellWatch, readings: list[Joined]) -> list[Joined]:
    marked = []
    for one in readings:
        marked += watch.take([one])
        watch.learn()
    return marked


def first_told(readings: list[Joined]) -> tuple[float, Code]:
    """How long after the middle the cell was told, and as what; no other cell ever is."""
    watch = CellWatch(nao_shoe())
    begin = readings[len(readings) // 2].stamp_ns
    for one in readings:
        (marked,) = taken(watch, [one])
        found = watch.findings
        assert set(found) <= {NAME}
        assert (marked.status != 0).sum() == len(found)
        if found:
            return (one.stamp_ns - begin) / 1e9, found[NAME]
    return np.inf, Code.OK


@pytest.mark.parametrize(
    ("change", "reported", "within"),
    [
        (lambda _, __: np.nan, Code.CELL_SILENT, 0.0),
        (lambda _, __: np.inf, Code.CELL_SILENT, 0.0),
        (lambda _, __: 5.0, Code.CELL_SATURATED, 0.0),
        (lambda _, __: -5.0, Code.CELL_SATURATED, 0.0),
        (lambda _, __: 1.0, Code.CELL_STUCK, 0.3),
        (lambda number, value: value + 2.0 * (number == 7), Code.CELL_LEAPS, 0.1),
        (lambda number, value: value - 0.5 * (number in {7, 8, 9}), Code.CELL_LEAPS, 0.1),
    ],
)
@pytest.mark.parametrize("rate", [80.0, 100.0, 1000.0])
def test_a_broken_cell_is_told(
    rate: float, change: Callable[[int, float], float], reported: Code, within: float
) -> None:
    took, found = first_told(spoilt(stream(rate), change))
    assert found == reported
    assert took <= within


def test_a_cell_that_becomes_slow_is_told() -> None:
    readings = stream()
    held = [one.readings[CELL] for one in readings]
    took, found = first_told(
        spoilt(readings, lambda number, _: float(held[100 + number // 15 * 15]))
    )
    assert found
    assert took <= 0.4


@pytest.mark.parametrize("rate", [80.0, 100.0, 1000.0])
@pytest.mark.parametrize("frozen", [[0, 1, 2, 3], list(range(COUNT))])
def test_a_board_that_hangs_is_told(rate: float, frozen: list[int]) -> None:
    """One foot's board, or the only one, repeats what it gave last; its counter goes on."""
    watch = CellWatch(nao_shoe())
    readings = resting(rate, 8.0)
    half = len(readings) // 2
    held = readings[half].readings.copy()
    for one in readings[half:]:
        one.readings[frozen] = held[frozen]
    assert not any(one.status.any() for one in taken(watch, readings[:half]))
    marked = taken(watch, readings[half:])
    broken = [one for one in marked if one.status.any()]
    assert (broken[0].stamp_ns - readings[half].stamp_ns) / 1e9 <= 0.4
    assert set(watch.findings) == {nao_shoe().names[index] for index in frozen}
    assert set(watch.findings.values()) == {Code.CELL_STUCK}
    for one in taken(watch, shifted(resting(rate, 3.0), 8.0))[int(0.2 * rate) :]:
        assert not one.status.any(), "told no more once it changes"


def resting(rate: float, seconds: float) -> list[Joined]:
    """A robot that stands still, with a converter's noise."""
    readings = stream(rate, seconds)
    rng = np.random.default_rng(2)
    for one in readings:
        one.readings[:] = 1.0 + 1e-3 * rng.standard_normal(COUNT)
    return readings


def shifted(readings: list[Joined], by_s: float) -> list[Joined]:
    return [replace(one, stamp_ns=one.stamp_ns + round(1e9 * by_s)) for one in readings]


@pytest.mark.parametrize("bits", [8, 10, 12, 14, 24])
@pytest.mark.parametrize("noise", [0.0, 3e-4, 1e-3])
def test_a_robot_that_swayed_may_stand_quite_still(bits: int, noise: float) -> None:
    step = 10.0 / 2**bits
    readings = stream(seconds=20.0, noise=min(noise, 0.4 * step))
    for one in readings[1000:]:
        one.readings[:] = readings[1000].readings
    for one in readings:
        one.readings[:] = np.rint(one.readings / step) * step
    watch = CellWatch(nao_shoe())
    assert not any(one.status.any() for one in taken(watch, readings))


def test_stamps_that_creep_fill_no_memory() -> None:
    watch = CellWatch(nao_shoe())
    for index in range(5000):
        status = np.zeros(COUNT, dtype=np.uint8)
        taken(watch, [Joined(10**9 + index, np.full(COUNT, 1.0 + index % 2), status, NEW)])
        assert len(watch._taken) <= 1000


@pytest.mark.parametrize("bits", [8, 10, 12, 14, 24])
@pytest.mark.parametrize("noise", [0.0, 1e-3, 1e-2])
def test_cells_in_order_are_left_alone_whatever_their_converter(bits: int, noise: float) -> None:
    step = 10.0 / 2**bits
    readings = stream(seconds=20.0, noise=noise)
    for one in readings:
        one.readings[:] = np.rint(one.readings / step) * step
    assert first_told(readings) == (np.inf, Code.OK)


def test_one_coarse_converter_among_good_ones_is_how_it_is() -> None:
    readings = stream(seconds=20.0)
    for one in readings:
        one.readings[CELL] = np.rint(one.readings[CELL] / 0.04) * 0.04
    watch = CellWatch(nao_shoe())
    later = [one for one in taken(watch, readings)[100:] if one.status.any()]
    assert not later


def test_a_foot_that_lands_is_no_leap() -> None:
    readings = stream()
    for one in readings[100:]:
        one.readings[:4] += (0.8, 0.4, 0.3, 0.2)
    assert first_told(readings) == (np.inf, Code.OK)


def test_a_load_that_stays_is_believed_and_a_spike_forgotten() -> None:
    watch = CellWatch(nao_shoe())
    readings = stream()
    for one in readings[100:]:
        one.readings[CELL] += 1.0
    marked = [bool(one.status[CELL]) for one in taken(watch, readings)]
    assert marked[100:103] == [True] * 3
    assert not any(marked[103:])
    assert watch.spikes.sum() == 0
    spiky = spoilt(stream(), lambda number, value: value + 2.0 * (number == 5))
    watch = CellWatch(nao_shoe())
    marked = [bool(one.status[CELL]) for one in taken(watch, spiky)]
    assert marked[105], "the spike itself makes no force"
    assert watch.spikes[CELL] == 1
    assert not any(marked[140:])
    assert watch.condition.level is Level.OK
    assert watch.condition.values == {f"spikes_of_{NAME}": "1"}


def test_what_the_device_says_stays() -> None:
    watch = CellWatch(nao_shoe())
    one = stream(seconds=0.1)[0]
    one.status[CELL] = ShoeVoltages.FAULT
    (marked,) = taken(watch, [one])
    assert marked.status[CELL] == ShoeVoltages.FAULT
    assert watch.condition.level is Level.ERROR
    reported = f"{NAME} is broken, says its device: check cable, clamp and board"
    assert watch.condition.message == reported
    assert watch.condition.code == Code.CELL_FAULT


def beside_slow(readings: list[Joined], slower: int = 4) -> list[Joined]:
    """As if the board of the cell's foot sent every fourth time only."""
    slow = nao_shoe().foot == nao_shoe().foot[CELL]
    reported: list[Joined] = []
    for number, one in enumerate(readings):
        new = ~slow | (number % slower == 0)
        values = np.where(new, one.readings, reported[-1].readings) if reported else one.readings
        reported.append(replace(one, readings=values, new=new))
    return reported


def test_a_slow_boards_spike_is_one_however_long_it_stands_there() -> None:
    spike = 120
    watch = CellWatch(nao_shoe())
    readings = stream()
    readings[spike].readings[CELL] += 2.0
    marked = taken(watch, beside_slow(readings))
    fault = [one.status[CELL] == ShoeVoltages.FAULT for one in marked]
    assert all(fault[spike : spike + 4]), "no force is made of it"
    assert not any(fault[:spike])
    assert watch.spikes[CELL] == 1
    assert not any(np.delete(one.status, CELL).any() for one in marked)


def test_a_board_that_is_slower_than_the_other_is_well() -> None:
    watch = CellWatch(nao_shoe())
    assert not any(one.status.any() for one in taken(watch, beside_slow(stream())))


@pytest.mark.parametrize(("rate", "slower"), [(100.0, 2), (100.0, 4), (1000.0, 10), (1000.0, 40)])
def test_a_cell_that_is_stuck_is_told_beside_a_faster_board(rate: float, slower: int) -> None:
    readings = beside_slow(spoilt(stream(rate, 4.0), lambda _, __: 1.0), slower)
    after_s, code = first_told(readings)
    assert code == Code.CELL_STUCK
    # As long as it takes where both are as slow.
    assert after_s <= 0.3 * max(1.0, 80.0 * slower / rate)


def test_a_board_that_hangs_is_told_beside_a_faster_one() -> None:
    slow = np.flatnonzero(nao_shoe().foot == nao_shoe().foot[CELL])
    readings = stream(200.0, 16.0, noise=0.0)
    rng = np.random.default_rng(2)
    for number, one in enumerate(readings):
        one.readings[:] = 1.0 + 1e-4 * np.round(3.0 * rng.standard_normal(COUNT))
        if number > 2000:
            one.readings[slow] = readings[2000].readings[slow]
    watch = CellWatch(nao_shoe())
    reported = beside_slow(readings, 2)
    assert not any(one.status.any() for one in taken(watch, reported[:2000]))
    last = taken(watch, reported[2000:2120])[-1]
    assert np.flatnonzero(last.status).tolist() == slow.tolist()


def test_a_slow_board_that_was_alone_at_first_is_well_beside_a_fast_one() -> None:
    slow = nao_shoe().foot == nao_shoe().foot[CELL]
    rng = np.random.default_rng(3)
    noise = 1e-3 * np.round(rng.standard_normal((4000, COUNT)))
    readings = [
        Joined(10**9 + number * 10**7, 1.0 + row, np.zeros(COUNT, dtype=np.uint8), NEW)
        for number, row in enumerate(noise)
    ]
    together = beside_slow(readings, 5)
    for one in together:
        one.readings[~slow] += 0.1 * np.sin(one.stamp_ns / 1e8)
    alone = [
        replace(one, readings=np.where(slow, one.readings, np.nan), new=slow)
        for one in together[:1000:5]
    ]
    watch = CellWatch(nao_shoe())
    taken(watch, alone)
    assert not any(one.status[slow].any() for one in taken(watch, together[1000:]))
