from __future__ import annotations

import pytest

from shoecal_ros.inputs.lost_frames import LostFrames


@pytest.mark.parametrize(
    ("sequences", "lost"),
    [
        ([5, 6, 7], 0),
        ([5, 9, 10], 3),
        ([2**32 - 2, 1], 2),
        ([1000, 0, 1, 3], 1),
        ([5, 5, 6], 0),
    ],
    ids=["whole", "gap", "overflow", "restart", "repeated"],
)
def test_gaps_are_counted(sequences: list[int], lost: int) -> None:
    frames = LostFrames()
    for sequence in sequences:
        frames.note("left", sequence)
    assert frames.count == lost


def test_each_source_has_its_own_counter() -> None:
    frames = LostFrames()
    for sequence in range(3):
        frames.note("left", sequence)
        frames.note("right", 100 + 2 * sequence)
    assert frames.count == 2
