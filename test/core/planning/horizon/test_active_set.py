"""Small programs against a method that needs no guess."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest

from shoecal_core.arrays import FloatArray
from shoecal_core.planning.horizon.active_set import active_set_solution

SIZE, ROWS = 8, 20
Drawn = tuple[FloatArray, FloatArray, FloatArray, FloatArray, FloatArray]


def drawn(seed: int) -> Drawn:
    """A convex program that zero satisfies; some rows have one bound, some none."""
    rng = np.random.default_rng(seed)
    factor = rng.normal(size=(SIZE, SIZE))
    matrix = rng.normal(size=(SIZE, ROWS))
    low, high = -rng.uniform(0.0, 1.0, ROWS), rng.uniform(0.0, 1.0, ROWS)
    low[:5], high[3:7] = -np.inf, np.inf
    return factor @ factor.T + np.eye(SIZE), 5.0 * rng.normal(size=SIZE), matrix, low, high


def known(program: Drawn) -> tuple[FloatArray, FloatArray]:
    hessian, gradient, matrix, low, high = program
    shapes = {"h": ca.Sparsity.dense(SIZE, SIZE), "a": ca.Sparsity.dense(ROWS, SIZE)}
    solver = ca.conic("known", "daqp", shapes)
    found = solver(h=hessian, g=gradient, a=matrix.T, lba=low, uba=high)
    return np.array(found["x"]).ravel(), np.array(found["lam_a"]).ravel()


@pytest.mark.parametrize("seed", range(10))
def test_the_right_guess_is_confirmed(seed: int) -> None:
    program = drawn(seed)
    expected, prices = known(program)
    solution = active_set_solution(*program, np.sign(prices), 1e-9)
    assert solution is not None
    np.testing.assert_allclose(solution[0], expected, atol=1e-9)
    np.testing.assert_allclose(solution[1], prices, atol=1e-8)


def test_wrong_guesses_are_put_right_or_given_up() -> None:
    rng, settled = np.random.default_rng(1), 0
    for seed in range(40):
        program = drawn(seed)
        expected, prices = known(program)
        active = np.sign(prices)
        active[rng.integers(7, ROWS)] = rng.integers(-1, 2)
        solution = active_set_solution(*program, active, 1e-9)
        if solution is not None:
            settled += 1
            np.testing.assert_allclose(solution[0], expected, atol=1e-8)
    assert settled >= 15


def test_rows_that_depend_on_each_other() -> None:
    hessian, gradient, matrix, low, high = drawn(0)
    matrix[:, 8] = matrix[:, 7]
    active = np.zeros(ROWS)
    active[7:9] = 1.0
    solution = active_set_solution(hessian, gradient, matrix, low, high, active, 1e-9)
    if solution is not None:
        expected, _ = known((hessian, gradient, matrix, low, high))
        np.testing.assert_allclose(solution[0], expected, atol=1e-8)


def test_not_convex() -> None:
    _, gradient, matrix, low, high = drawn(0)
    assert (
        active_set_solution(-np.eye(SIZE), gradient, matrix, low, high, np.zeros(ROWS), 1e-9)
        is None
    )
