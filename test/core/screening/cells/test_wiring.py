"""Cells upside down, and cells at each other's place."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest

from core.screening.recordings import (
    Recording,
    read_coarsely,
    recording,
)
from core.shoe import shoes
from core.shoe.shoes import made, six_axis
from shoecal_core.arrays import FloatArray
from shoecal_core.screening.cells.wiring import WiringFaults, check_wiring, describe_wiring, of_feet
from shoecal_core.screening.faults import Fault

PAIRS = list(combinations(range(8), 2))


def wiring(whole: Recording) -> WiringFaults:
    return check_wiring(whole.statics)


def exchanged(whole: Recording, *pairs: tuple[int, int]) -> Recording:
    order = np.arange(len(whole.shoe.names))
    for one, other in pairs:
        order[[one, other]] = other, one
    return whole.with_readings(lambda _, values: values[:, order])


@pytest.mark.parametrize("shoe", ["nao_shoe", "odd_shoe"])
@pytest.mark.parametrize("seed", [1, 2])
def test_cables_as_they_should_be(seed: int, shoe: str) -> None:
    whole = recording(seed, shoe=shoe)
    assert wiring(whole) == WiringFaults((), ())
    assert wiring(read_coarsely(whole, 10, 0.01)) == WiringFaults((), ())


@pytest.mark.parametrize("channel", range(8))
def test_an_inverted_cell(channel: int) -> None:
    whole = recording(channel).with_channel(channel, lambda _, values: -values)
    assert wiring(whole) == WiringFaults((channel,), ())


@pytest.mark.parametrize("pair", PAIRS[::3])
def test_swapped_cells(pair: tuple[int, int]) -> None:
    """Of one foot or of both, of the same sign or not."""
    assert wiring(exchanged(recording(sum(pair)), pair)) == WiringFaults((), (pair,))


def test_the_feet_at_each_others_place() -> None:
    pairs = tuple((k, k + 4) for k in range(4))
    assert wiring(exchanged(recording(3), *pairs)) == WiringFaults((), pairs)


ORDERS = [
    ((0, 3), (1, 2)),  # left foot from its other end
    ((4, 5), (6, 7)),
    ((0, 3), (1, 2), (4, 7), (5, 6)),  # both
    ((0, 1), (4, 5)),  # one driver lists both feet in one order
]


@pytest.mark.parametrize("pairs", ORDERS, ids=str)
def test_cells_listed_in_another_order(pairs: tuple[tuple[int, int], ...]) -> None:
    found = wiring(exchanged(recording(2), *pairs))
    assert (set(found.swapped), found.inverted, found.fits) == (set(pairs), (), True)


def test_a_sign_that_nobody_knows_is_never_wrong() -> None:
    whole = recording(2, shoe="odd_shoe")
    unknown = np.flatnonzero(whole.shoe.polarity == 0)
    for channel in unknown:
        turned = whole.with_channel(int(channel), lambda _, values: -values)
        assert wiring(turned) == WiringFaults((), ())


def test_one_run_under_another_weight_is_no_matter_of_cables() -> None:
    whole = recording(4)

    def loaded(run: int, values: np.ndarray[tuple[int, int], np.dtype[np.float64]]):  # type: ignore[no-untyped-def]
        return values + (1.25 / whole.parameters.gain if run == 2 else 0.0)

    assert wiring(whole.with_readings(loaded)) == WiringFaults((), ())


def test_six_axis_feet_at_each_others_place() -> None:
    """Of all their channels; not as vertical forces that are upside down."""
    shoe = made([*six_axis(0, [0.0, 0.01, 0.03]), *six_axis(1, [0.0, -0.01, 0.03])])
    pairs = tuple((k, k + 5) for k in range(5))
    assert of_feet(shoe) == list(pairs)
    whole = recording(3, shoe=shoe)
    assert wiring(whole) == WiringFaults((), ())
    assert wiring(exchanged(whole, *pairs)) == WiringFaults((), pairs)


AXES_OF_A_FOOT = [
    ((3, 4),), ((8, 9),), ((3, 4), (8, 9)),
    ((2, 3),), ((7, 9),), ((2, 3), (7, 8)), ((2, 4), (7, 9)),
]  # fmt: skip


@pytest.mark.parametrize("pairs", AXES_OF_A_FOOT, ids=str)
def test_axes_of_a_foot_at_each_others_place(pairs: tuple[tuple[int, int], ...]) -> None:
    shoe = made([*six_axis(0, [0.0, 0.01, 0.03]), *six_axis(1, [0.0, -0.01, 0.03])])
    assert wiring(exchanged(recording(3, shoe=shoe, count=5), *pairs)) == WiringFaults((), pairs)


SHOE = made(
    [
        *six_axis(0, [0.0, 0.01, 0.04], gain=25.0),
        *six_axis(1, [0.0, -0.01, 0.04], gain=25.0),
    ]
)


def pressing(seed: int, size: float = 32.0) -> Recording:
    """Feet that press against each other along both axes of the floor [N]."""
    whole = recording(seed, shoe=SHOE, count=5)

    def pressed(run: int, values: FloatArray) -> FloatArray:
        one = whole.aligned[run]
        phase = 2.0 * np.pi * one.time[:, None] / np.array([7.0, 11.0]) + seed
        force = size * np.sin(phase)
        outputs = np.zeros_like(values)
        for foot, side in ((0, 1.0), (1, -1.0)):
            turn = (
                one.states.rotation[:, :2, :2] if foot else np.tile(np.eye(2), (len(phase), 1, 1))
            )
            fx, fy, _, mx, my = SHOE.of_foot(foot)
            outputs[:, [fx, fy]] = side * (force[:, None] @ turn)[:, 0]
            # A force in the sole's plane has no moment there, whatever the sensor above it shows.
            outputs[:, [mx, my]] = -(outputs[:, [fx, fy]] @ SHOE.columns[[fx, fy], 1:])
        return values + outputs / whole.parameters.gain

    return whole.with_readings(pressed)


@pytest.mark.parametrize("seed", [1, 2, 3])
@pytest.mark.parametrize("axis", ["fx", "fy"])
@pytest.mark.parametrize("foot", ["left", "right"])
def test_of_two_sideways_axes_that_contradict_each_other_neither_is_blamed(
    seed: int, axis: str, foot: str
) -> None:
    turned = SHOE.index(f"{foot}/{axis}")
    pair = (SHOE.index(f"left/{axis}"), SHOE.index(f"right/{axis}"))
    found = wiring(pressing(seed).with_channel(turned, lambda _, values: -values))
    assert found == WiringFaults((), (), (pair,))
    (one,) = describe_wiring(SHOE, found)
    assert one.reason.startswith(
        f"left/{axis} and right/{axis} contradict each other: one of the two is inverted"
    )
    assert "push the standing robot" in one.reason


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_sideways_axes_that_agree_are_not_blamed(seed: int) -> None:
    whole = pressing(seed)
    assert wiring(whole) == WiringFaults((), ())
    for axis in ("fx", "fy"):
        for foot in ("left", "right"):
            turned = SHOE.index(f"{foot}/{axis}")
            whole = whole.with_channel(turned, lambda _, values: -values)
        assert wiring(whole) == WiringFaults((), ())


@pytest.mark.parametrize(
    ("swapped", "inverted", "words"),
    [
        (True, ("mx",), "turned by 90 degrees about z"),
        (False, ("mx", "my"), "turned by 180 degrees about z"),
        (False, ("fz", "my"), "z pointed down, turned about x"),
        (False, ("fz", "mx", "my"), "what the foot presses on the floor"),
    ],
)
def test_a_sensor_turned_as_a_whole_is_one_line(
    swapped: bool, inverted: tuple[str, ...], words: str
) -> None:
    shoe = made([*six_axis(0, [0.0, 0.0, 0.03]), *six_axis(1, [0.0, 0.0, 0.03])])
    at = {axis: shoe.index(f"left/{axis}") for axis in ("fz", "mx", "my")}
    pairs = ((at["mx"], at["my"]),) if swapped else ()
    right = shoe.index("right/mx")
    found = describe_wiring(shoe, WiringFaults((*(at[axis] for axis in inverted), right), pairs))
    whole, single = (finding.reason for finding in found)
    assert words in whole
    assert "left foot's sensor" in whole
    assert "fx" in whole or "fy" in whole
    assert single.startswith("right/mx is inverted")


def test_both_feet_turned_alike_are_one_line() -> None:
    shoe = made([*six_axis(0, [0.0, 0.0, 0.03]), *six_axis(1, [0.0, 0.0, 0.03])])
    moments = tuple(i for i in range(len(shoe.names)) if shoe.torque[i])
    (finding,) = describe_wiring(shoe, WiringFaults(moments, ()))
    assert "left and right foot's sensor" in finding.reason


def test_what_fits_no_cables_is_a_force_from_outside() -> None:
    """A rope takes a part of what one foot carries; two cells seem to be exchanged for it."""

    def roped(_: int, values: FloatArray) -> FloatArray:
        load = values[:, :4].sum(axis=1)
        values[:, :4] *= 1.0 - 0.3 * (load > np.median(load))[:, None]
        return values

    found = wiring(recording(5).with_readings(roped))
    assert not found.fits
    (finding,) = describe_wiring(
        shoes.shoe("nao_shoe"), WiringFaults((1,), ((0, 2),), clear=False, fits=False)
    )
    assert finding.fault is Fault.UNEXPLAINED
    assert "left/front_left and left/rear_left exchanged" in finding.reason


def test_two_cells_exchanged_fit_once_they_are_put_right() -> None:
    assert wiring(exchanged(recording(5), (0, 2))).fits
