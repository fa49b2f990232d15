from __future__ import annotations

import mmap
import os

import numpy as np
import pytest

from reliability.soak import LOST, ROW, an_hour, resident_mb

HELD = 64_000_000


@pytest.mark.timeout(600)
def test_a_share_of_the_row() -> None:
    result = ROW.run(0, 5, 0, lambda _: None)
    assert result.failed == 0, result.worst
    assert LOST in result.counts


def test_growth_is_told_an_hour() -> None:
    minutes = np.arange(90)
    assert an_hour((50.0 + 2.5 * minutes / 60).tolist()) == pytest.approx(2.5)


def test_memory_of_a_process_is_told_in_mb() -> None:
    before = resident_mb(os.getpid())
    # Of its own mapping: what was freed before could serve for less.
    with mmap.mmap(-1, HELD) as held:
        held.write(b"\1" * HELD)
        assert resident_mb(os.getpid()) - before == pytest.approx(HELD / 1e6, rel=0.15)
