"""Rows of the serial line: they hold, and fail where the driver loses or invents something."""

from __future__ import annotations

import pytest

from reliability import (
    serial_counter,
    serial_mutated,
    serial_random,
    serial_replug,
    serial_twice,
)
from reliability.row import Result, Row
from shoecal_ros.serial import continuity, protocol
from shoecal_ros.serial.frame import Event
from shoecal_ros.serial.protocol import BinaryDecoder


def tried(row: Row, first: int, count: int, seed: int = 0) -> Result:
    return row.run(first, count, seed, lambda _: None)


@pytest.mark.parametrize(
    ("row", "count"),
    [
        (serial_counter.ROW, 1000),
        (serial_mutated.ROW, 20_000),
        (serial_random.ROW, 5_000_000),
        (serial_replug.ROW, 10),
        (serial_twice.ROW, 20),
    ],
    ids=lambda value: value.key if isinstance(value, Row) else "",
)
def test_a_share_of_the_row(row: Row, count: int) -> None:
    result = tried(row, 0, count)
    assert (result.tried, result.failed) == (count, 0), result.worst


@pytest.mark.parametrize(("row", "size"), [(serial_mutated.ROW, 100), (serial_random.ROW, 20_000)])
def test_tries_are_drawn_from_seed_and_number_alone(row: Row, size: int) -> None:
    assert tried(row, 5 * size, size, 3) == tried(row, 5 * size, size, 3)


@pytest.mark.parametrize("row", [serial_counter.ROW, serial_replug.ROW])
def test_loss_that_is_not_counted_fails(row: Row, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(continuity, "_lost", lambda _count, _frame: [])
    result = tried(row, 0, 20)
    assert result.failed
    assert "frames were lost, 0 counted" in result.worst


def test_without_its_checksum_the_decoder_fails(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(protocol, "crc32", lambda _: 0)
    assert tried(serial_mutated.ROW, 0, 500).failed > 10


class Deaf(BinaryDecoder):
    """Loses the last frame of each reading."""

    def feed(self, data: bytes) -> list[Event]:
        return super().feed(data)[:-1]


def test_a_decoder_that_loses_good_frames_fails(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(serial_random, "BinaryDecoder", Deaf)
    result = tried(serial_random.ROW, 0, 50_000)
    assert result.failed == 5
    assert "good frame 2 was not read" in result.worst
