"""Sideways axes of six-axis sensors by forces that cancel."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from core.screening.recordings import WEIGHT, Recording, recording
from core.shoe.shoes import made, six_axis
from shoecal_core.arrays import FloatArray
from shoecal_core.screening.loads.pulled import describe_pulls
from shoecal_core.screening.six_axis.sideways import (
    SidewaysFault,
    describe_sideways,
    sideways_fault,
    sideways_pulls,
)

SHOE = made([*six_axis(0, [0.0, 0.01, 0.03]), *six_axis(1, [0.0, -0.01, 0.03])])


def pressing(newtons: float = 3.0) -> Recording:
    """A robot whose feet push each other sideways by some newtons."""
    left, right = (
        [SHOE.index(f"{foot}/{axis}") for axis in ("fx", "fy")] for foot in ("left", "right")
    )
    whole = recording(2, shoe=SHOE)
    generator = np.random.default_rng(3)

    def pushed(run: int, values: FloatArray) -> FloatArray:
        one = whole.aligned[run]
        push = newtons * np.array([np.sin(0.8 * one.time), np.cos(1.1 * one.time + run)]).T
        values[:, left] = push + 0.5
        values[:, right] = np.einsum("tji,tj->ti", one.states.rotation[:, :2, :2], -push)
        return values + 0.01 * generator.standard_normal(values.shape)

    return whole.with_readings(pushed)


def found(whole: Recording) -> SidewaysFault | None:
    return sideways_fault(SHOE, whole.aligned, WEIGHT)


def changed(whole: Recording, change: Callable[[FloatArray], FloatArray]) -> Recording:
    return whole.with_readings(lambda _, values: change(values))


def test_axes_that_are_right() -> None:
    assert found(pressing()) is None
    assert describe_sideways(None) == []


def test_forces_that_are_those_of_an_accelerated_robot_say_nothing() -> None:
    whole = pressing(0.05)
    sway = 0.2 * np.sin(3.0 * whole.aligned[1].time)
    for number, one in whole.aligned.items():
        com = one.states.com.copy()
        com[..., 0] += sway[: len(com), None]
        whole = whole.with_run(number, states=replace(one.states, com=com))
    turned = changed(whole, lambda values: values * np.where(np.arange(10) == 0, -1.0, 1.0))
    assert found(turned) is None


def test_axes_of_a_robot_that_is_held_for_a_while() -> None:
    """A hand pushes both feet the same way, which one reversed axis would explain."""
    x = [SHOE.index(f"{foot}/fx") for foot in ("left", "right")]

    def held(run: int, values: FloatArray) -> FloatArray:
        values[: len(values) // 4, x] += 30.0
        return values

    assert found(pressing().with_readings(held)) is None


@pytest.mark.parametrize("polarity", [-1, 1])
@pytest.mark.parametrize("gain", [-1.0, 1.0])
def test_the_sign_is_the_polaritys_alone(polarity: int, gain: float) -> None:
    at = SHOE.index("left/fx")
    channels = list(SHOE.channels)
    channels[at] = replace(channels[at], polarity=polarity, nominal_gain=gain)
    turned = np.where(np.arange(len(channels)) == at, polarity, 1)
    whole = changed(pressing(), lambda values: values * turned)
    shoe = replace(SHOE, channels=tuple(channels))
    assert sideways_fault(shoe, whole.aligned, WEIGHT) is None


@pytest.mark.parametrize("foot", ["left", "right"])
@pytest.mark.parametrize("axis", ["fx", "fy"])
def test_a_reversed_axis(foot: str, axis: str) -> None:
    reversed_ = np.where(np.array(SHOE.names) == f"{foot}/{axis}", -1.0, 1.0)
    fault = found(changed(pressing(), lambda values: values * reversed_))
    assert fault is not None
    assert (f"{foot}/{axis} reversed",) in fault.ways
    assert all(len(way) == 1 for way in fault.ways)
    (finding,) = describe_sideways(fault)
    assert finding.verdict == "FAIL"
    assert f"{foot}/{axis} reversed" in finding.reason


@pytest.mark.parametrize("foot", ["left", "right"])
def test_axes_at_each_others_place(foot: str) -> None:
    order = np.arange(len(SHOE.names))
    x, y = SHOE.index(f"{foot}/fx"), SHOE.index(f"{foot}/fy")
    order[[x, y]] = [y, x]
    fault = found(changed(pressing(), lambda values: values[:, order]))
    assert fault is not None
    assert (f"{foot}/fx and fy exchanged",) in fault.ways


@pytest.mark.parametrize("newtons", [4.0, -8.0])
def test_a_hand_that_pushes_the_robot_is_named(newtons: float) -> None:
    whole = pressing()
    assert sideways_pulls(SHOE, whole.aligned, WEIGHT) == []
    x = [SHOE.index(f"{foot}/fx") for foot in ("left", "right")]

    def pushed(run: int, values: FloatArray) -> FloatArray:
        if run == 2:
            time = whole.aligned[run].time
            values[:, x] += 0.5 * newtons * (np.abs(time - 10.0) < 3.0)[:, None]
        return values

    (pull,) = sideways_pulls(SHOE, whole.with_readings(pushed).aligned, WEIGHT)
    assert (pull.run, pull.sideways) == (2, True)
    assert pull.force == pytest.approx(abs(newtons), rel=0.1)
    np.testing.assert_allclose(pull.stretches, [(7.0, 13.0)], atol=0.5)
    (finding,) = describe_pulls([pull])
    assert "N pushed the robot sideways (at " in finding.reason


def test_forces_that_cancel_badly_in_every_run_are_no_hand() -> None:
    """An axis that shows half of its force does that in all runs."""
    weak = changed(pressing(8.0), lambda values: values * np.where(np.arange(10) == 0, 0.5, 1.0))
    assert sideways_pulls(SHOE, weak.aligned, WEIGHT) == []
