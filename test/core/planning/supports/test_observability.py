from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from core.planning.bodies import Body
from shoecal_core.arrays import FloatArray
from shoecal_core.estimation.residuals import ResidualWeights, pack, rows_of
from shoecal_core.planning.settings import PlannerSettings
from shoecal_core.planning.supports import observability
from shoecal_core.planning.supports.observability import (
    COP_STD_M,
    FORCE_STD_N,
    PLACES,
    UNEVEN_SHARE,
    Visit,
    best_rank,
    information,
    rank,
    relative_information,
    residual_jacobian,
    uncertainties,
    uneven_share,
)
from shoecal_core.robot.double_support import DoubleSupport
from shoecal_core.samples.stance import make_stance
from shoecal_core.screening.settings import CalibrationSettings
from shoecal_core.shoe.load_cases import double_support_outputs
from shoecal_core.shoe.priors import PriorSettings
from shoecal_core.shoe.sensing import Sensing
from shoecal_core.shoe.shoe import Shoe
from shoecal_core.shoe.wrench import ChannelParameters, columns_in_left

SETTINGS = PlannerSettings()
TURNED = DoubleSupport(0.04, -0.13, 0.35)
YAWED = (DoubleSupport(0.0, -0.12, 0.3), DoubleSupport(0.05, -0.15, -0.3), TURNED)
STRAIGHT = tuple(DoubleSupport(x, y, 0.0) for x, y in ((0, -0.12), (0.05, -0.15), (-0.03, -0.1)))


def measured(shoe: Shoe, outputs: FloatArray) -> FloatArray:
    """(p, 3) GRF and CoP of both feet in the left sole's frame."""
    count = len(shoe.channels)
    parameters = ChannelParameters(np.ones(count), np.zeros(count))
    got = Sensing(shoe, parameters, minimum_force=0.0).measure(outputs)
    return np.column_stack([got.total_grf, got.combined_cop(TURNED)])


def test_jacobian_against_finite_differences(body: Body) -> None:
    shoe, weight = body.shoe, body.robot.weight
    count = len(shoe.channels)
    # Between the feet, so that both are loaded.
    places = TURNED.translation / 2.0 + np.array([[0.02, 0.0], [0.01, 0.01], [0.03, -0.01]])
    outputs = double_support_outputs(shoe, TURNED, weight, places)
    np.testing.assert_allclose(measured(shoe, outputs)[:, 1:], places, atol=1e-12)
    jacobian = residual_jacobian(shoe, TURNED, weight, places)

    def shifted(change: FloatArray) -> FloatArray:
        return measured(shoe, outputs * (1.0 + change[:count]) + change[count:])

    for index, unit in enumerate(np.eye(2 * count)):
        step = 1e-6 * unit
        slope = (shifted(step) - shifted(-step)) / 2e-6
        np.testing.assert_allclose(jacobian[:, :, index], slope, atol=1e-6)


@given(st.builds(DoubleSupport, st.floats(-0.1, 0.1), st.floats(-0.2, -0.1), st.floats(-0.6, 0.6)))
def test_the_contour_is_walked_at_the_speed_of_the_com(body: Body, support: DoubleSupport) -> None:
    visit = Visit.expected(body.robot, support, SETTINGS)
    assert len(visit.places) == PLACES
    steps = np.linalg.norm(np.diff(visit.places, axis=0, append=visit.places[:1]), axis=1)
    moving = visit.duration - 2.0 * SETTINGS.hold_time
    # Chords cut the corners a little.
    assert 0.9 < steps.sum() / (moving * SETTINGS.com_speed) < 1.0 + 1e-9


def test_twice_the_time_tells_twice_as_much(body: Body) -> None:
    visit = Visit.expected(body.robot, TURNED, SETTINGS)
    longer = dataclasses.replace(visit, duration=2.0 * visit.duration)
    one = information(body.robot, body.shoe, visit)
    np.testing.assert_allclose(information(body.robot, body.shoe, longer), 2.0 * one)


def test_each_foot_stands_on_a_stiff_plate(nao: Body) -> None:
    uneven = uneven_share(nao.robot, nao.shoe, TURNED, 0.3)
    for foot in (0, 1):
        twist = np.zeros(8)
        twist[nao.shoe.of_foot(foot)] = (1.0, -1.0, -1.0, 1.0)
        np.testing.assert_allclose(uneven @ twist, 0.0, atol=1e-12)


def test_uneven_shares_are_counted_in_the_mean(body: Body) -> None:
    """Against outputs drawn at random, of which none changes force or moment."""
    robot, shoe = body.robot, body.shoe
    visit = Visit.expected(robot, TURNED, SETTINGS)
    visit = dataclasses.replace(visit, places=visit.places[::15])
    uneven = uneven_share(robot, shoe, TURNED, UNEVEN_SHARE)
    columns = columns_in_left(shoe, TURNED)
    np.testing.assert_allclose(uneven @ columns, 0.0, atol=1e-12)
    even = robot.weight / len(shoe.channels)
    variances = np.linalg.eigvalsh(uneven)
    np.testing.assert_allclose(variances[-3:], (UNEVEN_SHARE * even) ** 2)
    np.testing.assert_allclose(variances[:-3], 0.0, atol=1e-9)
    count, draws = len(shoe.channels), 20000
    slopes = residual_jacobian(shoe, TURNED, robot.weight, visit.places)[..., count:]
    slopes /= np.array([FORCE_STD_N, COP_STD_M, COP_STD_M])[:, None]
    outputs = double_support_outputs(shoe, TURNED, robot.weight, visit.places)
    generator = np.random.default_rng(0)
    moved = generator.multivariate_normal(np.zeros(count), uneven, draws)
    total = np.zeros((count, count))
    for place, output in zip(slopes, outputs, strict=True):
        total += (place.T @ place) * ((output + moved).T @ (output + moved)) / draws
    found = information(robot, shoe, visit)[:count, :count]
    independent = visit.duration / PriorSettings().correlation_s / len(visit.places)
    np.testing.assert_allclose(found, independent * total, atol=0.02 * np.abs(found).max())


