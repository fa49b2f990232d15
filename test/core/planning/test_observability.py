from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from core.planning.bodies import Body
from shoecal_core.model.double_support import DoubleSupport
from shoecal_core.planning.observability import (
    best_rank,
    contour_places,
    information,
    predicted_forces,
    rank,
    residual_jacobian,
    uncertainties,
)
from shoecal_core.planning.settings import PlannerSettings
from shoecal_core.sensing.shoe import Shoe
from shoecal_core.sensing.wrench import columns_in_left

SETTINGS = PlannerSettings()
TURNED = DoubleSupport(0.04, -0.13, 0.35)
YAWED = (DoubleSupport(0.0, -0.12, 0.3), DoubleSupport(0.05, -0.15, -0.3), TURNED)
STRAIGHT = tuple(DoubleSupport(x, y, 0.0) for x, y in ((0, -0.12), (0.05, -0.15), (-0.03, -0.1)))


def measured(
    shoe: Shoe, support: DoubleSupport, forces: NDArray[np.float64]
) -> NDArray[np.float64]:
    """(p, 3) GRF and CoP in the left sole's frame, from each cell's place on the floor."""
    places = shoe.positions.copy()
    places[shoe.foot == 1] = support.right_to_left(places[shoe.foot == 1])
    force = forces.sum(axis=1)
    return np.column_stack([force, forces @ places / force[:, None]])


@given(st.builds(DoubleSupport, st.floats(-0.1, 0.1), st.floats(-0.2, -0.1), st.floats(-0.6, 0.6)))
def test_forces_carry_weight_and_cop(body: Body, support: DoubleSupport) -> None:
    places = contour_places(body.robot, support, 12)
    forces = predicted_forces(body.shoe, support, body.robot.weight, places)
    got = measured(body.shoe, support, forces)
    np.testing.assert_allclose(got[:, 0], body.robot.weight)
    np.testing.assert_allclose(got[:, 1:], places, atol=1e-12)


def test_jacobian_against_finite_differences(body: Body) -> None:
    shoe, weight = body.shoe, body.robot.weight
    count = len(shoe.channels)
    places = contour_places(body.robot, TURNED, 6)
    forces = predicted_forces(shoe, TURNED, weight, places)
    jacobian = residual_jacobian(shoe, TURNED, weight, places, forces)

    def shifted(change: NDArray[np.float64]) -> NDArray[np.float64]:
        return measured(shoe, TURNED, forces * (1.0 + change[:count]) + change[count:])

    for index, unit in enumerate(np.eye(2 * count)):
        step = 1e-6 * unit
        slope = (shifted(step) - shifted(-step)) / 2e-6
        np.testing.assert_allclose(jacobian[:, :, index], slope, atol=1e-6)


def test_columns_of_the_left_foot_stay(body: Body) -> None:
    left = body.shoe.foot == 0
    columns = columns_in_left(body.shoe, TURNED)
    np.testing.assert_array_equal(columns[left], body.shoe.columns[left])


def total(body: Body, supports: tuple[DoubleSupport, ...]) -> NDArray[np.float64]:
    parts = [information(body.robot, body.shoe, support, SETTINGS) for support in supports]
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


def test_more_noise_fixes_less(body: Body) -> None:
    noisy = dataclasses.replace(SETTINGS, grf_noise=30.0, cop_noise=0.25)
    seen = np.sum([information(body.robot, body.shoe, s, noisy) for s in YAWED], axis=0)
    assert rank(seen, noisy) < best_rank(body.robot, body.shoe, 3, SETTINGS)
    assert uncertainties(seen)[0] == pytest.approx(100 * uncertainties(total(body, YAWED))[0])
