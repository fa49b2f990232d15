"""Normal equations from moments, against the rows of the Jacobian that they never write down."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from core.calibration import synthetic
from core.sensing import shoes
from shoecal_core.calibration.moments import WrenchResiduals
from shoecal_core.calibration.residuals import (
    Normal,
    Problem,
    Weights,
    hanging_residuals,
    normal_equations,
    pack,
    residuals,
    zero_normal,
)
from shoecal_core.estimation import chunks
from shoecal_core.model.double_support import DoubleSupport
from shoecal_core.samples.stance import Stance, make_stance
from shoecal_core.sensing.shoe import Shoe
from shoecal_core.sensing.wrench import ChannelParameters

FloatArray = NDArray[np.float64]
BOTH = (True, True)
SENSOR = [0.01, 0.0, 0.1]
SHOES = {
    **{name: shoes.shoe(name) for name in shoes.NAMES},
    "six axes": shoes.made(shoes.six_axis(0, SENSOR) + shoes.six_axis(1, SENSOR)),
    "mixed": shoes.made(
        shoes.cells(0, [(0.1, 0.04), (0.1, -0.04), (-0.05, 0.0)]) + shoes.six_axis(1, SENSOR)
    ),
}
supports = st.builds(
    DoubleSupport, st.floats(-0.1, 0.1), st.floats(-0.2, -0.08), st.floats(-0.6, 0.6)
)


def stance(
    shoe: Shoe,
    truth: ChannelParameters,
    support: DoubleSupport,
    loaded: tuple[bool, bool],
    rng: np.random.Generator,
) -> Stance:
    """Samples that no body ever made, but that a vertical force of 20 to 100 N fits."""
    count, weight = 40, rng.uniform(20.0, 100.0)
    vertical = shoe.columns[:, 0] == 1.0
    outputs = rng.normal(size=(count, len(vertical)))
    outputs[:, vertical] += weight / vertical.sum()
    return make_stance(
        1,
        shoe,
        support,
        loaded,
        np.arange(count) / 20.0,
        (outputs - truth.offset) / truth.gain,
        weight + rng.normal(size=count),
        0.05 * rng.normal(size=(count, 2)),
    )


def from_rows(
    vector: FloatArray, stances: list[Stance], shoe: Shoe, weights: Weights
) -> tuple[FloatArray, FloatArray]:
    """Every residual of every stance, and their Jacobian."""
    errors, jacobians = [], []
    for each in stances:
        share = np.sqrt(weights.of_sample(each))
        rows = [residuals(vector, each, weights)]
        if each.hanging is not None:
            rows.append(hanging_residuals(vector, each, shoe, weights, float(each.force.mean())))
        errors += [share * row[0] for row in rows]
        jacobians += [share * row[1] for row in rows]
    return np.concatenate(errors), np.concatenate(jacobians)


def assert_same(normal: Normal, error: FloatArray, jacobian: FloatArray) -> None:
    """Each entry within what rounding makes of its column's size."""
    size = np.maximum(np.linalg.norm(jacobian, axis=0), 1e-300)
    assert normal.cost == pytest.approx(error @ error, rel=1e-11)
    np.testing.assert_allclose(
        normal.gradient / size,
        jacobian.T @ error / size,
        atol=1e-11 * float(np.linalg.norm(error)),
        rtol=0,
    )
    scale = np.outer(size, size)
    np.testing.assert_allclose(
        normal.hessian / scale, jacobian.T @ jacobian / scale, atol=1e-11, rtol=0
    )


@given(
    shoe=st.sampled_from(list(SHOES)),
    support=supports,
    loaded=st.lists(st.sampled_from([BOTH, (True, False), (False, True)]), min_size=1, max_size=3),
    unit=st.sampled_from([1e-6, 1.0, 1e3]),
    shift=st.floats(-1e3, 1e3),
    late=st.floats(-0.1, 0.1),
    chunk=st.sampled_from([1, 7, 40, 1024]),
    seed=st.integers(0, 2**32 - 1),
)
def test_the_sums_are_those_of_the_rows(
    shoe: str, support: DoubleSupport, loaded: list[tuple[bool, bool]], unit: float,
    shift: float, late: float, chunk: int, seed: int,
) -> None:  # fmt: skip
    """Load cells, torques, six axes; readings in any unit and far off zero; hanging feet."""
    pair = SHOES[shoe]
    rng = np.random.default_rng(seed)
    count = len(pair.channels)
    gain = unit * rng.uniform(0.5, 2.0, count) * rng.choice([-1.0, 1.0], count)
    truth = ChannelParameters(gain, shift * rng.uniform(-1.0, 1.0, count))
    stances = [stance(pair, truth, support, feet, rng) for feet in loaded]
    near = ChannelParameters(truth.gain, truth.offset + 0.3 * rng.normal(size=count))
    weights = Weights(force=0.3, cop=0.0025, correlation=rng.uniform(0.01, 3.0))
    vector = pack(near, late)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(chunks, "CHUNK", chunk)
        problem = Problem.of(stances, pair, weights)
        normal = problem.normal(vector)
        assert problem.cost(vector) == pytest.approx(normal.cost, rel=1e-12)
    assert_same(normal, *from_rows(vector, stances, pair, weights))


