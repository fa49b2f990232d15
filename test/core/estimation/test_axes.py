"""Sideways axes that are reversed or turned are found in walks, and only these."""

from __future__ import annotations

import numpy as np
import pytest

from core.estimation.walks import ANKLES, walk
from shoecal_core.estimation.axes import check_axes, sideways_axes

GAIN = np.ones(10)


@pytest.mark.parametrize(
    ("axes", "words"),
    [
        ([[1.0, 0.0], [0.0, 1.0]], []),
        ([[0.0, 0.0], [0.0, 0.0]], []),
        ([[-1.0, 0.0], [0.0, 1.0]], ["left/fx -1.0", "right/fx -1.0"]),
        ([[-0.6, 0.0], [0.0, -0.8]], ["left/fx -0.6", "left/fy -0.8", "right/fy -0.8"]),
        ([[0.0, -1.0], [1.0, 0.0]], ["left/fx and left/fy each follow the other", "right angle"]),
    ],
    ids=["right", "dead", "x reversed", "both reversed", "turned"],
)
def test_axes_are_judged_by_the_acceleration(axes: list[list[float]], words: list[str]) -> None:
    stances, _, _ = walk(range(1, 5), np.random.default_rng(2), GAIN, axes=np.array(axes))
    reasons = " ".join(finding.reason for finding in check_axes(ANKLES, stances))
    assert bool(reasons) == bool(words)
    for word in words:
        assert word in reasons


def test_two_runs_are_too_few() -> None:
    stances, _, _ = walk((1, 2), np.random.default_rng(2), GAIN, axes=-np.eye(2))
    assert sideways_axes(ANKLES, stances) == []
