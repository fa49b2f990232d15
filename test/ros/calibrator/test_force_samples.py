from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from ros.bodies import ROOT, calibration, nao, nao_shoe
from shoecal_core.model.double_support import DoubleSupport
from shoecal_core.model.kinematics import BodyStates, Kinematics
from shoecal_core.planning.posture import stance
from shoecal_core.sensing.instant import InstantSensing
from shoecal_core.sensing.shoe import Shoe, load_shoe
from shoecal_core.sensing.wrench import ChannelParameters, at_cop, weight_below
from shoecal_ros.calibrator.force_samples import STANCE, ForceSamples
from shoecal_ros.calibrator.live import FootFlags, Live, LiveSensing, LowPass
from shoecal_ros.calibrator.load import LoadSwitch
from shoecal_ros.inputs.joining import Joined

FloatArray = NDArray[np.float64]
SUPPORT = DoubleSupport(0.02, -0.12, 0.2)
SOLES = ("left/l_sole", "left/r_sole")
FINE = FootFlags(loaded=True, valid=True, stale=False, extrapolating=False, status=())
FORCES = (30.0, 23.0)
PLACES = np.array([[0.02, 0.005], [0.03, -0.01]])


def states() -> BodyStates:
    angles = nao().from_legs(stance(nao(), SUPPORT))
    return Kinematics(nao()).states(angles[None])


def live(shoe: Shoe, made: Any, readings: FloatArray) -> Live:
    sensing = LiveSensing([shoe.of_foot(0), shoe.of_foot(1)], LoadSwitch(6.0, 3.0), LowPass(0.0))
    sensing.sensing = made.sensing(shoe)
    status = np.zeros(len(shoe.names), dtype=np.uint8)
    joined = Joined(10**18, readings, status, np.ones(len(shoe.names), dtype=bool))
    (one,) = sensing.take([joined], SUPPORT)
    return one


