from __future__ import annotations

import math

import pytest

from shoecal_ros.serial.channel_map import ChannelMap, Converter, DeviceChannel, Encoding
from shoecal_ros.serial.errors import ChannelError
from shoecal_ros.serial.frame import Frame

MICROVOLTS = Converter(1e-6)


def frame(counts: dict[int, float], status: int = 0) -> Frame:
    return Frame(0, 0, tuple(counts), (status,) * len(counts), tuple(counts.values()))


def voltage(converter: Converter, number: float) -> float:
    return ChannelMap([DeviceChannel(0, "a", converter)]).readings(frame({0: number})).voltage[0]


def status(converter: Converter, number: float, sent: int = 0) -> int:
    return (
        ChannelMap([DeviceChannel(0, "a", converter)]).readings(frame({0: number}, sent)).status[0]
    )


def test_cells_come_in_the_order_of_the_frame() -> None:
    cells = ChannelMap([DeviceChannel(0, "a", MICROVOLTS), DeviceChannel(7, "b", Converter(2e-6))])
    readings = cells.readings(frame({7: 1_000_000, 0: -500_000}))
    assert readings.cell == ("b", "a")
    assert readings.voltage == pytest.approx((2.0, -0.5))
    assert readings.status == (0, 0)
    assert cells.unknown == {}


def test_channels_without_a_cell_are_counted_and_named() -> None:
    cells = ChannelMap([DeviceChannel(0, "a", MICROVOLTS)])
    assert cells.readings(frame({3: 1, 0: 2, 9: 3})).cell == ("a",)
    assert not cells.readings(frame({9: 3})).cell
    assert cells.unknown == {3: 1, 9: 2}


def test_cells_without_a_reading_are_named() -> None:
    cells = ChannelMap([DeviceChannel(0, "a", MICROVOLTS), DeviceChannel(1, "b", MICROVOLTS)])
    cells.readings(frame({0: 1}))
    assert cells.unseen == ("b",)
    cells.readings(frame({1: 1}))
    assert not cells.unseen


@pytest.mark.parametrize("count", [-(2**23), -5, 0, 5, 2**23 - 1])
def test_encodings_of_one_count(count: int) -> None:
    assert voltage(Converter(1.0), count) == count
    assert voltage(Converter(1.0, encoding=Encoding.OFFSET_BINARY), count + 2**23) == count
    assert voltage(Converter(1.0, encoding=Encoding.TWOS_COMPLEMENT), count % 2**24) == count


def test_status() -> None:
    assert status(MICROVOLTS, 2**23 - 1) == status(MICROVOLTS, -(2**23)) == 1
    assert status(MICROVOLTS, 2**23 - 2) == 0
    assert status(MICROVOLTS, 5, sent=1) == 1
    assert status(MICROVOLTS, 5, sent=3) == 3
    assert status(MICROVOLTS, 5, sent=77) == 3
    assert status(Converter(1.0, encoding=Encoding.OFFSET_BINARY), 0) == 1
    assert status(MICROVOLTS, 2**23 - 1, sent=2) == 2


@pytest.mark.parametrize(("volts", "bits"), [(0.0, 24), (-1.0, 24), (math.nan, 24), (1.0, 33)])
def test_converter_that_cannot_be(volts: float, bits: int) -> None:
    with pytest.raises(ChannelError):
        Converter(volts, bits)


@pytest.mark.parametrize(("index", "cell"), [(0, "b"), (1, "a")])
def test_two_sources_of_one_cell(index: int, cell: str) -> None:
    with pytest.raises(ChannelError, match="give each its own"):
        ChannelMap([DeviceChannel(0, "a", MICROVOLTS), DeviceChannel(index, cell, MICROVOLTS)])


def test_no_data_is_no_number() -> None:
    cells = ChannelMap([DeviceChannel(0, "a", MICROVOLTS)])
    assert math.isnan(cells.readings(frame({0: 0}, status=2)).voltage[0])
