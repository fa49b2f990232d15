"""The CoP correction (paper, eqs. 4 and 5)."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from core.shoe import shoes
from shoecal_core.arrays import FloatArray
from shoecal_core.errors import ShapeError, ShoecalError
from shoecal_core.shoe.correction import (
    CopCorrection,
    check_corrections,
    corrected_channels,
    features,
)
from shoecal_core.shoe.sensing import Sensing
from shoecal_core.shoe.wrench import ChannelParameters

ANYWHERE = np.array([[-1e9, -1e9], [1e9, 1e9]])


def make(x: FloatArray, y: FloatArray, **changes: object) -> CopCorrection:
    k = len(x) - 4
    parts = {"cop_range": ANYWHERE, "output_range": np.array([[-1e9] * k, [1e9] * k])} | changes
    return CopCorrection(foot=0, x=x, y=y, **parts)  # type: ignore[arg-type]


def test_by_hand() -> None:
    x = np.array([2.0, 0.1, 0.3, 0.001, 1e-4, 2e-4, 3e-4, 4e-4])
    y = np.array([5.0, 0.2, 0.4, 0.002, -1e-4, 1e-4, -2e-4, 2e-4])
    raw, outputs = np.array([0.05, -0.02]), np.array([10.0, 20.0, 30.0, 40.0])
    # x: 2 * 0.0025 + 0.1 * 0.05 + 0.3 * -0.02 + 0.001 + (1 + 4 + 9 + 16) 1e-3 = 0.035
    # y: 5 * 0.0004 + 0.2 * -0.02 + 0.4 * 0.05 + 0.002 + (-1 + 2 - 6 + 8) 1e-3 = 0.023
    np.testing.assert_allclose(
        make(x, y).correct(raw.tolist(), outputs.tolist()),
        [0.05 + 0.035, -0.02 + 0.023],
        atol=1e-15,
    )


def numbers(*shape: int) -> st.SearchStrategy[FloatArray]:
    return arrays(np.float64, shape, elements=st.floats(-2.0, 2.0))


@given(numbers(7), numbers(7), numbers(5, 2), numbers(5, 3))
def test_by_the_paper_s_sums(x: FloatArray, y: FloatArray, raw: FloatArray, f: FloatArray) -> None:
    found = np.stack(make(x, y).correct(list(raw.T), list(f.T)), axis=1)
    (a1, a2, a3, a4, *m), (b1, b2, b3, b4, *n) = x, y
    for k in range(5):
        p0x, p0y = raw[k]
        dx = a1 * p0x**2 + a2 * p0x + a3 * p0y + a4 + sum(m[i] * f[k, i] for i in range(3))
        dy = b1 * p0y**2 + b2 * p0y + b3 * p0x + b4 + sum(n[i] * f[k, i] for i in range(3))
        np.testing.assert_allclose(found[k], [p0x + dx, p0y + dy], atol=1e-12)


@given(*[numbers(8)] * 4, st.floats(-3.0, 3.0), numbers(2), numbers(4))
def test_linear_in_its_parameters(
    x1: FloatArray, y1: FloatArray, x2: FloatArray, y2: FloatArray, scale: float,
    raw: FloatArray, outputs: FloatArray,
) -> None:  # fmt: skip
    def shift(x: FloatArray, y: FloatArray) -> FloatArray:
        return np.array(make(x, y).correct(raw.tolist(), outputs.tolist())) - raw

    np.testing.assert_allclose(
        shift(x1 + scale * x2, y1 + scale * y2), shift(x1, y1) + scale * shift(x2, y2), atol=1e-11
    )


def test_no_correction_of_zeros_and_any_leading_shape() -> None:
    rng = np.random.default_rng(0)
    raw, outputs = rng.normal(size=(2, 2, 3)), rng.normal(size=(4, 2, 3))
    none = make(np.zeros(8), np.zeros(8))
    np.testing.assert_array_equal(none.correct(list(raw), list(outputs)), raw)
    one = make(rng.normal(size=8), rng.normal(size=8))
    whole = np.array(one.correct(list(raw), list(outputs)))
    for index in np.ndindex(2, 3):
        here = (slice(None), *index)
        np.testing.assert_allclose(
            whole[here], one.correct(raw[here].tolist(), outputs[here].tolist())
        )
    rows = features(np.moveaxis(raw, 0, -1), np.moveaxis(outputs, 0, -1))
    for axis, (row, line) in enumerate(zip(rows, (one.x, one.y), strict=True)):
        assert row.shape == (2, 3, 8)
        np.testing.assert_allclose(raw[axis] + row @ line, whole[axis])


def test_extrapolation_beyond_places_and_loads() -> None:
    one = make(
        np.zeros(6), np.zeros(6),
        cop_range=np.array([[-0.02, -0.01], [0.05, 0.03]]),
        output_range=np.array([[0.0, 1.0], [30.0, 20.0]]),
    )  # fmt: skip
    inside = [
        ([0.0, 0.0], [10.0, 10.0]),
        ([-0.02, -0.01], [0.0, 1.0]),
        ([0.05, 0.03], [30.0, 20.0]),
    ]
    outside = [
        ([-0.021, 0.0], [10.0, 10.0]),
        ([0.0, 0.031], [10.0, 10.0]),
        ([0.0, 0.0], [-0.1, 10.0]),
        ([0.0, 0.0], [10.0, 20.1]),
    ]
    raw, outputs = (np.array(part) for part in zip(*inside, *outside, strict=True))
    assert (
        np.asarray(one.extrapolates(list(raw.T), list(outputs.T))).tolist()
        == [False] * 3 + [True] * 4
    )


@pytest.mark.parametrize(
    ("part", "value", "named"),
    [
        ("x", np.zeros(3), "correction x"),
        ("x", np.zeros((6, 1)), "correction x"),
        ("y", np.zeros(7), "correction y"),
        ("cop_range", np.zeros((2, 3)), "correction cop_range"),
        ("output_range", np.zeros((2, 3)), "correction output_range"),
        ("y", np.array([0.0, 0.0, np.nan, 0.0, 0.0, 0.0]), "not finite"),
        ("output_range", np.array([[0.0, 0.0], [1.0, np.inf]]), "not finite"),
        ("foot", 2, "left, right"),
    ],
)
def test_parts_that_do_not_fit_are_refused(part: str, value: object, named: str) -> None:
    parts: dict[str, object] = {
        "foot": 0, "x": np.zeros(6), "y": np.zeros(6),
        "cop_range": np.zeros((2, 2)), "output_range": np.zeros((2, 2)),
    }  # fmt: skip
    CopCorrection(**parts)  # type: ignore[arg-type]
    with pytest.raises(ShoecalError, match=named):
        CopCorrection(**parts | {part: value})  # type: ignore[arg-type]


def test_every_cell_has_a_term() -> None:
    shoe = shoes.shoe("odd_shoe")
    for foot in (0, 1):
        np.testing.assert_array_equal(corrected_channels(shoe, foot), shoe.of_foot(foot))


def test_a_six_axis_sensor_s_force_and_two_moments_have_a_term() -> None:
    origin = [0.01, 0.0, 0.1]
    shoe = shoes.made(shoes.six_axis(0, origin) + shoes.six_axis(1, origin))
    for foot in (0, 1):
        names = [shoe.names[i].split("/")[1] for i in corrected_channels(shoe, foot)]
        assert names == ["fz", "mx", "my"]
    x, y = np.arange(7.0) * 1e-3, np.zeros(7)
    one = make(x, y)
    check_corrections(shoe, [one])
    with pytest.raises(ShapeError, match="left foot"):
        check_corrections(shoe, [make(np.zeros(9), np.zeros(9))])
    # Sideways forces shift the raw CoP by the sensor's height, but have no term of their own.
    parameters = ChannelParameters(np.ones(10), np.zeros(10))
    readings = np.array([2.0, -1.0, 30.0, 0.3, -0.2] * 2)
    raw = Sensing(shoe, parameters).measure(readings).cop[0]
    found = Sensing(shoe, parameters, [one]).measure(readings).cop[0]
    np.testing.assert_allclose(found, one.correct(raw.tolist(), readings[2:5].tolist()))
