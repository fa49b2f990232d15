"""GRF and CoP of channel outputs (paper, eqs. 1 to 3), and wrenches of two feet together."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import ArrayLike

from core.shoe import shoes
from shoecal_core.arrays import FloatArray
from shoecal_core.errors import ShapeError, ShoecalError
from shoecal_core.robot.double_support import DoubleSupport
from shoecal_core.robot.gravity import GRAVITY
from shoecal_core.shoe.shoe import Plates, Shoe
from shoecal_core.shoe.wrench import (
    ChannelParameters,
    at_cop,
    by_parameters,
    columns_in_left,
    combined,
    cop,
    cop_jacobian,
    foot_wrenches,
    to_left,
    weight_below,
)

coordinates = st.floats(-0.3, 0.3)
points = st.tuples(coordinates, coordinates).map(np.array)
angles = st.floats(-math.pi, math.pi)
supports = st.builds(DoubleSupport, coordinates, coordinates, angles)
forces = st.floats(0.5, 200.0)
SQUARE = [(0.1, 0.05), (0.1, -0.05), (-0.1, 0.05), (-0.1, -0.05)]


def floor_wrench(point: ArrayLike, force: ArrayLike) -> FloatArray:
    """(F, Mx, My) of a 3-D force at a 3-D point, by r x f."""
    push = np.asarray(force)
    moment = np.cross(np.asarray(point), push)
    return np.array([push[2], moment[0], moment[1]])


# ---- eq. 3 ------------------------------------------------------------------------------------


def test_affine_law_is_the_single_cell_calibration() -> None:
    no_load, loaded, weight = 0.4, -1.1, 9.81
    sigma = (loaded - no_load) / weight
    parameters = ChannelParameters(np.array([1.0 / sigma]), np.array([-no_load / sigma]))
    outputs = parameters.outputs(np.array([[no_load], [loaded], [-0.35]]))
    np.testing.assert_allclose(outputs[:, 0], [0.0, 9.81, 4.905], atol=1e-14)


@pytest.mark.parametrize(("gain", "offset"), [([[1.0]], [[0.0]]), ([1.0, 2.0], [0.0]), ([], [0.0])])
def test_parameters_of_other_shapes_are_refused(gain: list[float], offset: list[float]) -> None:
    with pytest.raises(ShapeError, match="offset"):
        ChannelParameters(np.array(gain), np.array(offset))


@pytest.mark.parametrize("bad", [math.nan, math.inf])
def test_parameters_that_are_not_finite_are_refused(bad: float) -> None:
    for gain, offset in (([bad], [0.0]), ([1.0], [bad])):
        with pytest.raises(ShoecalError, match="finite"):
            ChannelParameters(np.array(gain), np.array(offset))


def test_readings_of_another_shape_are_refused() -> None:
    parameters = ChannelParameters(np.ones(4), np.zeros(4))
    with pytest.raises(ShapeError, match=r"expected shape \(\.\.\., 4\), got \(2, 3\)"):
        parameters.outputs(np.zeros((2, 3)))


# ---- eqs. 1 and 2 -----------------------------------------------------------------------------


def test_grf_and_cop_by_hand() -> None:
    shoe = shoes.made(shoes.cells(0, SQUARE) + shoes.cells(1, SQUARE))
    outputs = np.array([1.0, 2.0, 3.0, 4.0, 10.0, 0.0, 0.0, 0.0])
    left, right = foot_wrenches(shoe, outputs)
    # Front less rear: three newtons against seven; left less right: four against six.
    assert left[0] == 10.0
    np.testing.assert_allclose(cop(left, 0.0), [-0.04, -0.01], atol=1e-15)
    np.testing.assert_allclose(cop(right, 0.0), SQUARE[0], atol=1e-15)


@given(st.lists(st.tuples(points, st.floats(-5.0, 50.0)), min_size=3, max_size=8))
def test_grf_is_the_sum_and_cop_the_weighted_mean(
    loads: list[tuple[FloatArray, float]],
) -> None:
    places = np.array([point for point, _ in loads])
    outputs = np.array([force for _, force in loads])
    shoe = shoes.made(shoes.cells(0, places) + shoes.cells(1, SQUARE))
    wrench = foot_wrenches(shoe, np.concatenate((outputs, np.zeros(4))))[0]
    total = outputs.sum()
    np.testing.assert_allclose(wrench[0], total, atol=1e-12)
    if total > 1.0:
        np.testing.assert_allclose(
            cop(wrench, 1.0), outputs @ places / total, rtol=1e-9, atol=1e-12
        )


@given(forces, supports)
def test_double_support_uses_all_cells_at_once(force: float, support: DoubleSupport) -> None:
    shoe = shoes.shoe("odd_shoe")
    rng = np.random.default_rng(5)
    outputs = force * rng.uniform(0.2, 1.0, 9)
    wrench = combined(foot_wrenches(shoe, outputs) - weight_below(shoe), support)
    where = shoe.positions.copy()
    right = shoe.foot == 1
    where[right] = where[right] @ support.rotation.T + support.translation
    np.testing.assert_allclose(wrench[0], outputs.sum())
    np.testing.assert_allclose(cop(wrench, 0.0), outputs @ where / outputs.sum(), atol=1e-12)


@given(points, forces)
def test_cop_undoes_at_cop(place: FloatArray, force: float) -> None:
    wrench = at_cop(np.asarray(force), place)
    np.testing.assert_array_equal(wrench, floor_wrench([*place, 0.0], [0.0, 0.0, force]))
    np.testing.assert_allclose(cop(wrench, 0.1), place, atol=1e-15)


def test_no_cop_at_or_below_the_minimum_force() -> None:
    wrenches = at_cop(np.array([-3.0, 0.0, 2.0, np.nextafter(2.0, 3.0)]), np.full((4, 2), 0.1))
    found = cop(wrenches, 2.0)
    assert np.isnan(found[:3]).all()
    np.testing.assert_allclose(found[3], [0.1, 0.1])


@pytest.mark.parametrize("shape", [(), (1,), (5,), (2, 3)])
def test_any_leading_shape(shoe: Shoe, shape: tuple[int, ...]) -> None:
    support = DoubleSupport(0.02, -0.1, 0.3)
    outputs = np.random.default_rng(0).uniform(1.0, 9.0, (*shape, len(shoe.channels)))
    wrenches = foot_wrenches(shoe, outputs)
    both = combined(wrenches, support)
    assert wrenches.shape == (*shape, 2, 3)
    assert both.shape == (*shape, 3)
    assert cop(wrenches, 0.0).shape == (*shape, 2, 2)
    for index in np.ndindex(*shape):
        one = foot_wrenches(shoe, outputs[index])
        np.testing.assert_allclose(wrenches[index], one, rtol=1e-13)
        np.testing.assert_allclose(both[index], combined(one, support), rtol=1e-13)


# ---- frames -----------------------------------------------------------------------------------


@given(points, forces, supports)
def test_to_left_moves_a_force_with_its_point(
    place: FloatArray, force: float, support: DoubleSupport
) -> None:
    c, s = math.cos(support.dtheta), math.sin(support.dtheta)
    x, y = place
    moved = [support.dx + c * x - s * y, support.dy + s * x + c * y]
    wrench = to_left(support) @ at_cop(np.asarray(force), place)
    np.testing.assert_allclose(wrench[0], force)
    np.testing.assert_allclose(cop(wrench, 0.0), moved, atol=1e-14)


@given(st.tuples(forces, coordinates, coordinates), supports)
def test_to_left_is_the_rigid_body_rule(
    wrench: tuple[float, float, float], support: DoubleSupport
) -> None:
    force, mx, my = wrench
    c, s = math.cos(support.dtheta), math.sin(support.dtheta)
    lever = np.cross([support.dx, support.dy, 0.0], [0.0, 0.0, force])
    expected = [force, c * mx - s * my + lever[0], s * mx + c * my + lever[1]]
    np.testing.assert_allclose(to_left(support) @ np.array(wrench), expected, atol=1e-12)


@given(supports)
def test_columns_in_left_are_the_cells_seen_from_the_left(support: DoubleSupport) -> None:
    for name in shoes.NAMES:
        shoe = shoes.shoe(name)
        outputs = np.random.default_rng(1).uniform(-3.0, 9.0, (4, len(shoe.channels)))
        total = outputs @ columns_in_left(shoe, support) + combined(weight_below(shoe), support)
        np.testing.assert_allclose(total, combined(foot_wrenches(shoe, outputs), support))
    assert shoes.shoe("nao_shoe").columns[4, 0] == 1.0  # the shoe's own are not written to


# ---- what hangs below the cells ---------------------------------------------------------------


@given(st.floats(0.0, 2.0), points, forces, points)
def test_the_parts_below_the_cells_count_with_their_place(
    mass: float, com: FloatArray, force: float, place: FloatArray
) -> None:
    plates = Plates(0.0, np.zeros(3), mass, np.array([*com, 0.01]))
    shoe = shoes.made(shoes.cells(0, SQUARE) + shoes.cells(1, SQUARE), (plates, shoes.NO_PLATES))
    outputs = np.linalg.pinv(shoe.columns[:4].T) @ at_cop(np.asarray(force), place)
    wrench = foot_wrenches(shoe, np.concatenate((outputs, np.zeros(4))))[0]
    weight = mass * GRAVITY
    np.testing.assert_allclose(wrench[0], force + weight)
    np.testing.assert_allclose(
        cop(wrench, 0.0), (force * place + weight * com) / (force + weight), atol=1e-12
    )


# ---- six axes ---------------------------------------------------------------------------------

pushes = st.tuples(st.floats(-30.0, 30.0), st.floats(-30.0, 30.0), forces).map(np.array)
origins = st.tuples(coordinates, coordinates, st.floats(0.0, 0.2)).map(np.array)


def sensed(origin: FloatArray, point: FloatArray, force: FloatArray) -> FloatArray:
    """(5,) what a sensor at `origin` feels of a force at a point of the floor."""
    torque = np.cross(np.array([*point, 0.0]) - origin, force)
    return np.array([*force, torque[0], torque[1]])


@given(origins, points, pushes)
def test_a_six_axis_sensor_tells_where_the_floor_pushes(
    origin: FloatArray, point: FloatArray, force: FloatArray
) -> None:
    shoe = shoes.made(shoes.six_axis(0, origin) + shoes.six_axis(1, origin))
    outputs = np.concatenate((np.zeros(5), sensed(origin, point, force)))
    wrench = foot_wrenches(shoe, outputs)[1]
    np.testing.assert_allclose(wrench, floor_wrench([*point, 0.0], force), atol=1e-10)
    np.testing.assert_allclose(cop(wrench, 0.0), point, atol=1e-9)


@given(origins, points, pushes)
def test_without_its_sideways_axes_it_errs_by_height_times_sideways_force(
    origin: FloatArray, point: FloatArray, force: FloatArray
) -> None:
    axes = ("fz", "mx", "my")
    shoe = shoes.made(shoes.six_axis(0, origin, axes) + shoes.six_axis(1, origin, axes))
    outputs = np.concatenate((sensed(origin, point, force)[2:], np.zeros(3)))
    found = cop(foot_wrenches(shoe, outputs)[0], 0.0)
    np.testing.assert_allclose(
        found - point, origin[2] * force[:2] / force[2], rtol=1e-9, atol=1e-9
    )


@given(origins, points, forces)
def test_cells_and_a_six_axis_sensor_agree(
    origin: FloatArray, point: FloatArray, force: float
) -> None:
    six = shoes.made(shoes.six_axis(0, origin) + shoes.six_axis(1, origin))
    four = shoes.made(shoes.cells(0, SQUARE) + shoes.cells(1, SQUARE))
    push = np.array([0.0, 0.0, force])
    by_sensor = foot_wrenches(six, np.concatenate((sensed(origin, point, push), np.zeros(5))))
    carried = np.linalg.pinv(four.columns[:4].T) @ at_cop(np.asarray(force), point)
    by_cells = foot_wrenches(four, np.concatenate((carried, np.zeros(4))))
    np.testing.assert_allclose(by_sensor, by_cells, atol=1e-10)


@given(st.lists(st.floats(1.0, 60.0), min_size=3, max_size=3))
def test_slopes_of_the_cop_are_its_differences(wrench: list[float]) -> None:
    middle, step = np.array(wrench), 1e-5
    found = cop_jacobian(middle)

    def measured(one: FloatArray) -> FloatArray:
        return np.append(one[0], cop(one, 0.0))

    for axis, change in enumerate(step * np.eye(3)):
        slope = (measured(middle + change) - measured(middle - change)) / (2.0 * step)
        np.testing.assert_allclose(found[:, axis], slope, rtol=1e-5, atol=1e-6)


def test_outputs_depend_on_gains_by_the_readings_and_on_offsets_as_they_are() -> None:
    rng = np.random.default_rng(2)
    slopes, readings = rng.normal(size=(7, 3, 4)), rng.normal(size=(7, 4))
    gain, offset = rng.normal(size=(2, 4))
    made = by_parameters(slopes, readings) @ np.concatenate((gain, offset))
    wanted = np.einsum("tkn,tn->tk", slopes, gain * readings + offset)
    np.testing.assert_allclose(made, wanted)
    shared = by_parameters(slopes[0], readings)
    np.testing.assert_allclose(shared[3], by_parameters(slopes[0], readings[3]))
