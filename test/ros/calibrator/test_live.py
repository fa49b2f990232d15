from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ros.bodies import nao_shoe, parameters, readings
from shoecal_core.robot.double_support import DoubleSupport
from shoecal_core.shoe.sensing import Sensing
from shoecal_core.shoe.wrench import at_cop, weight_below
from shoecal_ros.calibrator.live import Live, LiveSensing, OutputFilter, wrench_of
from shoecal_ros.calibrator.load import LoadSwitch
from shoecal_ros.inputs.joining import NO_DATA, Joined

SHOE = nao_shoe()
LAW = parameters(SHOE)
SUPPORT = DoubleSupport(0.02, -0.11, 0.2)
SATURATED = 1


def sensing(cutoff_hz: float = 0.0) -> LiveSensing:
    live = LiveSensing(
        [SHOE.of_foot(foot) for foot in (0, 1)], LoadSwitch(6.0, 3.0), OutputFilter(cutoff_hz)
    )
    live.sensing = Sensing(SHOE, LAW)
    return live


def instant(
    left: tuple[float, float, float],
    right: tuple[float, float, float],
    *,
    stamp_ns: int = 10**9,
    status: dict[str, int] | None = None,
) -> Joined:
    """Readings of a force [N] at a place [m] on each foot."""
    outputs = np.zeros(len(SHOE.names))
    for foot, (force, x, y) in enumerate((left, right)):
        own = SHOE.of_foot(foot)
        wanted = at_cop(np.array(force), np.array([x, y])) - weight_below(SHOE)[foot]
        outputs[own] = np.linalg.lstsq(SHOE.columns[own].T, wanted, rcond=None)[0]
    values = readings(SHOE, LAW, outputs)
    states = np.zeros(len(SHOE.names), dtype=np.uint8)
    for name, state in (status or {}).items():
        states[SHOE.index(name)] = state
        if state == NO_DATA:
            values[SHOE.index(name)] = math.nan
    return Joined(stamp_ns, values, states, np.ones(len(values), dtype=np.bool_))


def one(live: LiveSensing, joined: Joined, support: DoubleSupport | None = SUPPORT) -> Live:
    (found,) = live.take([joined], support)
    return found


@given(st.floats(7.0, 50.0), st.floats(7.0, 50.0), st.floats(-0.03, 0.08))
def test_both_feet_give_one_cop_in_the_left_soles_frame(
    left: float, right: float, x: float
) -> None:
    found = one(sensing(), instant((left, x, 0.01), (right, 0.02, -0.01)))
    assert found.frame == 0
    places = np.array([[x, 0.01], SUPPORT.right_to_left(np.array([0.02, -0.01]))])
    expected = (left * places[0] + right * places[1]) / (left + right)
    assert found.cop is not None
    np.testing.assert_allclose(found.cop, expected, atol=1e-9)
    assert found.wrench is not None
    np.testing.assert_allclose(found.wrench, at_cop(np.array(left + right), expected), atol=1e-9)
    for foot, force in zip(found.feet, (left, right), strict=True):
        assert foot.force == pytest.approx(force)


def test_a_foot_of_which_nothing_new_came_is_not_told_again() -> None:
    live, both = sensing(), instant((20.0, 0.01, 0.0), (30.0, 0.02, 0.0))
    assert one(live, both).reported == (True, True)
    for foot in (0, 1):
        new = np.zeros(len(SHOE.names), dtype=np.bool_)
        new[SHOE.of_foot(foot)[0]] = True
        assert one(live, replace(both, new=new)).reported == (foot == 0, foot == 1)


def test_a_foot_in_the_air_has_no_cop() -> None:
    found = one(sensing(), instant((50.0, 0.01, 0.0), (0.5, 0.0, 0.0)))
    assert found.loaded == (True, False)
    assert found.feet[1].cop is None
    assert found.feet[1].force == pytest.approx(0.5)
    assert wrench_of(found.feet[1]) == pytest.approx((0.5, 0.0, 0.0))
    assert found.cop is not None
    np.testing.assert_allclose(found.cop, [0.01, 0.0], atol=1e-9)


