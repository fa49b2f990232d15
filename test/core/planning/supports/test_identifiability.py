from __future__ import annotations

import dataclasses
import json

import numpy as np

from core.planning.bodies import Body
from shoecal_core.arrays import FloatArray
from shoecal_core.planning.settings import PlannerSettings
from shoecal_core.planning.supports.feasible import Feasible
from shoecal_core.planning.supports.identifiability import (
    Identifiability,
    best_addition,
    identifiability,
    total_information,
)
from shoecal_core.planning.supports.observability import Visit
from shoecal_core.robot.double_support import DoubleSupport

SETTINGS = PlannerSettings()
YAWED = (
    DoubleSupport(0.0, -0.12, 0.4),
    DoubleSupport(0.05, -0.15, -0.4),
    DoubleSupport(-0.03, -0.13, 0.1),
)
STRAIGHT = tuple(dataclasses.replace(support, dtheta=0.0) for support in YAWED)


def visits(body: Body, supports: tuple[DoubleSupport, ...]) -> list[Visit]:
    return [Visit.expected(body.robot, support, SETTINGS) for support in supports]


def known(body: Body, supports: tuple[DoubleSupport, ...]) -> FloatArray:
    return total_information(body.robot, body.shoe, visits(body, supports))


def found_in(body: Body, supports: tuple[DoubleSupport, ...]) -> Identifiability:
    return identifiability(body.robot, body.shoe, known(body, supports), SETTINGS)


def test_supports_that_differ_in_yaw_fix_everything(nao: Body) -> None:
    found = found_in(nao, YAWED)
    assert found.rank == found.possible == len(found.uncertainties) == 14
    assert not found.weak


def test_without_yaw_the_feet_trade_off(nao: Body) -> None:
    """What is open lies between the feet."""
    found = found_in(nao, STRAIGHT)
    assert found.rank < found.possible
    assert len(found.weak) == len(found.uncertainties) - found.rank
    assert all(weak.uncertainty >= SETTINGS.fixed_below for weak in found.weak)
    assert "opposite ways in the two feet" in found.weak[-1].words


def test_nothing_fixes_nothing(body: Body) -> None:
    nothing = np.zeros((2 * len(body.shoe.channels),) * 2)
    found = identifiability(body.robot, body.shoe, nothing, SETTINGS)
    assert found.rank == 0
    assert np.isinf(found.uncertainties).all()
    assert (found.singular_values == 0.0).all()
    told = json.loads(json.dumps(found.to_json(), allow_nan=False))
    assert told["weak_directions"][0]["uncertainty"] is None


def test_uncertainty_is_the_scatter_of_repeated_fits(nao: Body) -> None:
    """Fits of one linear problem to fresh noise scatter as foretold, along what any data see."""
    total = known(nao, YAWED)
    values, vectors = np.linalg.eigh(total)
    seen = values > 1e-9 * values[-1]
    generator = np.random.default_rng(0)
    draws = generator.normal(size=(4000, int(seen.sum()))) / np.sqrt(values[seen])
    scatter = np.linalg.eigvalsh(np.cov((draws @ vectors[:, seen].T).T))[-int(seen.sum()) :]
    found = np.sort(found_in(nao, YAWED).uncertainties)
    np.testing.assert_allclose(np.sqrt(scatter), found, rtol=0.1)


def test_twice_the_data_half_the_variance(body: Body) -> None:
    once, twice = found_in(body, YAWED), found_in(body, YAWED + YAWED)
    np.testing.assert_allclose(twice.uncertainties, once.uncertainties / np.sqrt(2.0), rtol=1e-6)


def test_an_addition_mends_what_is_open(nao: Body) -> None:
    support = best_addition(nao.robot, nao.shoe, known(nao, STRAIGHT), SETTINGS)
    assert support is not None
    assert abs(support.dtheta) > 0.3
    assert Feasible(nao.robot, SETTINGS).can_stand(support)
    before, after = found_in(nao, STRAIGHT), found_in(nao, (*STRAIGHT, support))
    assert after.rank == before.possible
    assert after.uncertainties[-1] < before.uncertainties[-1]


def test_none_is_added_where_the_robot_cannot_stand(nao: Body) -> None:
    place = np.array((0.08, -0.16, -0.52))
    span = dataclasses.replace(nao.robot.support_range, lower=place, upper=place)
    stiff = dataclasses.replace(nao.robot, support_range=span)
    assert best_addition(stiff, nao.shoe, known(nao, STRAIGHT), SETTINGS) is None


def test_a_planned_motion_counts_by_its_time_and_place(nao: Body) -> None:
    expected = Visit.expected(nao.robot, YAWED[0], SETTINGS)
    longer = dataclasses.replace(expected, duration=2.0 * expected.duration)
    one, other = (
        total_information(nao.robot, nao.shoe, visits) for visits in ([expected] * 2, [longer])
    )
    np.testing.assert_allclose(one, other)
