"""Places of cells in another frame than the sole's."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from core.screening.recordings import SETTINGS, Recording, recording
from shoecal_core.arrays import FloatArray
from shoecal_core.screening.blocks import blocks
from shoecal_core.screening.cells.turned_places import describe_turned_places, turned_places
from shoecal_core.screening.rough_fit import Statics
from shoecal_core.shoe.shoe import cell_column


def placed(whole: Recording, feet: tuple[int, ...], places: FloatArray) -> Statics:
    """The equations by a shoe file with these places (n, 2) of the cells of some feet [m]."""
    channels = tuple(
        replace(one, position=place, column=cell_column(place)) if one.foot in feet else one
        for one, place in zip(whole.shoe.channels, places, strict=True)
    )
    shoe = replace(whole.shoe, channels=channels)
    parts = {run: blocks(one, shoe) for run, one in whole.aligned.items()}
    return Statics.of(shoe, parts, whole.statics.weight, SETTINGS)


@pytest.mark.parametrize("feet", [(0, 1), (0,), (1,)], ids=str)
@pytest.mark.parametrize(
    ("axes", "written"),
    [
        ([[0.0, -1.0], [1.0, 0.0]], "[y, -x]"),  # x to the right, y forward
        ([[0.0, 1.0], [1.0, 0.0]], "[y, x]"),
        ([[0.0, 1.0], [-1.0, 0.0]], "[-y, x]"),
    ],
)
def test_places_of_a_drawing_with_other_axes(
    feet: tuple[int, ...], axes: list[list[float]], written: str
) -> None:
    whole = recording(3)
    found = turned_places(placed(whole, feet, whole.shoe.positions @ np.array(axes).T))
    assert found is not None
    assert (found.feet, found.written) == (feet, written)
    assert found.off > 5.0 * found.left
    (finding,) = describe_turned_places(found)
    assert f"with {written} in place of [x, y]" in finding.reason


@pytest.mark.parametrize("seed", range(3))
def test_places_as_they_are(seed: int) -> None:
    assert turned_places(recording(seed).statics) is None


def test_what_fits_in_no_frame_is_another_fault() -> None:
    """Of a force from outside, say."""
    swing = np.sin(np.arange(3000) / 150.0)

    def pull(_: int, values: FloatArray) -> FloatArray:
        values += 0.3 * values.std(axis=0) * swing[: len(values), None] * np.arange(-3.5, 4.5)
        return values

    assert turned_places(recording(5).with_readings(pull).statics) is None
