from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from ros.bodies import ROOT, calibration, nao, nao_shoe
from shoecal_core.arrays import FloatArray
from shoecal_core.error_sources.tolerances import Tolerances
from shoecal_core.estimation.uncertainty.expected import ErrorModel
from shoecal_core.planning.posture import stance
from shoecal_core.robot.double_support import DoubleSupport
from shoecal_core.robot.kinematics import BodyStates, Kinematics
from shoecal_core.shoe.sensing import Sensing
from shoecal_core.shoe.shoe import Shoe
from shoecal_core.shoe.shoe_file import load_shoe
from shoecal_core.shoe.wrench import ChannelParameters, at_cop, to_left, weight_below
from shoecal_ros.calibrator.force_samples import STANCE, ForceSamples
from shoecal_ros.calibrator.live import FootFlags, Live, LiveSensing, OutputFilter
from shoecal_ros.calibrator.load import LoadSwitch
from shoecal_ros.inputs.joining import Joined

SUPPORT = DoubleSupport(0.02, -0.12, 0.2)
SOLES = ("left/l_sole", "left/r_sole")
FINE = FootFlags(loaded=True, valid=True, stale=False, extrapolating=False, status=())
FORCES = (30.0, 23.0)
EXACT = Tolerances(sideways_share=0.0, support_m=0.0, support_rad=0.0)
WEIGHED = replace(nao(), mass_std=0.0)
SILENT = np.zeros(8)
PLACES = np.array([[0.02, 0.005], [0.03, -0.01]])


def states() -> BodyStates:
    angles = nao().from_legs(stance(nao(), SUPPORT))
    return Kinematics(nao()).states(angles[None])


def live(shoe: Shoe, made: Any, readings: FloatArray) -> Live:
    sensing = LiveSensing(
        [shoe.of_foot(0), shoe.of_foot(1)], LoadSwitch(6.0, 3.0), OutputFilter(0.0)
    )
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


def support_variances(tolerances: Tolerances) -> FloatArray:
    return np.square([tolerances.support_m, tolerances.support_m, tolerances.support_rad])


def samples_of(
    made: Any, shoe: Shoe, sum_frame: str, tolerances: Tolerances = EXACT
) -> ForceSamples:
    return ForceSamples(made, WEIGHED, shoe, tolerances, SOLES, sum_frame)


def message(
    sum_frame: str = STANCE,
    *,
    forces: tuple[float, float] = FORCES,
    flags: Sequence[FootFlags] = (FINE, FINE),
    body: BodyStates | None = None,
) -> Any:
    shoe, made, readings = nao_sample(forces)
    samples = samples_of(made, shoe, sum_frame)
    return samples.message(live(shoe, made, readings), flags, body or states(), SILENT)


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
    found = samples_of(made, shoe, "left").message(
        live(shoe, made, readings), (FINE, FINE), states(), SILENT
    )
    assert made.covariance is not None
    rng = np.random.default_rng(5)
    drawn = rng.multivariate_normal(np.zeros(16), made.covariance, size=20_000)
    law, fitted = made.parameters, made.sensing(shoe)
    wrenches = []
    for change in drawn:
        other = ChannelParameters(law.gain + change[:8], law.offset + change[8:])
        foot, _ = Sensing(fitted.shoe, other, fitted.corrections).measure_instant(readings.tolist())
        assert foot.cop is not None
        wrenches.append((foot.force, *foot.cop))
    spread = np.cov(np.array(wrenches).T)
    assert found.left.covariance[0] == pytest.approx(spread[0, 0], rel=0.05)
    np.testing.assert_allclose(
        np.array(found.left.cop_covariance).reshape(2, 2), spread[1:, 1:], rtol=0.1, atol=2e-7
    )