def test_errors_are_the_fits_own() -> None:
    fit = CalibrationSettings()
    assert (fit.force_std_n, fit.cop_std_m) == (FORCE_STD_N, COP_STD_M)
    assert SETTINGS.fixed_below < fit.fixed_below


def test_information_is_that_of_the_fit(body: Body, monkeypatch: pytest.MonkeyPatch) -> None:
    """The same motion as readings under any gains and offsets, weighed by the fit."""
    robot, shoe = body.robot, body.shoe
    count, generator = len(shoe.channels), np.random.default_rng(0)
    visit = Visit.expected(robot, TURNED, SETTINGS)
    parameters = ChannelParameters(
        generator.uniform(5.0, 15.0, count), generator.normal(0.0, 3.0, count)
    )
    outputs = double_support_outputs(shoe, TURNED, robot.weight, visit.places)
    readings = (outputs - parameters.offset) / parameters.gain
    time = np.linspace(0.0, visit.duration, len(readings), endpoint=False)
    force = np.full(len(time), robot.weight)
    stance = make_stance(1, shoe, TURNED, (True, True), time, readings, force, visit.places)
    fit = CalibrationSettings()
    weights = ResidualWeights(fit.force_std_n, fit.cop_std_m, fit.correlation_s)
    jacobian = rows_of([stance], shoe, weights)(pack(parameters, 0.0))[1]
    found = jacobian.T @ jacobian
    monkeypatch.setattr(observability, "UNEVEN_SHARE", 0.0)
    expected = information(robot, shoe, visit)
    np.testing.assert_allclose(
        relative_information(robot, shoe, parameters, found[: 2 * count, : 2 * count]),
        expected,
        rtol=1e-6,
        atol=1e-9 * np.abs(expected).max(),
    )


def test_columns_of_the_left_foot_stay(body: Body) -> None:
    left = body.shoe.foot == 0
    columns = columns_in_left(body.shoe, TURNED)
    np.testing.assert_array_equal(columns[left], body.shoe.columns[left])


def total(
    body: Body, supports: tuple[DoubleSupport, ...], settings: PlannerSettings = SETTINGS
) -> FloatArray:
    visits = [Visit.expected(body.robot, support, settings) for support in supports]
    parts = [information(body.robot, body.shoe, visit) for visit in visits]
    return np.asarray(np.sum(parts, axis=0))


def test_ranks_of_four_cells_a_foot(nao: Body) -> None:
    """One pattern a foot (+ - - +) is never seen; without yaw left and right trade off."""
    assert best_rank(nao.robot, nao.shoe, 3, SETTINGS) == 14
    assert rank(total(nao, YAWED), SETTINGS) == 14
    assert rank(total(nao, STRAIGHT), SETTINGS) < 13
    assert rank(total(nao, YAWED[:1]), SETTINGS) <= 11


def test_the_unseen_pattern(nao: Body) -> None:
    jacobian_null = np.zeros(16)
    jacobian_null[8:12] = (1.0, -1.0, -1.0, 1.0)
    seen = total(nao, YAWED)
    assert jacobian_null @ seen @ jacobian_null < 1e-9 * np.trace(seen)


def test_three_cells_a_foot_are_fixed_entirely(nao: Body) -> None:
    keep = [index for index in range(8) if index % 4 != 3]
    shoe = nao.shoe
    three = Shoe(
        name="three", unit=shoe.unit, height=shoe.height,
        channels=tuple(shoe.channels[index] for index in keep),
        plates=shoe.plates, path=shoe.path, digest=shoe.digest,
    )  # fmt: skip
    assert best_rank(nao.robot, three, 3, SETTINGS) == 12


def test_uncertainty_is_that_of_linear_regression() -> None:
    generator = np.random.default_rng(0)
    rows = generator.normal(size=(30, 4)) * [1.0, 2.0, 5.0, 9.0]
    expected = np.sqrt(np.linalg.eigvalsh(np.linalg.inv(rows.T @ rows)))
    np.testing.assert_allclose(uncertainties(rows.T @ rows), np.sort(expected))
    rows[:, 3] = rows[:, 2]
    assert uncertainties(rows.T @ rows)[-1] == np.inf


def test_more_noise_fixes_less(body: Body, monkeypatch: pytest.MonkeyPatch) -> None:
    possible, before = best_rank(body.robot, body.shoe, 3, SETTINGS), total(body, YAWED)
    monkeypatch.setattr(observability, "FORCE_STD_N", 100.0 * FORCE_STD_N)
    monkeypatch.setattr(observability, "COP_STD_M", 100.0 * COP_STD_M)
    seen = total(body, YAWED)
    assert rank(seen, SETTINGS) < possible
    assert uncertainties(seen)[0] == pytest.approx(100 * uncertainties(before)[0])
