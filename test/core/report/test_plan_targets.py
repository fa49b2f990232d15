"""Landmarks as they were pursued: numbers, distances, those that were not reached."""

from __future__ import annotations

import math

import numpy as np
import pytest

from core.report import plans
from shoecal_core.report.plan.content import Target, marks_of

RADIUS = 0.004


def target(number: int, x: float = 0.0, nearest: float = 0.002, cop: float = 0.002) -> Target:
    return Target(number, np.array([x, 0.0]), nearest, cop, nearest < RADIUS, 5)


def test_places_that_are_the_same_are_one_mark() -> None:
    targets = [target(1), target(2), target(3), target(4, 0.1), target(5, 0.0004)]
    marks = marks_of(targets, RADIUS)
    assert [mark.label for mark in marks] == ["1–3, 5", "4"]
    np.testing.assert_array_equal(marks[1].place, [0.1, 0.0])
    assert marks_of([], RADIUS) == ()


@pytest.mark.parametrize(
    ("one", "told"),
    [
        (target(3, nearest=0.01558, cop=0.0155), "15.6 mm off"),
        (target(3, nearest=math.inf), "never pursued"),
        (target(3, nearest=0.02, cop=0.001), "lean or height off"),
    ],
)
def test_what_is_missing(one: Target, told: str) -> None:
    assert one.off(RADIUS) == told
    assert marks_of([target(1, 0.1), one], RADIUS)[1].label == f"3: {told}"


def test_of_one_place_the_worst_is_told() -> None:
    marks = marks_of([target(1), target(2, nearest=0.02, cop=0.02)], RADIUS)
    assert [mark.label for mark in marks] == ["1–2: 20.0 mm off"]


def test_distances_are_the_planners() -> None:
    for planned in (plans.reaching(), plans.missing()):
        path = planned.motion.path
        assert [one.nearest for one in planned.targets] == path.nearest.tolist()
        np.testing.assert_allclose([one.place for one in planned.targets], path.targets[:, :2])
        samples = [one.sample for one in planned.targets]
        assert samples == sorted(samples)
        for one in planned.targets:
            away = np.linalg.norm(planned.motion.cop[one.sample] - one.place)
            assert away == pytest.approx(one.cop_distance, abs=1e-6)
            assert one.cop_distance <= one.nearest + 1e-4
    assert all(one.reached for one in plans.reaching().targets)
    assert [one.number for one in plans.missing().targets if not one.reached] == [3]
