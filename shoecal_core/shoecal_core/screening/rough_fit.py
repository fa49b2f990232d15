"""Gains and offsets for screening: linear, robust, and without a word about signs.

With the modelled wrench w on the right, F = W and (Mx, My) = W (c_y, -c_x), the equations
    sum_i A_i (g_i S_i + d_i) = w - b
are linear in gains and offsets. They are solved over blocks of all runs; blocks that do not fit
count less and less. A bias of a few per cent does no harm here, one bad run or cell would.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from shoecal_core.arrays import BoolArray, FloatArray
from shoecal_core.screening.blocks import Blocks
from shoecal_core.screening.noise import spread
from shoecal_core.screening.settings import CalibrationSettings
from shoecal_core.shoe.priors import TORQUE_LEVER_M
from shoecal_core.shoe.shoe import Shoe
from shoecal_core.shoe.wrench import ChannelParameters, at_cop, by_parameters

ROUNDS = 5
"""Times that the blocks are weighted again."""
FAR = 3.0
"""Blocks this many of their typical deviations off count half."""
LEAST_SPREAD = 0.2
"""Deviations are not taken as smaller than this, in the settings' standard deviations."""


@dataclass(frozen=True)
class NormalEquations:
    """What least squares need of one run: A'WA (2n, 2n), A'Wy (2n,), y'Wy, and 3 sum W."""

    product: FloatArray
    right: FloatArray
    square: float
    count: float


@dataclass(frozen=True)
class Equations:
    """One run's equations, every row divided by its standard deviation.

    Attributes:
        matrix: (3, B, 2n) of gains and offsets: the rows of F, Mx, My.
        target: (3, B).
        weight: (B,) how much of an independent block each one counts for.
    """

    matrix: FloatArray
    target: FloatArray
    weight: FloatArray

    def off(self, vector: FloatArray) -> FloatArray:
        """(3, B) what is left under a parameter vector (2n,)."""
        off: FloatArray = self.matrix @ vector - self.target
        return off

    def force_squares(self, vector: FloatArray) -> float:
        """Sum of squares that a parameter vector (2n,) leaves of the vertical force."""
        return float((self.weight * self.off(vector)[0] ** 2).sum())

    def with_columns(self, columns: FloatArray) -> Equations:
        """The same with further unknowns, whose columns (3, B, k) are whitened."""
        return replace(self, matrix=np.concatenate((self.matrix, columns), axis=2))

    def part(self, part: BoolArray) -> Equations:
        """Those of the blocks marked in `part` (B,)."""
        return Equations(self.matrix[:, part], self.target[:, part], self.weight[part])

    def sums(self) -> NormalEquations:
        """Over all blocks."""
        flat = self.matrix.reshape(-1, self.matrix.shape[-1])
        weighed = (self.matrix * self.weight[:, None]).reshape(flat.shape)
        return NormalEquations(
            weighed.T @ flat,
            weighed.T @ self.target.ravel(),
            float((self.target**2 * self.weight).sum()),
            3.0 * float(self.weight.sum()),
        )


@dataclass(frozen=True)
class RoughFit:
    """The solution.

    Attributes:
        vector: (2n,) gains, offsets.
        covariance: (2n, 2n).
        cost: sum of squares, prior included.
    """

    vector: FloatArray
    covariance: FloatArray
    cost: float

    @property
    def parameters(self) -> ChannelParameters:
        """Gains and offsets."""
        gain, offset = np.split(self.vector, 2)
        return ChannelParameters(gain, offset)


