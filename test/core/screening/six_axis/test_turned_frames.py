"""Frames of six-axis sensors that are turned by any angle about the vertical."""

from __future__ import annotations

import numpy as np
import pytest

from core.screening.recordings import Recording, recording
from core.shoe.shoes import made, six_axis
from shoecal_core.arrays import FloatArray
from shoecal_core.screening.six_axis.turned_frames import describe_turned_frames, turned_frames

SHOE = made([*six_axis(0, [0.0, 0.01, 0.03]), *six_axis(1, [0.0, -0.01, 0.03])])


def recorded(seed: int, degrees: tuple[float, float]) -> Recording:
    """Readings in frames that are turned by so much."""
    whole = recording(seed, shoe=SHOE)
    gain = whole.parameters.gain

    def turned(_: int, readings: FloatArray) -> FloatArray:
        true = readings * gain
        for foot, angle in zip(("left", "right"), np.radians(degrees), strict=True):
            for axes in ("fx", "fy"), ("mx", "my"):
                x, y = (SHOE.index(f"{foot}/{axis}") for axis in axes)
                along, across = true[:, x].copy(), true[:, y].copy()
                true[:, x] = np.cos(angle) * along + np.sin(angle) * across
                true[:, y] = np.cos(angle) * across - np.sin(angle) * along
        return true / gain

    return whole.with_readings(turned)


def found(whole: Recording) -> FloatArray | None:
    return turned_frames(whole.statics)


@pytest.mark.parametrize("seed", [1, 2])
@pytest.mark.parametrize("degrees", [(10.0, 10.0), (-30.0, -30.0), (25.0, 0.0), (-40.0, 15.0)])
def test_the_angle_is_found(seed: int, degrees: tuple[float, float]) -> None:
    angles = found(recorded(seed, degrees))
    assert angles is not None
    np.testing.assert_allclose(np.degrees(angles), degrees, atol=2.5)
    (finding,) = describe_turned_frames(angles)
    for name, angle in zip(("left", "right"), degrees, strict=True):
        assert (f"{name} by {'+' if angle > 0.0 else '-'}" in finding.reason) == (angle != 0.0)


@pytest.mark.parametrize("degrees", [(0.0, 0.0), (2.0, -2.0), (90.0, 90.0), (180.0, 180.0)])
def test_frames_that_are_mounted_well_or_wrong_by_right_angles(
    degrees: tuple[float, float],
) -> None:
    """Right angles look like cables, and are named as such."""
    angles = found(recorded(1, degrees))
    assert describe_turned_frames(angles) == []


def test_shoes_of_single_cells_have_no_frames() -> None:
    assert found(recording(1)) is None