def test_covariances_are_the_expected_errors_and_the_noise() -> None:
    shoe, made, readings = nao_sample()
    law, tolerances = made.parameters, Tolerances()
    # Of gains, offsets and three errors of columns, all correlated; supports off more than usual.
    rng = np.random.default_rng(6)
    root = 1e-3 * rng.normal(size=(19, 19))
    columns = [rng.normal(size=(8, 3)) for _ in range(3)]
    support = 2.0 * np.diag(support_variances(tolerances)) + 1e-7
    model = ErrorModel.of(nao(), shoe, shoe, law, root @ root.T, columns, support, tolerances)
    made = replace(
        made, columns=shoe.columns, covariance=model.stated.covariance[:16, :16],
        column_covariance=model.stated.covariance[16:], support_covariance=support,
    )  # fmt: skip
    samples = ForceSamples(made, nao(), shoe, tolerances, SOLES, "left")
    sample, outputs = live(shoe, made, readings), law.outputs(readings[None])
    found, noisy = (
        samples.message(sample, (FINE, FINE), states(), np.full(8, noise)) for noise in (0.0, 1e-3)
    )
    left, right = (model.foot(outputs, foot) for foot in (0, 1))
    for one, expected in (
        (found.left, left), (found.right, right), (found.both, model.both_feet(outputs, SUPPORT)),
    ):  # fmt: skip
        variances = np.array(one.cop_covariance)[[0, 3]]
        np.testing.assert_allclose(np.sqrt(variances), expected.cop[0], rtol=1e-5)
        assert one.covariance[0] == pytest.approx(expected.grf[0] ** 2)
    added = noisy.left.covariance[0] - found.left.covariance[0]
    assert added == pytest.approx(np.sum((law.gain[shoe.of_foot(0)] * 1e-3) ** 2))


def test_the_sum_on_the_right_errs_by_where_that_foot_stands() -> None:
    shoe, made, readings = nao_sample()
    made, tolerances = replace(made, covariance=np.zeros((16, 16))), Tolerances(sideways_share=0.0)
    samples = samples_of(made, shoe, "right", tolerances)
    found = samples.message(live(shoe, made, readings), (FINE, FINE), states(), SILENT).both
    left, right = at_cop(np.array(FORCES), PLACES)

    def in_right(support: FloatArray) -> FloatArray:
        turn = to_left(DoubleSupport(*support))
        return np.asarray(np.linalg.solve(turn, left) + right)

    mean, step = np.array([SUPPORT.dx, SUPPORT.dy, SUPPORT.dtheta]), 1e-5
    slopes = np.array([in_right(mean + d) - in_right(mean - d) for d in step * np.eye(3)]).T
    slopes /= 2.0 * step
    expected = slopes * support_variances(tolerances) @ slopes.T
    np.testing.assert_allclose(
        np.array(found.covariance).reshape(3, 3), expected, rtol=1e-4, atol=1e-12
    )


def test_without_covariance_it_says_so() -> None:
    shoe, _, readings = nao_sample()
    plain = calibration(nao(), shoe)
    found = samples_of(plain, shoe, STANCE).message(
        live(shoe, plain, readings), (FINE, FINE), states(), SILENT
    )
    assert np.isnan(found.both.covariance).all()
    assert np.isnan(found.both.cop_covariance).all()


def test_stale_joints_leave_the_feet_and_stop_the_sum() -> None:
    shoe, made, readings = nao_sample()
    found = samples_of(made, shoe, STANCE).message(
        live(shoe, made, readings), (FINE, FINE), None, SILENT
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
    found = samples_of(made, shoe, "left").message(
        live(shoe, made, readings), (FINE, FINE), states(), np.zeros(count)
    )
    assert list(found.left.measured) == [True] * 5 + [False]
    assert (found.left.wrench.force.x, found.left.wrench.force.y) == (21.0, -9.0)
    turned = SUPPORT.rotation @ np.array([9.0, 13.0])
    both = found.both.wrench.force
    np.testing.assert_allclose([both.x, both.y], np.array([21.0, -9.0]) + turned, atol=1e-4)
