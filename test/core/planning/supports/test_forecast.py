from __future__ import annotations

import dataclasses
import json

import numpy as np
import pytest
from numpy.typing import NDArray

from core.planning.bodies import Body
from shoecal_core.model.double_support import DoubleSupport
from shoecal_core.planning.settings import PlannerSettings
from shoecal_core.planning.supports.feasible import Feasible
from shoecal_core.planning.supports.forecast import (
    Forecast,
    best_additions,
    forecast,
    forecast_visits,
    total_information,
    worst_part,
)
from shoecal_core.planning.supports.observability import (
    GAIN_STD,
    OFFSET_STD_N,
    Visit,
    parameter_scale,
)

SETTINGS = PlannerSettings()
YAWED = (
    DoubleSupport(0.0, -0.12, 0.4),
    DoubleSupport(0.05, -0.15, -0.4),
    DoubleSupport(-0.03, -0.13, 0.1),
)
STRAIGHT = tuple(dataclasses.replace(support, dtheta=0.0) for support in YAWED)


def visits(body: Body, supports: tuple[DoubleSupport, ...]) -> list[Visit]:
    return [Visit.expected(body.robot, support, SETTINGS) for support in supports]


def known(body: Body, supports: tuple[DoubleSupport, ...]) -> NDArray[np.float64]:
    return total_information(body.robot, body.shoe, visits(body, supports))


def promised(body: Body, supports: tuple[DoubleSupport, ...]) -> Forecast:
    return forecast_visits(body.robot, body.shoe, visits(body, supports), SETTINGS)


def test_supports_that_differ_in_yaw_fix_everything(nao: Body) -> None:
    found = promised(nao, YAWED)
    assert found.rank == found.possible == len(found.uncertainties) == 14
    assert not found.weak
    assert (found.gain_std < 0.15).all()
    assert (found.offset_std < 3.0).all()


def test_without_yaw_the_feet_trade_off(nao: Body) -> None:
    """What is open lies between the feet, and only each foot's CoP suffers."""
    found, better = promised(nao, STRAIGHT), promised(nao, YAWED)
    assert found.rank < found.possible
    assert len(found.weak) == len(found.uncertainties) - found.rank
    assert all(weak.uncertainty >= SETTINGS.fixed_below for weak in found.weak)
    assert "opposite ways in the two feet" in found.weak[-1].words
    assert found.error.worst_foot_cop > 5.0 * better.error.worst_foot_cop
    assert found.error.cop.rms < 2.0 * better.error.cop.rms


def test_the_prior_bounds_what_no_data_tell(body: Body) -> None:
    nothing = np.zeros((2 * len(body.shoe.channels),) * 2)
    found = forecast(body.robot, body.shoe, nothing, SETTINGS)
    assert found.rank == 0
    assert np.isinf(found.uncertainties).all()
    assert (found.singular_values == 0.0).all()
    assert (found.gain_std <= GAIN_STD + 1e-9).all()
    force = ~body.shoe.torque
    assert (found.offset_std[force] <= OFFSET_STD_N + 1e-9).all()
    told = json.loads(json.dumps(found.to_json(), allow_nan=False))
    assert told["weak_directions"][0]["uncertainty"] is None


def test_uncertainty_is_the_scatter_of_repeated_fits(nao: Body) -> None:
    """Fits of one linear problem to fresh noise scatter as foretold, up to what nothing fixes."""
    found, total = promised(nao, YAWED), known(nao, YAWED)
    values, vectors = np.linalg.eigh(total)
    seen = values > 1e-9 * values[-1]
    generator = np.random.default_rng(0)
    draws = generator.normal(size=(4000, int(seen.sum()))) / np.sqrt(values[seen])
    scatter = (draws @ vectors[:, seen].T * parameter_scale(nao.robot, nao.shoe)).std(axis=0)
    # The prior helps a little.
    np.testing.assert_allclose(found.gain_std, scatter[:8], rtol=0.1)
    np.testing.assert_allclose(found.offset_std, scatter[8:], rtol=0.1)


def test_twice_the_data_half_the_variance(body: Body) -> None:
    once, twice = promised(body, YAWED), promised(body, YAWED + YAWED)
    np.testing.assert_allclose(twice.uncertainties, once.uncertainties / np.sqrt(2.0), rtol=1e-6)
    assert twice.error.worst_foot_cop < once.error.worst_foot_cop


def test_the_worst_part_is_the_straight_one(nao: Body) -> None:
    mixed = visits(nao, (YAWED[0], *STRAIGHT, YAWED[1]))
    indices, found = worst_part(nao.robot, nao.shoe, mixed, 3, SETTINGS)
    assert indices == (1, 2, 3)
    assert found.to_json() == promised(nao, STRAIGHT).to_json()


def test_an_addition_mends_what_is_open(nao: Body) -> None:
    before = promised(nao, STRAIGHT)
    first, second = best_additions(nao.robot, nao.shoe, known(nao, STRAIGHT), SETTINGS, 2)
    assert abs(first.support.dtheta) > 0.3
    assert first.forecast.rank == before.possible
    assert first.forecast.error.worst_foot_cop < 0.2 * before.error.worst_foot_cop
    assert second.forecast.uncertainties[-1] < first.forecast.uncertainties[-1]
    feasible = Feasible(nao.robot, SETTINGS)
    assert all(feasible.can_stand(addition.support) for addition in (first, second))
    again = promised(nao, (*STRAIGHT, first.support))
    np.testing.assert_allclose(again.gain_std, first.forecast.gain_std)


def test_none_is_added_where_the_robot_cannot_stand(nao: Body) -> None:
    place = np.array((0.08, -0.16, 0.416))
    span = dataclasses.replace(nao.robot.support_range, lower=place, upper=place)
    stiff = dataclasses.replace(nao.robot, support_range=span)
    assert best_additions(stiff, nao.shoe, known(nao, STRAIGHT), SETTINGS) == []


def test_a_planned_motion_counts_by_its_time_and_place(nao: Body) -> None:
    expected = Visit.expected(nao.robot, YAWED[0], SETTINGS)
    longer = dataclasses.replace(expected, duration=2.0 * expected.duration)
    one = forecast_visits(nao.robot, nao.shoe, [expected, expected], SETTINGS)
    other = forecast_visits(nao.robot, nao.shoe, [longer], SETTINGS)
    assert one.error.to_json() == pytest.approx(other.error.to_json())
