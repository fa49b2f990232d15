from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from shoecal_core.arrays import FloatArray
from shoecal_core.simulation.floor import MIN_LOAD, floor_truth

metres = st.floats(-0.3, 0.3)
newtons = st.floats(1.0, 60.0)


def turn(yaw: float) -> FloatArray:
    c, s = np.cos(yaw), np.sin(yaw)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def contact(force: FloatArray, place: FloatArray) -> FloatArray:
    return np.concatenate((force, np.zeros(3), place))


@given(
    st.tuples(metres, metres), st.tuples(metres, metres), st.floats(-3.0, 3.0),
    st.floats(-3.0, 3.0), newtons, newtons, st.tuples(metres, metres), st.tuples(metres, metres),
)  # fmt: skip
def test_vertical_forces_act_where_they_act(
    left: tuple[float, float], right: tuple[float, float], left_yaw: float, right_yaw: float,
    left_force: float, right_force: float, at_left: tuple[float, float],
    at_right: tuple[float, float],
) -> None:  # fmt: skip
    position = np.array([[*left, 0.0], [*right, 0.0]])
    rotation = np.array([turn(left_yaw), turn(right_yaw)])
    own = np.array([[*at_left, 0.0], [*at_right, 0.0]])
    place = position + np.einsum("fij,fj->fi", rotation, own)
    forces = np.array([[0.0, 0.0, left_force], [0.0, 0.0, right_force]])
    truth = floor_truth(np.array(list(map(contact, forces, place))), position, rotation)
    assert truth.foot_cop == pytest.approx(own[:, :2], abs=1e-9)
    assert truth.foot_grf == pytest.approx([left_force, right_force])
    world = (left_force * place[0] + right_force * place[1]) / (left_force + right_force)
    expected = rotation[0].T @ (world - position[0])
    assert truth.cop == pytest.approx(expected[:2], abs=1e-9)


def test_a_sideways_force_above_the_plane_moves_the_cop() -> None:
    force, height = np.array([3.0, -2.0, 30.0]), 0.02
    both = np.array([contact(force, np.array([0.0, 0.0, height])), np.zeros(9)])
    truth = floor_truth(both, np.zeros((2, 3)), np.tile(np.eye(3), (2, 1, 1)))
    # The line of action meets the plane where it came from.
    assert truth.cop == pytest.approx([-height * 3.0 / 30.0, height * 2.0 / 30.0])


def test_a_torque_moves_the_cop() -> None:
    wrench = np.array([0.0, 0.0, 20.0, 0.4, -0.6, 0.0, 0.01, 0.02, 0.0])
    truth = floor_truth(
        np.array([wrench, np.zeros(9)]), np.zeros((2, 3)), np.tile(np.eye(3), (2, 1, 1))
    )
    assert truth.cop == pytest.approx([0.01 + 0.6 / 20.0, 0.02 + 0.4 / 20.0])


def test_an_unloaded_foot_has_no_cop() -> None:
    light = contact(np.array([0.0, 0.0, 0.9 * MIN_LOAD]), np.zeros(3))
    heavy = contact(np.array([0.0, 0.0, 30.0]), np.zeros(3))
    rotation = np.tile(np.eye(3), (2, 1, 1))
    truth = floor_truth(np.array([light, heavy]), np.zeros((2, 3)), rotation)
    assert np.isnan(truth.foot_cop[0]).all()
    assert np.isfinite(truth.foot_cop[1]).all()
    assert np.isfinite(truth.cop).all()
    assert np.isnan(floor_truth(np.zeros((2, 9)), np.zeros((2, 3)), rotation).cop).all()


def test_many_instants_are_many_single_ones() -> None:
    rng = np.random.default_rng(1)
    contacts = rng.normal(size=(7, 2, 9))
    contacts[..., 2] += 20.0
    position = rng.normal(size=(7, 2, 3))
    rotation = np.array([[turn(yaw) for yaw in pair] for pair in rng.normal(size=(7, 2))])
    together = floor_truth(contacts, position, rotation)
    for index in range(7):
        one = floor_truth(contacts[index], position[index], rotation[index])
        assert together.cop[index] == pytest.approx(one.cop)
        assert together.foot_cop[index] == pytest.approx(one.foot_cop)
        assert together.foot_force[index] == pytest.approx(one.foot_force)