@dataclass(frozen=True)
class Statics:
    """Runs in double support, and their equations.

    Attributes:
        shoe: whose n channels they are.
        weight: of robot and shoes [N].
        settings: with the standard deviations.
        parts: blocks of each run, by number, in the order in which they were recorded.
        rows: the equations of each.
        information: (2n,) prior, of gains and offsets.
    """

    shoe: Shoe
    weight: float
    settings: CalibrationSettings
    parts: Mapping[int, Blocks]
    rows: Mapping[int, Equations]
    information: FloatArray

    @classmethod
    def of(
        cls, shoe: Shoe, parts: Mapping[int, Blocks], weight: float, settings: CalibrationSettings
    ) -> Statics:
        """Those of some runs' blocks."""
        rows = {run: equations(one, weight, settings) for run, one in parts.items()}
        return cls(shoe, weight, settings, parts, rows, prior(shoe, parts, weight, settings))

    @cached_property
    def robust(self) -> dict[int, Equations]:
        """The same equations; blocks that fit badly count less."""
        return reweighed(self.rows, self.information)

    @cached_property
    def fit(self) -> RoughFit:
        """The solution of these."""
        return solve(self.robust, self.information)

    def force_error(self, run: int, vector: FloatArray) -> FloatArray:
        """(B,) measured less expected vertical force of a run, by gains and offsets (2n,) [N]."""
        error: FloatArray = self.settings.force_std_n * self.rows[run].off(vector)[0]
        return error

    def trembling(self, run: int) -> float:
        """Standard deviation of a block's vertical force by the noise of a run's readings [N]."""
        part = self.parts[run]
        gain = self.fit.parameters.gain
        return float(np.linalg.norm(part.columns[:, 0] * gain * part.noise))

    def only(self, runs: Collection[int]) -> Statics:
        """Some of the runs, with the same prior."""
        parts = {run: one for run, one in self.parts.items() if run in runs}
        return replace(self, parts=parts, rows={run: self.rows[run] for run in parts})

    def without(self, runs: Collection[int]) -> Statics:
        """All but some of the runs, with the same prior."""
        return self.only([run for run in self.parts if run not in runs])

    def changed(self, change: Callable[[Blocks], Blocks]) -> Statics:
        """The same prior and other blocks: a function of those of each run."""
        parts = {run: change(one) for run, one in self.parts.items()}
        rows = {run: equations(one, self.weight, self.settings) for run, one in parts.items()}
        return replace(self, parts=parts, rows=rows)


def equations(blocks: Blocks, weight: float, settings: CalibrationSettings) -> Equations:
    """Equations of one run's blocks.

    Args:
        weight: of robot and shoes [N].
    """
    target = at_cop(np.full(len(blocks.time), weight), blocks.cop) - blocks.base
    std = deviations(weight, settings)
    matrix = by_parameters(blocks.columns.T / std[:, None], blocks.readings)
    return Equations(
        matrix=matrix.swapaxes(0, 1),
        target=target.T / std[:, None],
        weight=np.full(len(blocks.time), min(1.0, blocks.period / settings.correlation_s)),
    )


def moments_off(rows: Iterable[Equations], vector: FloatArray) -> float:
    """Root mean square of both moments' errors together, by gains and offsets (2n,), in standard
    deviations.
    """
    off = np.concatenate([one.off(vector)[1:] for one in rows], axis=1)
    return float(np.sqrt((off**2).sum(axis=0).mean()))


def deviations(weight: float, settings: CalibrationSettings) -> FloatArray:
    """(3,) standard deviations of F, Mx, My under a weight [N, N m, N m]."""
    moment = settings.cop_std_m * weight
    return np.array([settings.force_std_n, moment, moment])


def prior(
    shoe: Shoe, blocks: Mapping[int, Blocks], weight: float, settings: CalibrationSettings
) -> FloatArray:
    """(2n,) information on gains and offsets: a channel swings by no more than the weight."""
    swing = np.ptp(np.concatenate([one.readings for one in blocks.values()]), axis=0)
    unit = np.where(shoe.torque, TORQUE_LEVER_M, 1.0)
    return np.concatenate(((swing / (weight * unit)) ** 2, (settings.offset_std_n * unit) ** -2.0))


def solve(runs: Mapping[int, Equations], information: FloatArray) -> RoughFit:
    """Least squares over some runs, the blocks weighted as they are; prior information (2n,)."""
    return solve_sums([run.sums() for run in runs.values()], information)


def solve_sums(runs: Sequence[NormalEquations], information: FloatArray) -> RoughFit:
    """The same from the runs' sums, with prior information (2n,)."""
    matrix = np.diag(information) + np.sum([run.product for run in runs], axis=0)
    right = np.sum([run.right for run in runs], axis=0)
    # Gains are some hundred times offsets: scaled, or a cell that never moved is not seen.
    scale = 1.0 / np.sqrt(np.maximum(np.diag(matrix), 1e-30))
    inverse = np.linalg.pinv(matrix * np.outer(scale, scale), hermitian=True)
    covariance = inverse * np.outer(scale, scale)
    vector = covariance @ right
    cost = sum(run.square for run in runs) - float(right @ vector)
    return RoughFit(vector, covariance, cost)


def reweighed(runs: Mapping[int, Equations], information: FloatArray) -> dict[int, Equations]:
    """The same equations; blocks that fit badly with prior information (2n,) count less."""
    first = {number: run.weight for number, run in runs.items()}
    runs = dict(runs)
    for _ in range(ROUNDS):
        fit = solve(runs, information)
        off = {number: run.off(fit.vector) for number, run in runs.items()}
        everything = np.concatenate(list(off.values()), axis=1)
        typical = np.maximum(spread(everything.T), LEAST_SPREAD)[:, None]
        for number, run in runs.items():
            far = np.max(np.abs(off[number]) / typical, axis=0) / FAR
            runs[number] = replace(run, weight=first[number] / (1.0 + far**2))
    return runs