def nao_sample(forces: tuple[float, float] = FORCES) -> tuple[Shoe, Any, FloatArray]:
    shoe = nao_shoe()
    rng = np.random.default_rng(4)
    root = 1e-2 * rng.normal(size=(16, 16))
    made = calibration(nao(), shoe, covariance=root @ root.T)
    carried = at_cop(np.array(forces), PLACES) - weight_below(shoe)
    outputs = np.zeros(16 // 2)
    for foot in (0, 1):
        own = shoe.of_foot(foot)
        outputs[own] = carried[foot] @ np.linalg.pinv(shoe.columns[own])
    return shoe, made, (outputs - made.parameters.offset) / made.parameters.gain


def message(
    sum_frame: str = STANCE,
    *,
    forces: tuple[float, float] = FORCES,
    flags: Sequence[FootFlags] = (FINE, FINE),
    body: BodyStates | None = None,
) -> Any:
    shoe, made, readings = nao_sample(forces)
    samples = ForceSamples(made, shoe, SOLES, sum_frame)
    return samples.message(live(shoe, made, readings), flags, body or states())


def cop(foot: Any) -> FloatArray:
    return np.array([foot.cop.x, foot.cop.y])


def vertical(foot: Any) -> FloatArray:
    wrench = foot.wrench
    return np.array([wrench.force.z, wrench.torque.x, wrench.torque.y])


def test_both_feet_and_their_sum_come_in_one_message() -> None:
    found = message()
    for foot, force, place, frame in zip(
        (found.left, found.right), FORCES, PLACES, SOLES, strict=True
    ):
        assert foot.frame_id == frame
        assert foot.wrench.force.z == pytest.approx(force)
        np.testing.assert_allclose(cop(foot), place, atol=1e-9)
        assert foot.valid
        assert foot.loaded
        assert foot.has_cop
    assert found.header.frame_id == found.both.frame_id == SOLES[0]
    assert found.calibration == "made-1"
    shares = np.array(FORCES) / sum(FORCES)
    right = SUPPORT.right_to_left(PLACES[1])
    np.testing.assert_allclose(
        cop(found.both), shares[0] * PLACES[0] + shares[1] * right, atol=1e-6
    )
    assert found.both.valid


def test_axes_that_nothing_measures_are_no_numbers() -> None:
    found = message()
    for foot in (found.left, found.right, found.both):
        assert list(foot.measured) == [False, False, True, True, True, False]
        assert math.isnan(foot.wrench.force.x)
        assert math.isnan(foot.wrench.torque.z)


def test_an_unloaded_foot_has_no_cop() -> None:
    found = message(forces=(50.0, 1.0))
    assert not found.right.has_cop
    assert math.isnan(found.right.cop.x)
    assert list(found.right.measured) == [False, False, True, False, False, False]
    assert found.both.has_cop


@pytest.mark.parametrize("forces", [FORCES, (50.0, 0.5), (0.5, 50.0)])
def test_a_fixed_frame_does_not_switch_and_says_the_same(forces: tuple[float, float]) -> None:
    left, right = message("left", forces=forces).both, message("right", forces=forces).both
    assert (left.frame_id, right.frame_id) == SOLES
    np.testing.assert_allclose(SUPPORT.right_to_left(cop(right)), cop(left), atol=1e-6)
    for one in (left, right):
        force, about_x, about_y = vertical(one)
        np.testing.assert_allclose([-about_y / force, about_x / force], cop(one), atol=1e-5)
    by_left, by_right = (np.array(one.covariance).reshape(3, 3) for one in (left, right))
    assert by_left[0, 0] == pytest.approx(by_right[0, 0])


def test_covariances_are_those_of_draws() -> None:
    shoe, made, readings = nao_sample()
    found = ForceSamples(made, shoe, SOLES, "left").message(
        live(shoe, made, readings), (FINE, FINE), states()
    )
    assert made.covariance is not None
    rng = np.random.default_rng(5)
    drawn = rng.multivariate_normal(np.zeros(16), made.covariance, size=20_000)
    law = made.parameters
    wrenches = []
    for change in drawn:
        other = ChannelParameters(law.gain + change[:8], law.offset + change[8:])
        sensing = made.sensing(shoe)
        sensing.parameters = other
        foot, _ = InstantSensing(sensing).measure(readings.tolist())
        assert foot.cop is not None
        wrenches.append((foot.force, *foot.cop))
    spread = np.cov(np.array(wrenches).T)
    assert found.left.covariance[0] == pytest.approx(spread[0, 0], rel=0.05)
    np.testing.assert_allclose(
        np.array(found.left.cop_covariance).reshape(2, 2), spread[1:, 1:], rtol=0.1, atol=2e-7
    )


def test_without_covariance_it_says_so() -> None:
    shoe, _, readings = nao_sample()
    plain = calibration(nao(), shoe)
    found = ForceSamples(plain, shoe, SOLES, STANCE).message(
        live(shoe, plain, readings), (FINE, FINE), states()
    )
    assert np.isnan(found.both.covariance).all()
    assert np.isnan(found.both.cop_covariance).all()


def test_stale_joints_leave_the_feet_and_stop_the_sum() -> None:
    shoe, made, readings = nao_sample()
    found = ForceSamples(made, shoe, SOLES, STANCE).message(
        live(shoe, made, readings), (FINE, FINE), None
    )
    assert found.left.valid
    assert found.both.stale
    assert not found.both.valid
    assert not any(found.both.measured)


def test_a_six_axis_sensor_tells_sideways_forces_too() -> None:
    shoe = load_shoe(ROOT / "config/shoes/reemc.yaml")
    count = len(shoe.names)
    law = ChannelParameters(np.full(count, 2.0), np.full(count, 1.0))
    made = calibration(nao(), shoe, parameters=law)
    readings = np.array([10.0, -5.0, 150.0, 2.0, 3.0, 4.0, 6.0, 140.0, 1.0, -2.0])
    found = ForceSamples(made, shoe, SOLES, "left").message(
        live(shoe, made, readings), (FINE, FINE), states()
    )
    assert list(found.left.measured) == [True] * 5 + [False]
    assert (found.left.wrench.force.x, found.left.wrench.force.y) == (21.0, -9.0)
    turned = SUPPORT.rotation @ np.array([9.0, 13.0])
    both = found.both.wrench.force
    np.testing.assert_allclose([both.x, both.y], np.array([21.0, -9.0]) + turned, atol=1e-4)