def test_the_problem_of_nothing() -> None:
    shoe = shoes.shoe("nao_shoe")
    truth = synthetic.truth(shoe, np.random.default_rng(0))
    weights = Weights(0.3, 0.0025, 2.0)
    vector = pack(truth, 0.0)
    empty = synthetic.stance(
        shoe, truth, synthetic.SUPPORTS[0], np.random.default_rng(0)
    ).part(slice(0, 0))  # fmt: skip
    for nothing in ([], [empty]):
        assert Problem.of(nothing, shoe, weights).cost(vector) == 0.0
        normal, none = normal_equations(vector, nothing, shoe, weights), zero_normal(17)
        np.testing.assert_array_equal(normal.gradient, none.gradient)
        np.testing.assert_array_equal(normal.hessian, none.hessian)


def test_products_and_pulled_rows_by_the_matrix() -> None:
    """Against dr/dw written out, sample by sample."""
    rng = np.random.default_rng(3)
    local = WrenchResiduals(
        rows=rng.normal(size=(2, 3, 5)),
        per_force=rng.normal(),
        per_moment=rng.normal(size=5),
        per_place=rng.normal(size=(2, 5)),
    )
    for k in range(5):
        (x, y), a = local.per_place[:, k], local.per_moment[k]
        matrix = np.array([[local.per_force, 0, 0], [-x, 0, -a], [-y, a, 0]])
        product = matrix.T @ matrix
        np.testing.assert_allclose(
            local.products()[:, k], [product[0, 0], product[0, 1], product[0, 2], product[1, 1]]
        )
        assert product[2, 2] == pytest.approx(product[1, 1])
        assert product[1, 2] == pytest.approx(0.0)
        np.testing.assert_allclose(local.pulled()[:, :, k], local.rows[:, :, k] @ matrix)


@given(step=st.sampled_from([2, 7, 39, 50]), seed=st.integers(0, 2**32 - 1))
def test_thinned_samples_count_for_those_left_out(step: int, seed: int) -> None:
    """Of samples that all are alike, any part says the same as the whole."""
    shoe = SHOES["nao_shoe"]
    rng = np.random.default_rng(seed)
    truth = synthetic.truth(shoe, rng)
    weights, vector = Weights(0.3, 0.0025, 2.0), pack(truth, 0.01) * 1.02
    alike = []
    for loaded in (BOTH, (True, False)):
        each = stance(shoe, truth, synthetic.SUPPORTS[1], loaded, rng)
        index = np.zeros(40, dtype=np.int64)
        alike.append(
            replace(
                each,
                readings=each.readings[index],
                force=each.force[index],
                cop=each.cop[index],
                cop_rate=each.cop_rate[index],
            )
        )
    problem = Problem.of(alike, shoe, weights)
    thinned = problem.thinned(step)
    assert problem.samples == 3 * 40  # the hanging foot's samples are another term
    assert thinned.samples == 3 * -(-40 // step)
    assert thinned.cost(vector) == pytest.approx(problem.cost(vector), rel=1e-9)
    one, other = problem.normal(vector), thinned.normal(vector)
    np.testing.assert_allclose(one.hessian, other.hessian, rtol=1e-9)
    np.testing.assert_allclose(one.gradient, other.gradient, rtol=1e-9)


def test_samples_may_lie_anywhere_in_memory() -> None:
    """Every third sample, in another order of axes: what counts are the values."""
    shoe = shoes.shoe("odd_shoe")
    rng = np.random.default_rng(4)
    truth = synthetic.truth(shoe, rng)
    whole = synthetic.stance(shoe, truth, synthetic.SUPPORTS[1], rng)
    strided = whole.part(slice(None, None, 3))
    strided = replace(strided, readings=np.asfortranarray(strided.readings))
    copied = replace(
        strided,
        readings=np.ascontiguousarray(strided.readings),
        cop=strided.cop.copy(),
        cop_rate=strided.cop_rate.copy(),
        force=strided.force.copy(),
    )
    weights, vector = Weights(0.3, 0.0025, 2.0), pack(truth, 0.01) * 1.05
    one, other = (normal_equations(vector, [run], shoe, weights) for run in (strided, copied))
    np.testing.assert_array_equal(one.hessian, other.hessian)
    np.testing.assert_array_equal(one.gradient, other.gradient)
