"""The baseline in fewer columns: of those that rows cannot tell apart, what they add together.

A family of tolerance errors, x ~ N(0, level^2 D), adds A x to the rows, and A has far more columns
than directions in which it exceeds the noise. With the eigenvectors V of D^1/2 A' W A D^1/2 (W the
rows' precision at their least variance) it adds A D^1/2 V z, z ~ N(0, level^2): as many columns as
eigenvalues matter. Along all others nothing is learned: they keep their mean of zero.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from shoecal_core.arrays import FloatArray, IntArray
from shoecal_core.diagnosis.rows import Rows, at_levels

LEAST = 0.02
"""Standard deviations of all rows together by which a direction can move them: one that moves them
by less changes a logarithm of evidence by less than 1e-3."""
LEAST_MODEL = 0.1
"""Of what a model usually lacks, what it lacks at least."""


@dataclass(frozen=True)
class Basis:
    """Unknowns z (q,) in place of the baseline's (p,).

    Attributes:
        columns: (R, q). group: (R,) of the rows, among G.
        precision: (q,) of the priors, at level 1.
        family: (q,) of tolerance errors; -1 for what belongs to none.
        parts: of the baseline's columns that are replaced, which, and (m, k) what k unknowns are.
        kept: columns of the baseline that stand as they are, the first ones.
        count: p.
    """

    columns: FloatArray
    group: IntArray
    precision: FloatArray
    family: IntArray
    parts: tuple[tuple[IntArray, FloatArray], ...]
    kept: int
    count: int

    def whole(self, unknowns: FloatArray) -> FloatArray:
        """(p,) of the baseline, of unknowns (q, ...); what comes after them is left out."""
        found = np.zeros(self.count)
        found[: self.kept] = unknowns[: self.kept]
        at = self.kept
        for own, turned in self.parts:
            found[own] = turned @ unknowns[at : at + turned.shape[1]]
            at += turned.shape[1]
        return found

    def reduced(self, base: FloatArray) -> FloatArray:
        """(R, q) of the baseline's columns (R, p) on whatever rows."""
        parts = [base[:, own] @ turned for own, turned in self.parts]
        return np.hstack([base[:, : self.kept], *parts])

    def prior(self, levels: FloatArray) -> FloatArray:
        """(q,) precision where families are at these levels (F,)."""
        return at_levels(self.precision, self.family, levels)

    def normal(self, weight: FloatArray) -> FloatArray:
        """(q, q) normal matrix of the columns under weights (G,), its lower triangle alone."""
        count = self.columns.shape[1]
        found = np.zeros(count * count)
        found[self._triangle] = weight @ self._normals
        return found.reshape(count, count)

    def products(self, values: FloatArray) -> FloatArray:
        """(G, q + m, m) of the columns and of values (R, m) with the values, by group.

        So weights may change, and rows need not be gone through again.
        """
        count, order = self.columns.shape[1], self._order
        found = np.empty((len(order), count + values.shape[1], values.shape[1]))
        for group, (rows, own) in enumerate(zip(order, self._by_group, strict=True)):
            here = values[rows]
            found[group, :count], found[group, count:] = own.T @ here, here.T @ here
        return found

    @cached_property
    def _normals(self) -> FloatArray:
        """(G, q (q + 1) / 2) lower triangles of the normal matrix, by group."""
        return np.array([(own.T @ own).ravel()[self._triangle] for own in self._by_group])

    @cached_property
    def _order(self) -> list[IntArray]:
        """Rows of each group."""
        changes = np.cumsum(np.bincount(self.group))[:-1]
        return np.split(np.argsort(self.group, kind="stable"), changes)

    @cached_property
    def _by_group(self) -> list[FloatArray]:
        """The columns' rows of each group."""
        return [self.columns[rows] for rows in self._order]

    @cached_property
    def _triangle(self) -> IntArray:
        """Places of the lower triangle in a matrix (q, q) that is laid out flat."""
        return np.flatnonzero(np.tri(self.columns.shape[1], dtype=bool))


def make_basis(rows: Rows, kept: int, withheld: Rows | None = None) -> Basis:
    """Reduce the baseline.

    Args:
        rows: that are fitted.
        kept: columns at its beginning that stay as they are: gains and offsets.
        withheld: rows that are predicted, which may show what those do not.
    """
    weighted = [_weighted(one) for one in (rows, withheld) if one is not None]
    parts = []
    precision, families = [rows.precision[:kept]], [rows.family[:kept]]
    later = np.arange(len(rows.family)) >= kept
    for family in range(-1, len(rows.most_level)):
        own = np.flatnonzero(later & (rows.family == family))
        most = 1.0 if family < 0 else rows.most_level[family]
        std = rows.precision[own] ** -0.5
        each = [base[:, own] * (most * std) for base in weighted]
        values, vectors = np.linalg.eigh(np.sum([one.T @ one for one in each], axis=0))
        turned = std[:, None] * vectors[:, values > LEAST**2]
        parts.append((own, turned))
        precision.append(np.ones(turned.shape[1]))
        families.append(np.full(turned.shape[1], family))
    found = Basis(
        np.empty(0), rows.group, np.concatenate(precision), np.concatenate(families),
        tuple(parts), kept, len(rows.family),
    )  # fmt: skip
    return replace(found, columns=found.reduced(rows.base))


def _weighted(rows: Rows) -> FloatArray:
    """(R, p) of the baseline, over the least deviation that its rows may have."""
    least = rows.noise + LEAST_MODEL**2 * rows.smooth
    found: FloatArray = rows.base * (least[rows.group] ** -0.5)[:, None]
    return found
