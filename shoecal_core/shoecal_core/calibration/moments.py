"""Normal equations of affine channels, from weighted moments of their readings.

Residuals r that depend on the readings through the wrench w = A' f + b alone, with outputs
f_i = c_i S_i + d_i, have the derivatives A_i (dr/dw)' S_i by the gain and A_i (dr/dw)' by the
offset of channel i. With S~ = (S, 1), all of J'J and J'r is therefore made of the sums
    sum (dr/dw)' (dr/dw) S~ S~'    and    sum (dr/dw)' r S~
over the samples: small matrices, and no row of J is ever written down.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
_PRODUCTS = 4
_SLOPES = 6
_SERIAL = 2**18
"""Multiplications up to which a BLAS keeps to one thread; for matrices as small as these the
others cost more than they give."""


@dataclass(frozen=True)
class WrenchResiduals:
    """Residuals r = (r_F, r_Cx, r_Cy) of m samples and their derivatives.

    By the wrench w = (F, Mx, My) these are

        dr/dw = [[1 / s_F, 0, 0], [-p_x, 0, -a], [-p_y, a, 0]]

    Attributes:
        rows: (2, 3, m) r, and its derivative by the time offset.
        per_force: 1 / s_F.
        per_moment: (m,) a.
        per_place: (2, m) p.
    """

    rows: FloatArray
    per_force: float
    per_moment: FloatArray
    per_place: FloatArray

    def pulled(self) -> FloatArray:
        """(2, 3, m) (dr/dw)' times the rows."""
        force, x, y = self.rows.transpose(1, 0, 2)
        p_x, p_y = self.per_place
        pulled = np.empty_like(self.rows)
        pulled[:, 0] = self.per_force * force - p_x * x - p_y * y
        pulled[:, 1] = self.per_moment * y
        pulled[:, 2] = -self.per_moment * x
        return pulled

    def products(self) -> FloatArray:
        """(4, m) what is not zero of (dr/dw)' (dr/dw): F F, F Mx, F My, and Mx Mx, as My My."""
        a = self.per_moment
        p_x, p_y = self.per_place
        products = np.empty((_PRODUCTS, len(a)))
        products[0] = self.per_force**2 + p_x * p_x + p_y * p_y
        products[1] = -a * p_y
        products[2] = a * p_x
        products[3] = a * a
        return products


class WrenchMoments:
    """The sums over many samples, added a chunk at a time.

    Args:
        columns: (n, 3) what one unit of each output adds to the wrench.
    """

    def __init__(self, columns: FloatArray) -> None:
        self._columns = columns
        rows = len(columns) + 1
        self._sums = np.zeros((rows, _PRODUCTS * rows + _SLOPES))
        self._squares = np.zeros((2, 2))
        self._slice = max(1, _SERIAL // self._sums.size)

    def add(self, extended: FloatArray, residuals: WrenchResiduals) -> None:
        """Add m samples with S~ (n + 1, m) = `extended`."""
        channels, count = extended.shape
        weighted = np.empty((self._sums.shape[1], count))
        grams = weighted[:-_SLOPES].reshape(_PRODUCTS, channels, count)
        np.multiply(residuals.products()[:, None, :], extended, out=grams)
        weighted[-_SLOPES:] = residuals.pulled().reshape(_SLOPES, count)
        for start in range(0, count, self._slice):
            part = slice(start, start + self._slice)
            self._sums += extended[:, part] @ weighted[:, part].T
        rows = residuals.rows.reshape(2, -1)
        self._squares += rows @ rows.T

    @property
    def cost(self) -> float:
        """Sum of squared residuals."""
        return float(self._squares[0, 0])

    def gradient(self) -> FloatArray:
        """(2n + 1,) J'r by gains, offsets and time offset."""
        return np.append(self._first(self._sums[:, -_SLOPES:-3]), self._squares[0, 1])

    def hessian(self) -> FloatArray:
        """(2n + 1, 2n + 1) J'J."""
        f, mx, my = self._columns.T
        pairs = np.stack(
            (
                np.outer(f, f),
                np.outer(f, mx) + np.outer(mx, f),
                np.outer(f, my) + np.outer(my, f),
                np.outer(mx, mx) + np.outer(my, my),
            )
        )
        rows = len(self._sums)
        grams = self._sums[:, :-_SLOPES].reshape(rows, _PRODUCTS, rows).transpose(1, 0, 2)
        gains = (pairs * grams[:, :-1, :-1]).sum(axis=0)
        mixed = (pairs * grams[:, :-1, -1:]).sum(axis=0)
        offsets = (pairs * grams[:, -1:, -1:]).sum(axis=0)
        late = self._first(self._sums[:, -3:])[:, None]
        n = rows - 1
        return np.block(
            [
                [gains, mixed, late[:n]],
                [mixed.T, offsets, late[n:]],
                [late.T, self._squares[1:, 1:]],
            ]
        )

    def _first(self, sums: FloatArray) -> FloatArray:
        """(2n,) by gains and offsets, of sums of pulled rows (n + 1, 3)."""
        gains = (self._columns * sums[:-1]).sum(axis=1)
        return np.concatenate((gains, self._columns @ sums[-1]))
