"""What a check of a motion finds: of every constraint the worst."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from shoecal_core.arrays import FloatArray
from shoecal_core.errors import ShoecalError

STILL = 1e-9
"""What is below it does not move, in any unit here."""


@dataclass(frozen=True)
class ConstraintMargin:
    """The worst of one constraint over a motion.

    Attributes:
        constraint: its name.
        unit: of value and limit.
        value: the worst.
        limit: that it must keep.
        excess: how far the value is beyond the limit; negative where it is kept.
        time: of the worst, from the motion's start [s].
        where: joint, capsules or foot; empty where there is nothing to report.
        rate: whether doing the same more slowly makes the value smaller.
    """

    constraint: str
    unit: str
    value: float
    limit: float
    excess: float
    time: float
    where: str
    rate: bool = False

    @property
    def kept(self) -> bool:
        """Whether the constraint holds throughout."""
        return self.excess <= 0.0

    def __str__(self) -> str:
        where = f" ({self.where})" if self.where else ""
        return (
            f"{self.constraint}{where} is {self.value:.4g} {self.unit} at {self.time:.2f} s, "
            f"limit {self.limit:.4g} {self.unit}"
        )


class CheckFailedError(ShoecalError):
    """A motion that violates a constraint.

    Attributes:
        findings: the violated ones.
    """

    def __init__(self, findings: tuple[ConstraintMargin, ...]) -> None:
        self.findings = findings
        listed = "; ".join(str(finding) for finding in findings)
        super().__init__(
            f"the motion violates: {listed}; it was not released. Choose another double support "
            "or larger margins"
        )


@dataclass(frozen=True)
class Report:
    """Every constraint's worst over a motion."""

    findings: tuple[ConstraintMargin, ...]

    @property
    def violated(self) -> tuple[ConstraintMargin, ...]:
        """Those whose constraint does not hold."""
        return tuple(finding for finding in self.findings if not finding.kept)

    @property
    def kept(self) -> bool:
        """Whether all constraints hold."""
        return not self.violated

    @property
    def too_fast(self) -> bool:
        """Whether it fails, and only by what doing the same more slowly makes smaller."""
        violated = self.violated
        return bool(violated) and all(finding.rate for finding in violated)

    def of(self, constraint: str) -> ConstraintMargin:
        """The finding of one constraint."""
        return next(found for found in self.findings if found.constraint == constraint)

    def require(self) -> None:
        """Raise where a constraint is violated.

        Raises:
            CheckFailedError: names each with its time and value.
        """
        if not self.kept:
            raise CheckFailedError(self.violated)


def worst(findings: Sequence[ConstraintMargin]) -> tuple[ConstraintMargin, ...]:
    """Of every constraint the finding that is farthest beyond its limit."""
    worst: dict[str, ConstraintMargin] = {}
    for finding in findings:
        known = worst.get(finding.constraint)
        if known is None or finding.excess > known.excess:
            worst[finding.constraint] = finding
    return tuple(worst.values())


def at_least(
    constraint: str,
    unit: str,
    values: FloatArray,
    limit: float | FloatArray,
    time: FloatArray,
    names: tuple[str, ...] = ("",),
    *,
    from_begin: bool = True,
    slack: float = 0.0,
) -> ConstraintMargin:
    """The worst of values (T, n) that must not fall below a limit.

    Where a motion begins outside of it, not below their own start less a slack. What is no number
    falls below any.
    """
    allowed = (
        np.minimum(limit, values[0] - slack) if from_begin else np.full(values.shape[1], limit)
    )
    above = np.where(np.isfinite(values), values - allowed, -np.inf)
    index, column = np.unravel_index(np.argmin(above), values.shape)
    value, bound = float(values[index, column]), float(allowed[column])
    excess = bound - value if np.isfinite(value) else np.inf
    return ConstraintMargin(
        constraint, unit, value, bound, excess, float(time[index]), names[column]
    )


def at_most(
    constraint: str,
    unit: str,
    values: FloatArray,
    limit: FloatArray | float,
    time: FloatArray,
    names: tuple[str, ...] = ("",),
    *,
    rate: bool = False,
) -> ConstraintMargin:
    """The worst of values (T, n) that must not exceed a limit, compared by their ratio.

    A limit of zero, as of joints without a motor, is kept by what does not move at all. What is no
    number exceeds any limit.
    """
    limits = np.broadcast_to(limit, values.shape)
    over = np.where(values > STILL, np.inf, 0.0)
    np.divide(values, limits, out=over, where=limits > 0.0)
    over[~np.isfinite(values)] = np.inf
    index, column = np.unravel_index(np.argmax(over), values.shape)
    value, bound = float(values[index, column]), float(limits[index, column])
    at, where = float(time[index]), names[column]
    excess = value - bound if np.isfinite(value) else np.inf
    return ConstraintMargin(constraint, unit, value, bound, excess, at, where, rate)
