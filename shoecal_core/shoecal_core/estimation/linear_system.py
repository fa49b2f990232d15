"""The joint fit's problem, linear about one set of gains and offsets."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from shoecal_core.arrays import BoolArray, FloatArray, IntArray
from shoecal_core.error_sources.as_built import of_shoes
from shoecal_core.error_sources.deviation import Deviation
from shoecal_core.error_sources.posterior import Posterior
from shoecal_core.error_sources.signal_model import SignalModel
from shoecal_core.error_sources.tolerances import Tolerances
from shoecal_core.estimation.known import KnownShoe, KnownZeros
from shoecal_core.shoe.wrench import ChannelParameters


@dataclass(frozen=True)
class LinearSystem:
    """The problem, linear about a signal model: columns times unknowns give the residuals.

    Unknowns are what gains and offsets are too large by, the time offset, deviations, nuisances.

    Attributes:
        signal_model: linearised about.
        deviations: k of them.
        std: (u,) prior standard deviation of each unknown.
        away: (u,) where the priors have their middle.
        columns: (u, T, s).
        scale: (T, s) by which signals are whitened; 0 for those that do not count.
        rows: (u, r) the same whitened, for r signals that are there.
        target: (r,) whitened residuals.
        runs: (r,) the run that each is of; -1 of what is known without a recording.
        own: (u,) which unknowns one run has by itself.
    """

    signal_model: SignalModel
    deviations: tuple[Deviation, ...]
    std: FloatArray
    away: FloatArray
    columns: FloatArray
    scale: FloatArray
    rows: FloatArray
    target: FloatArray
    runs: IntArray
    own: BoolArray

    @classmethod
    def at(
        cls,
        signal_model: SignalModel,
        fitted: BoolArray,
        guess: ChannelParameters,
        own_std: FloatArray,
        late: FloatArray,
        body: Sequence[Deviation],
        sample_std: FloatArray,
        tolerances: Tolerances,
        known: KnownShoe | None,
        zeros: KnownZeros | None,
    ) -> LinearSystem:
        """Linearise the problem.

        Args:
            signal_model: of all runs, about whose gains and offsets it is linear.
            fitted: (T,) samples that count.
            guess: gains and offsets that the priors are about.
            own_std: (2n + 1,) prior standard deviations of gains, offsets and time offset.
            late: (T, s) what one unit of the time offset adds.
            body: deviations of links, joints and soles.
            sample_std: (s,) of the signals.
            tolerances: of all other deviations.
            known: of the shoe, by a manual calibration.
            zeros: of a robot that hung.
        """
        own = len(own_std) - 1
        deviations = (*body, *of_shoes(signal_model, tolerances))
        nuisances = signal_model.nuisances
        columns = np.concatenate(
            (
                signal_model.baseline[:own],
                late[None],
                np.array([one.column for one in deviations]).reshape(-1, *late.shape),
                signal_model.baseline[own:],
            )
        )
        std = np.concatenate(
            (own_std, [one.std for one in deviations], [one.std for one in nuisances])
        )
        away = np.zeros(len(std))
        parameters = signal_model.parameters
        away[:own] = np.concatenate(
            (parameters.gain - guess.gain, parameters.offset - guess.offset)
        )
        there = signal_model.mask & fitted[:, None]
        more_rows, more_target = np.zeros((len(std), 0)), np.zeros(0)
        if known is not None:
            by_parameters, by_deviation, more_target = known.rows(
                signal_model.samples.shoe, parameters, deviations
            )
            more_rows = np.zeros((len(std), len(more_target)))
            more_rows[:own] = by_parameters.T
            more_rows[own + 1 : own + 1 + len(deviations)] = by_deviation.T
        if zeros is not None:
            by_parameters, target = zeros.rows(parameters)
            rows = np.zeros((len(std), len(target)))
            rows[:own] = by_parameters.T
            more_rows = np.concatenate((more_rows, rows), axis=1)
            more_target = np.concatenate((more_target, target))
        scale = there / sample_std
        runs = np.broadcast_to(signal_model.samples.run[:, None], there.shape)[there]
        single = [one.run is not None for one in deviations]
        single += [not one.shared for one in nuisances]
        return cls(
            signal_model=signal_model,
            deviations=deviations,
            std=std,
            away=away,
            columns=columns,
            scale=scale,
            rows=np.concatenate((columns[:, there] * scale[there], more_rows), axis=1),
            target=np.concatenate((signal_model.residuals[there] * scale[there], more_target)),
            runs=np.concatenate((runs, np.full(len(more_target), -1))),
            own=np.concatenate((np.zeros(own + 1, dtype=np.bool_), single)),
        )

    def with_others(self, effects: frozenset[str], others: Sequence[Deviation]) -> LinearSystem:
        """The same problem with other deviations, of body or joints, in the place of some effects'.

        Args:
            effects: of which no deviation stays.
            others: shared by all runs.
        """
        first = 2 * len(self.signal_model.parameters.gain) + 1
        last = first + len(self.deviations)
        stay = np.ones(len(self.std), dtype=np.bool_)
        stay[first:last] = [one.effect not in effects for one in self.deviations]
        at = int(stay[:last].sum())
        columns = np.array([one.column for one in others]).reshape(-1, *self.scale.shape)
        there = self.scale > 0.0
        rows = np.zeros((len(others), self.rows.shape[1]))
        # Behind the signals stands what is known of the shoe: joints add nothing to it.
        rows[:, : np.count_nonzero(there)] = columns[:, there] * self.scale[there]
        return replace(
            self,
            deviations=(*(one for one in self.deviations if one.effect not in effects), *others),
            std=np.insert(self.std[stay], at, [one.std for one in others]),
            away=np.insert(self.away[stay], at, np.zeros(len(others))),
            columns=np.concatenate((self.columns[stay][:at], columns, self.columns[stay][at:])),
            rows=np.concatenate((self.rows[stay][:at], rows, self.rows[stay][at:])),
            own=np.insert(self.own[stay], at, np.zeros(len(others), dtype=np.bool_)),
        )

    @property
    def recorded(self) -> tuple[int, ...]:
        """Runs that are fitted."""
        return tuple(np.unique(self.runs[self.runs >= 0]).tolist())

    @cached_property
    def _normal(self) -> FloatArray:
        normal: FloatArray = self.rows @ self.rows.T
        return normal

    @cached_property
    def _posterior(self) -> Posterior:
        return Posterior(self._normal, self.std**-2.0)

    def solution(self) -> FloatArray:
        """(u,) of least cost."""
        return self._posterior.solve(self.rows @ self.target + self.away / self.std**2)

    def covariance(self) -> FloatArray:
        """(u, u) of the unknowns."""
        return self._posterior.covariance

    def covariance_with_another(self, run: int) -> FloatArray:
        """(u, u) of the unknowns, had a run been recorded once more.

        The same motion gives the same derivatives. Noise, and the unknowns that a run has by
        itself, are drawn again: the latter are marginalised.
        """
        rows = self.rows[:, self.runs == run]
        normal = rows @ rows.T
        shared = ~self.own
        drawn = Posterior(normal[np.ix_(self.own, self.own)], self.std[self.own] ** -2.0)
        lost = drawn.whiten(normal[np.ix_(self.own, shared)])
        more = self._normal.copy()
        more[np.ix_(shared, shared)] += normal[np.ix_(shared, shared)] - lost.T @ lost
        return Posterior(more, self.std**-2.0).covariance

    def surprise(self, rows: FloatArray, target: FloatArray) -> float:
        """Squares by which the least cost rises when more values are fitted, too.

        With r what this system's solution leaves of them, and C its covariance, that is
        r' (1 + rows' C rows)^-1 r: as many as there are values, where they agree with the rest.

        Args:
            rows: (u, m) what a unit of each unknown adds, whitened.
            target: (m,) whitened values.
        """
        left = target - self.solution() @ rows
        shown = rows @ left
        with_them = Posterior(self._normal + rows @ rows.T, self.std**-2.0)
        return float(left @ left - shown @ with_them.solve(shown))

    def cost(self, unknowns: FloatArray) -> float:
        """Sum of squares at these unknowns (u,), priors included."""
        left = self.target - unknowns @ self.rows
        return float(left @ left + np.sum(((unknowns - self.away) / self.std) ** 2))

    def moved(self, solution: FloatArray) -> float:
        """Largest change of gains and offsets by a solution (u,), in units of their priors."""
        own = 2 * len(self.signal_model.parameters.gain)
        return float(np.max(np.abs(solution[:own] / self.std[:own])))

    def parameters_after(self, solution: FloatArray) -> ChannelParameters:
        """Gains and offsets without what a solution (u,) finds them too large by."""
        count, now = len(self.signal_model.parameters.gain), self.signal_model.parameters
        return ChannelParameters(
            now.gain - solution[:count], now.offset - solution[count : 2 * count]
        )
