"""Six-axis sensors that read in other units than the shoe file says."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from core.screening.recordings import SETTINGS, WEIGHT, Recording, recording
from core.shoe.shoes import made, six_axis
from shoecal_core.arrays import FloatArray
from shoecal_core.screening.six_axis.units import other_units, units_of_walks

KGF = 9.80665


def recorded(seed: int, force: float, moment: float) -> Recording:
    """Readings of so many units for each newton and newton metre, called N and N m."""
    shoe = made([*six_axis(0, [0.0, 0.01, 0.03]), *six_axis(1, [0.0, -0.01, 0.03])])
    whole = recording(seed, shoe=shoe)
    channels = tuple(replace(one, nominal_gain=1.0) for one in shoe.channels)

    def scaled(_: int, readings: FloatArray) -> FloatArray:
        true = readings * whole.parameters.gain
        true[:, shoe.torque] *= moment
        true[:, ~shoe.torque] *= force
        return true

    return replace(whole.with_readings(scaled), shoe=replace(shoe, channels=channels))


@pytest.mark.parametrize("seed", [1, 2, 3])
@pytest.mark.parametrize(
    ("force", "moment", "named"),
    [
        (1.0, 1.0, {}),
        (1.15, 0.85, {}),
        (1.0, 1e3, {"moments": "N mm"}),
        (1.0, 1e2, {"moments": "N cm"}),
        (1e-3, 1.0, {"forces": "kN"}),
        (1.0 / KGF, 1.0, {"forces": "kgf or kg"}),
        (1.0 / KGF, 1.0 / KGF, {"forces": "kgf or kg", "moments": "kgf m"}),
        (1.0 / KGF, 100.0 / KGF, {"forces": "kgf or kg", "moments": "kgf cm"}),
        (1e-3, 1e3, {"forces": "kN", "moments": "N mm"}),
    ],
)
def test_the_unit_is_named(seed: int, force: float, moment: float, named: dict[str, str]) -> None:
    whole = recorded(seed, force, moment)
    found = other_units(whole.shoe, whole.aligned, WEIGHT, SETTINGS)
    assert {one.kind: one.name for one in found} == named
    for one in found:
        scale = moment if one.kind == "moments" else force
        assert one.size == pytest.approx(1.0 / scale, rel=0.01)


def test_where_data_sheets_give_no_gain_no_unit_is_known() -> None:
    whole = recorded(1, 1.0, 1e3)
    channels = tuple(replace(one, nominal_gain=None) for one in whole.shoe.channels)
    shoe = replace(whole.shoe, channels=channels)
    assert not other_units(shoe, whole.aligned, WEIGHT, SETTINGS)


def test_single_cells_are_left_to_the_fit() -> None:
    whole = recording()
    assert not other_units(whole.shoe, whole.aligned, WEIGHT, SETTINGS)


@pytest.mark.parametrize(
    ("force", "moment", "lifted", "named"),
    [
        (1.0, 1.0, 0.03, {}),
        (1.0 / KGF, 1.0, 0.03, {"forces": "kgf or kg"}),
        (1.0, 1e3, 0.03, {"moments": "N mm"}),
        (1.0 / KGF, 1e3, 0.03, {"forces": "kgf or kg", "moments": "N mm"}),
        # A robot that only sways carries part of its weight on each foot all the time.
        (0.25, 1.0, 0.0, {}),
    ],
)
def test_the_unit_of_a_walk_is_named(
    force: float, moment: float, lifted: float, named: dict[str, str]
) -> None:
    whole = recorded(1, force, moment)
    one = whole.aligned[1]
    time, readings = one.time, one.readings.copy()
    alone = np.stack((np.sin(time) > 0.0, np.sin(time) <= 0.0), axis=1)
    for foot in (0, 1):
        # The foot carries all, or hangs: the wrench that it has is scaled.
        own = whole.shoe.of_foot(foot)
        share = np.abs(readings[:, whole.shoe.index(f"{('left', 'right')[foot]}/fz")]) * force
        readings[:, own] *= (alone[:, foot] * WEIGHT / (share / force**2))[:, None]
    translation = one.states.translation.copy()
    translation[:, 2] = lifted * np.where(alone[:, 0], 1.0, -1.0)
    states = replace(one.states, translation=translation)
    walk = replace(one, readings=readings, states=states)
    found = units_of_walks(whole.shoe, {1: walk}, WEIGHT)
    assert {each.kind: each.name for each in found} == named