def test_on_the_right_foot_alone_the_frame_is_the_right_soles() -> None:
    found = one(sensing(), instant((0.2, 0.0, 0.0), (50.0, 0.03, -0.01)))
    assert found.frame == 1
    assert found.cop is not None
    np.testing.assert_allclose(found.cop, [0.03, -0.01], atol=1e-9)


def test_a_hanging_robot_has_no_cop_at_all() -> None:
    found = one(sensing(), instant((0.2, 0.0, 0.0), (-0.1, 0.0, 0.0)))
    assert found.cop is None
    assert found.wrench is not None
    assert found.wrench == pytest.approx((0.1, 0.0, 0.0))


@pytest.mark.parametrize("forces", [(20.0, 30.0), (50.0, 1.0), (1.0, 50.0)])
def test_without_joint_angles_feet_go_on_alone(forces: tuple[float, float]) -> None:
    left, right = forces
    found = one(sensing(), instant((left, 0.0, 0.0), (right, 0.0, 0.0)), None)
    assert found.cop is None
    assert found.wrench is None
    assert [foot.cop is not None for foot in found.feet] == list(found.loaded)
    assert any(found.loaded)
    assert [foot.force for foot in found.feet] == pytest.approx(forces)


@pytest.mark.parametrize("state", [NO_DATA, SATURATED])
def test_a_bad_cell_takes_its_foot_and_the_sum_away(state: int) -> None:
    live = sensing()
    one(live, instant((20.0, 0.0, 0.0), (30.0, 0.0, 0.0)))
    found = one(live, instant((20.0, 0.0, 0.0), (30.0, 0.0, 0.0), status={"left/rear_left": state}))
    assert math.isnan(found.feet[0].force)
    assert found.feet[0].cop is None
    assert found.cop is None
    assert found.wrench is None
    assert found.feet[1].cop is not None
    assert found.frame == 0, "the left foot has not left the floor"
    left, right = live.flags((False, False))
    assert (left.loaded, left.valid) == (True, False)
    assert (right.loaded, right.valid) == (True, True)
    assert left.status == (0, 0, state, 0)


def test_uncalibrated_nothing_comes_out() -> None:
    live = sensing()
    live.sensing = None
    assert live.take([instant((20.0, 0.0, 0.0), (30.0, 0.0, 0.0))], SUPPORT) == []
    assert [flag.valid for flag in live.flags((False, False))] == [False, False]


def test_stale_numbers_are_worth_nothing() -> None:
    live = sensing()
    one(live, instant((20.0, 0.0, 0.0), (30.0, 0.0, 0.0)))
    assert [flag.valid for flag in live.flags((False, False))] == [True, True]
    for stale in ((True, True), (True, False), (False, True)):
        flags = live.flags(stale)
        assert tuple(flag.stale for flag in flags) == stale
        assert tuple(not flag.valid for flag in flags) == stale


def test_a_batch_is_as_good_as_one_after_another() -> None:
    instants = [
        instant((20.0 + index, 0.001 * index, 0.0), (30.0, 0.0, 0.0), stamp_ns=index * 10**7)
        for index in range(10)
    ]
    together = sensing().take(instants, SUPPORT)
    live = sensing()
    for found, joined in zip(together, instants, strict=True):
        alone = one(live, joined)
        assert found.stamp_ns == alone.stamp_ns
        assert found.cop is not None
        assert alone.cop is not None
        np.testing.assert_allclose(found.cop, alone.cop, atol=1e-12)


def test_the_low_pass_delays_a_ramp_by_what_it_says() -> None:
    low_pass = OutputFilter(2.0)
    slope, step_ns = 3.0, 10**6
    for index in range(2000):
        time = index * step_ns / 1e9
        found = low_pass(index * step_ns, np.array([slope * time]))
    assert found[0] == pytest.approx(slope * (time - low_pass.delay_s), abs=slope * 1e-3)


def test_the_low_pass_forgets_what_was_not_known() -> None:
    low_pass = OutputFilter(2.0)
    low_pass(0, np.array([1.0, 1.0]))
    gone = low_pass(10**7, np.array([math.nan, 1.0]))
    assert math.isnan(gone[0])
    assert gone[1] == 1.0
    back = low_pass(2 * 10**7, np.array([5.0, 1.0]))
    assert back[0] == 5.0
