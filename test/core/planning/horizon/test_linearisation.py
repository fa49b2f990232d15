"""Derivatives by differences; rows by what certifies solutions."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from core.planning.bodies import Body
from core.planning.horizons import lifting, problems
from core.planning.motions import SETTINGS
from shoecal_core.arrays import FloatArray
from shoecal_core.planning.horizon.collocation import Collocation
from shoecal_core.planning.horizon.linearisation import (
    Curvature,
    Inequalities,
    Linearisation,
    Linearised,
)

STEP = 1e-6


@pytest.fixture(scope="module")
def collocation(body: Body) -> Collocation:
    return Collocation(body.legs, SETTINGS)


def around(start: FloatArray, seed: int = 0) -> FloatArray:
    """States of one horizon, not in place."""
    generator = np.random.default_rng(seed)
    return start + generator.uniform(-0.05, 0.05, (SETTINGS.horizon, len(start)))


def all_slopes(linear: Linearised) -> FloatArray:
    return np.concatenate([linear.tasks, linear.foot, linear.rest], axis=1)


def all_values(linear: Linearised) -> FloatArray:
    values = linear.values
    return np.hstack(
        [values.tasks, values.foot_error, values.distances, values.balance, values.torques]
    )


def test_values_are_those_of_the_problem(body: Body, collocation: Collocation) -> None:
    problem, _ = lifting(body)
    states = around(problem.start)
    linear = Linearisation(collocation)(states, problem.scene)
    expected = collocation.evaluate(states, problem.scene)
    for name in ("tasks", "foot_error", "distances", "balance", "torques"):
        found = getattr(linear.values, name)
        np.testing.assert_allclose(found, getattr(expected, name), atol=1e-12)


def test_slopes_and_curvature_by_differences(body: Body, collocation: Collocation) -> None:
    problem, _ = lifting(body)
    states = around(problem.start)
    at, second = Linearisation(collocation), Curvature(collocation)
    linear = at(states, problem.scene)
    prices = np.random.default_rng(1).normal(size=(len(states), 11))
    curvature = second(states, problem.scene, prices)
    for column, unit in enumerate(np.eye(states.shape[1])):
        ahead, behind = (at(states + way * STEP * unit, problem.scene) for way in (1.0, -1.0))
        slope = (all_values(ahead) - all_values(behind)) / (2.0 * STEP)
        np.testing.assert_allclose(all_slopes(linear)[..., column], slope, atol=1e-5, rtol=1e-4)
        change = (all_slopes(ahead) - all_slopes(behind))[:, :11] / (2.0 * STEP)
        expected = np.einsum("nr,nrk->nk", prices, change)
        np.testing.assert_allclose(curvature[..., column], expected, atol=1e-6)


def test_violation_is_the_certificate_s(body: Body, collocation: Collocation) -> None:
    for seed, (given, _) in enumerate(problems(body)[::4]):
        scene = given.scene.padded(collocation.edges)
        problem = dataclasses.replace(given, scene=scene)
        limits = collocation.limits(problem)
        states = around(problem.start, seed)
        linear = Linearisation(collocation)(states, problem.scene)
        found = Inequalities(problem, limits).violation(linear)
        expected = collocation.assess(problem, limits, states)[1]
        assert found == pytest.approx(expected, rel=1e-9)
