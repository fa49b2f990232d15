from __future__ import annotations

import pytest

from reliability.serial_mutated import ROW
from shoecal_ros.serial import protocol


def test_a_share_of_the_row() -> None:
    result = ROW.run(0, ROW.tries // 50, 0, lambda _: None)
    assert result.failed == 0, result.worst


def test_tries_are_drawn_from_seed_and_place_alone() -> None:
    assert ROW.run(500, 100, 3, lambda _: None) == ROW.run(500, 100, 3, lambda _: None)


def test_without_its_checksum_the_decoder_fails(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(protocol, "crc32", lambda _: 0)
    assert ROW.run(0, 500, 0, lambda _: None).failed > 10
