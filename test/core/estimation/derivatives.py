"""One checker of derivatives for all functions that have some."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from shoecal_core.arrays import FloatArray


def numerical_jacobian(
    function: Callable[[FloatArray], FloatArray], at: FloatArray, step: FloatArray
) -> FloatArray:
    """(m, p) derivative of values (m,) by central differences, exact for cubics."""
    columns = []
    for index, width in enumerate(step):

        def along(times: float, index: int = index, width: float = width) -> FloatArray:
            moved = at.copy()
            moved[index] += times * width
            return function(moved)

        near, far = along(1.0) - along(-1.0), along(2.0) - along(-2.0)
        columns.append((8.0 * near - far) / (12.0 * width))
    return np.stack(columns, axis=-1)


def assert_jacobian(
    function: Callable[[FloatArray], FloatArray],
    jacobian: FloatArray,
    at: FloatArray,
    *,
    relative_step: float = 1e-4,
    tolerance: float = 1e-8,
) -> None:
    """Compare a Jacobian (m, p) with differences, each column against its own size."""
    step = relative_step * np.maximum(np.abs(at), 1e-2)
    expected = numerical_jacobian(function, at, step)
    assert jacobian.shape == expected.shape
    size = np.maximum(np.abs(expected).max(axis=0), 1e-12)
    np.testing.assert_allclose(jacobian / size, expected / size, atol=tolerance)
