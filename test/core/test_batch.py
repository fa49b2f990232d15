"""Batches are their functions, sample by sample."""

from __future__ import annotations

import logging
from pathlib import Path

import casadi as ca
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as npst
from numpy.typing import NDArray

from core.compile_cache import libraries
from shoecal_core import batch_source
from shoecal_core.batch import LEAST, Batch
from shoecal_core.errors import ShapeError

FloatArray = NDArray[np.float64]


def everything() -> ca.Function:
    """One output for each operation that a batch knows."""
    x, y, z = ca.SX.sym("x"), ca.SX.sym("y"), ca.SX.sym("z")
    outputs: list[ca.SX | float] = [
        x + y, x - y, x * y, x / y, -x, 1.0 / y, x * x, 2.0 * x, ca.fabs(x),
        x < y, x <= y, ca.eq(x, y), ca.ne(x, y), ca.logic_not(x), ca.logic_and(x, y),
        ca.logic_or(x, y), ca.if_else(x < y, z, 3.0), ca.fmin(x, y), ca.fmax(x, y),
        ca.sqrt(x), ca.atan(x), ca.atan2(x, y), ca.asin(x), ca.acos(x),
        ca.sin(x), ca.cos(x), ca.sin(y) * ca.cos(y + z), x, 0.25,
    ]  # fmt: skip
    return ca.Function("everything", [ca.vertcat(x, y, z)], [ca.densify(ca.vertcat(*outputs))])


FUNCTION = everything()
NUMBERS = st.floats() | st.floats(-10.0, 10.0) | st.sampled_from([0.0, -0.0, 1.0])


def interpreted(function: ca.Function, samples: FloatArray) -> FloatArray:
    return np.array([np.array(function(row)).ravel() for row in samples])


@given(npst.arrays(np.float64, st.tuples(st.integers(1, 20), st.just(3)), elements=NUMBERS))
def test_values_are_those_of_the_function(samples: FloatArray) -> None:
    values = Batch(FUNCTION, least=1)(samples)
    expected = interpreted(FUNCTION, samples)
    np.testing.assert_allclose(values, expected, rtol=1e-14, atol=4e-16)


@pytest.mark.parametrize("length", [1, 3, 10])
def test_parts_of_any_length(
    monkeypatch: pytest.MonkeyPatch, length: int, library_cache: Path
) -> None:
    monkeypatch.setattr(batch_source, "_PART", length)
    samples = np.random.default_rng(length).uniform(0.1, 1.0, (10, 3))
    values = Batch(FUNCTION, least=1)(samples)
    np.testing.assert_allclose(values, interpreted(FUNCTION, samples), rtol=1e-15)
    assert len(libraries(library_cache)) == 1


def test_a_long_function_in_many_parts() -> None:
    """Values from far back are used again, registers in between for others."""
    x = ca.SX.sym("x", 3)
    terms = [x[0], x[1], x[2]]
    for index in range(600):
        early, late = terms[index // 3], terms[-1 - index % 3]
        terms.append(ca.sin(early) * ca.cos(late) + 0.5 * terms[index // 2] * late)
    function = ca.Function("long", [x], [ca.vertcat(*terms[::20])])
    samples = np.random.default_rng(0).uniform(-1.0, 1.0, (10, 3))
    values = Batch(function, least=1)(samples)
    np.testing.assert_allclose(values, interpreted(function, samples), rtol=1e-12, atol=1e-14)


def test_a_function_too_large_for_the_stack(
    library_cache: Path, caplog: pytest.LogCaptureFixture
) -> None:
    x = ca.SX.sym("x", 1)
    batch = Batch(ca.Function("huge", [x], [ca.repmat(2.0 * x, 10_000)]), least=1)
    np.testing.assert_array_equal(batch(np.ones((1, 1))), np.full((1, 10_000), 2.0))
    assert "'huge' is too large" in caplog.text


def test_sine_and_cosine_to_rounding() -> None:
    x = ca.SX.sym("x", 1)
    batch = Batch(ca.Function("turn", [x], [ca.vertcat(ca.sin(x), ca.cos(x))]), least=1)
    quarters = np.arange(-1000, 1001) * np.pi / 4.0
    angles = np.concatenate(
        [quarters, np.nextafter(quarters, 1e3), np.linspace(-7.0, 7.0, 20001)]
        + [sign * np.geomspace(1e-300, 1e300, 5001) for sign in (-1.0, 1.0)]
    )
    values = batch(angles[:, None])
    np.testing.assert_allclose(values[:, 0], np.sin(angles), rtol=4e-16, atol=1e-17)
    np.testing.assert_allclose(values[:, 1], np.cos(angles), rtol=4e-16, atol=1e-17)


@pytest.mark.parametrize("count", [0, 1, 7, 8, 9, 16, 23])
def test_blocks_and_parts_of_one(count: int) -> None:
    samples = np.random.default_rng(count).uniform(0.1, 1.0, (count, 3))
    values = Batch(FUNCTION, least=0)(samples)
    assert values.shape == (count, FUNCTION.size1_out(0))
    if count:
        np.testing.assert_allclose(values, interpreted(FUNCTION, samples), rtol=1e-15)


def test_samples_in_any_order_of_memory() -> None:
    batch = Batch(FUNCTION, least=1)
    samples = np.random.default_rng(0).uniform(0.1, 1.0, (20, 6))
    expected = batch(np.ascontiguousarray(samples[::2, ::2]))
    np.testing.assert_array_equal(batch(samples[::2, ::2]), expected)
    np.testing.assert_array_equal(batch(np.asfortranarray(samples[::2, ::2])), expected)


def test_few_samples_are_interpreted(library_cache: Path) -> None:
    batch = Batch(FUNCTION)
    samples = np.random.default_rng(0).uniform(0.1, 1.0, (LEAST, 3))
    few = batch(samples[:-1])
    assert libraries(library_cache) == []
    many = batch(samples)
    assert len(libraries(library_cache)) == 1
    np.testing.assert_allclose(many[:-1], few, rtol=1e-15, atol=1e-15)
    np.testing.assert_array_equal(batch(samples[:-1]), few)


def test_without_a_compiler(
    library_cache: Path, caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PATH", "")
    samples = np.random.default_rng(0).uniform(0.1, 1.0, (20, 3))
    batch = Batch(FUNCTION, least=1)
    with caplog.at_level(logging.WARNING):
        np.testing.assert_allclose(batch(samples), interpreted(FUNCTION, samples), rtol=1e-15)
        batch(samples)
    assert len(caplog.messages) == 1


@pytest.mark.parametrize("graph", [False, True])
def test_functions_that_batches_do_not_know(
    library_cache: Path, caplog: pytest.LogCaptureFixture, *, graph: bool
) -> None:
    x = ca.SX.sym("x", 2)
    function = ca.Function("unknown", [x], [ca.erf(x)])
    if graph:
        m = ca.MX.sym("x", 2)
        function = ca.Function("unknown", [m], [function(m)])
    batch = Batch(function, least=1)
    np.testing.assert_array_equal(batch(np.zeros((2, 2))), np.zeros((2, 2)))
    assert "'unknown'" in caplog.text


def test_samples_of_another_shape() -> None:
    for shape in ((3,), (4, 2), (1, 4, 3)):
        with pytest.raises(ShapeError, match=r"expected shape \(T, 3\)"):
            Batch(FUNCTION)(np.zeros(shape))
