from __future__ import annotations

import pytest

from reliability import serial_random
from reliability.serial_random import ROW
from shoecal_ros.serial.frame import Event
from shoecal_ros.serial.protocol import BinaryDecoder


def test_a_share_of_the_row() -> None:
    result = ROW.run(0, ROW.tries // 20, 0, lambda _: None)
    assert result.failed == 0, result.worst


def test_bytes_are_drawn_from_seed_and_place_alone() -> None:
    assert ROW.run(20_000, 20_000, 3, lambda _: None) == ROW.run(20_000, 20_000, 3, lambda _: None)


def test_a_decoder_that_loses_good_frames_fails(monkeypatch: pytest.MonkeyPatch) -> None:
    class Deaf(BinaryDecoder):
        def feed(self, data: bytes) -> list[Event]:
            return super().feed(data)[:-1]

    monkeypatch.setattr(serial_random, "BinaryDecoder", Deaf)
    result = ROW.run(0, 50_000, 0, lambda _: None)
    assert result.failed == 5
    assert "good frame 2 was not read" in result.worst
