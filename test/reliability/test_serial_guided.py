from __future__ import annotations

import random
import sys
from pathlib import Path

import pytest

from reliability.coverage_guided import Corpus, Tracer
from reliability.serial_guided import ROW, mutate, read_input, seeds
from shoecal_ros.serial.clock import DeviceClock


def test_a_share_of_the_row() -> None:
    result = ROW.run(0, 1000, 0, lambda _: None)
    assert result.failed == 0, result.worst


@pytest.mark.parametrize("data", seeds())
def test_seeds_reach_more_than_the_decoder(data: bytes) -> None:
    tracer = Tracer([Path(sys.modules[DeviceClock.__module__].__file__ or "")])
    tracer.trace(lambda: read_input(data))
    assert tracer.edges


def test_an_input_that_reaches_something_new_is_kept() -> None:
    corpus = Corpus([b"a"], mutate, random.Random(0))
    assert corpus.draw(0) == b"a"
    corpus.learn(b"b", {("file", 1, 2)})
    corpus.learn(b"c", {("file", 1, 2)})
    assert corpus.inputs == [b"a", b"b"]


def test_what_breaks_behind_the_checksum_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    def narrow(_: object, device_us: list[int], receive_ns: int) -> list[int]:
        if any(time >= 2**40 for time in device_us):
            raise OverflowError
        return [receive_ns] * len(device_us)

    monkeypatch.setattr(DeviceClock, "stamps", narrow)
    result = ROW.run(0, 1000, 0, lambda _: None)
    assert result.failed
    assert "OverflowError() by 01" in result.worst
