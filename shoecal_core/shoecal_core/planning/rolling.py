"""Algorithm 1 of the paper: a horizon that rolls from landmark to landmark."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from shoecal_core.errors import ShoecalError
from shoecal_core.planning.collocation import (
    Collocation,
    HorizonProblem,
    Scene,
    Solution,
    Solver,
)
from shoecal_core.planning.settings import PlannerSettings

FloatArray = NDArray[np.float64]


class PlanningCanceledError(ShoecalError):
    """Somebody asked to stop."""

    def __init__(self) -> None:
        super().__init__("planning was cancelled")


class PlanningError(ShoecalError):
    """No motion was found."""


@dataclass(frozen=True)
class Progress:
    """How far planning has come.

    Attributes:
        landmark: index of the target pursued.
        landmarks: how many there are.
        steps: states planned so far.
        distance: from the CoP to the target [m].
    """

    landmark: int
    landmarks: int
    steps: int
    distance: float


@dataclass(frozen=True)
class Path:
    """Planned states from rest, without times.

    Attributes:
        states: (K, k) leg angles, the start first [rad].
        targets: (L, 2) places pursued one after another, left sole's frame [m].
        nearest: (L,) how near the CoP came to each; infinite where it was never pursued [m].
        switches: (up to L,) index of the state at which each was left.
        statuses: of every optimisation.
        solve_times: (S,) what they took [s].
    """

    states: FloatArray
    targets: FloatArray
    nearest: FloatArray
    switches: NDArray[np.int64]
    statuses: tuple[str, ...]
    solve_times: FloatArray


class Pursuit:
    """Which target is pursued, and when the next one is due.

    The next is due when the CoP is nearer than the landmark radius, or when it has come no
    nearer for some steps. The last one is pursued like the others.
    """

    def __init__(self, targets: FloatArray, cop: FloatArray, settings: PlannerSettings) -> None:
        self._targets = targets
        self._settings = settings
        self.index = 0
        self.nearest = np.full(len(targets), np.inf)
        self._idle = 0
        self._distance = 0.0
        self._begin(cop)

    @property
    def done(self) -> bool:
        """Whether there is nothing left to pursue."""
        return self.index >= len(self._targets)

    @property
    def target(self) -> FloatArray:
        """(2,) the one pursued [m]."""
        target: FloatArray = self._targets[self.index]
        return target

    @property
    def distance(self) -> float:
        """From the last CoP to the target pursued; zero when there is none [m]."""
        return self._distance

    def observe(self, cop: FloatArray) -> bool:
        """Take note of one step's CoP (2,) [m]; True when another target is due."""
        distance = float(np.linalg.norm(cop - self.target))
        progress = self._distance - distance
        self._idle = self._idle + 1 if progress < self._settings.progress_min else 0
        self._distance = distance
        self.nearest[self.index] = min(self.nearest[self.index], distance)
        close = distance < self._settings.landmark_radius
        if close or self._idle >= self._settings.progress_patience:
            self.skip(cop)
            return True
        return False

    def skip(self, cop: FloatArray) -> None:
        """Take the next target; its distance is taken anew from the CoP (2,) [m]."""
        self.index += 1
        self._begin(cop)

    def _begin(self, cop: FloatArray) -> None:
        self._idle = 0
        self._distance = 0.0
        if not self.done:
            self._distance = float(np.linalg.norm(cop - self.target))
            self.nearest[self.index] = self._distance


class RollingHorizon:
    """Plans from any state; the solvers are tried in turn until one converges.

    Attributes:
        collocation: the problem of one horizon.
    """

    def __init__(self, collocation: Collocation, solvers: Sequence[Solver]) -> None:
        if not solvers:
            raise PlanningError("no solver was given; give at least one")
        self.collocation = collocation
        self._solvers = tuple(solvers)

    def step(self, problem: HorizonProblem, guess: FloatArray) -> Solution:
        """One optimisation; of unconverged ones the least violated.

        Every solver starts from `guess` (N, k) [rad] and, failing that, from standing still.
        """
        still = np.tile(problem.start, (self.collocation.settings.horizon, 1))
        found: list[Solution] = []
        for solver in self._solvers:
            for begin in (guess, still):
                found.append(solver.solve(problem, begin))
                if found[-1].converged:
                    return found[-1]
        return min(found, key=lambda solution: solution.violation)

    def roll(
        self,
        start: FloatArray,
        targets: FloatArray,
        scene: Scene,
        *,
        progress: Callable[[Progress], None] = lambda _: None,
        canceled: Callable[[], bool] = lambda: False,
    ) -> Path:
        """Pursue targets (L, 2) [m] from rest at leg angles (k,) [rad].

        Raises:
            PlanningCanceledError: when `canceled` says so.
            PlanningError: when nothing could be planned towards any target.
        """
        roll = _Roll(self, start, targets, scene)
        while not roll.done:
            if canceled():
                raise PlanningCanceledError
            progress(roll.progress)
            roll.advance()
        return roll.path()


class _Roll:
    """One motion while it is being planned."""

    def __init__(
        self, horizon: RollingHorizon, start: FloatArray, targets: FloatArray, scene: Scene
    ) -> None:
        self._horizon = horizon
        self._collocation = horizon.collocation
        self._settings = horizon.collocation.settings
        self._scene = scene
        self._targets = targets
        self._states = [start]
        self._cop = self._collocation.evaluate(start[None], scene).cop[0]
        self._pursuit = Pursuit(targets, self._cop, self._settings)
        self._switches: list[int] = []
        self._statuses: list[str] = []
        self._times: list[float] = []
        self._stand()

    @property
    def done(self) -> bool:
        return self._pursuit.done or len(self._states) > self._settings.steps_max

    @property
    def progress(self) -> Progress:
        pursuit = self._pursuit
        return Progress(pursuit.index, len(self._targets), len(self._states) - 1, pursuit.distance)

    def advance(self) -> None:
        """Optimise once and take over its first states.

        A solution that violates a constraint is never taken over: the next target is pursued
        instead, from rest. So targets and steps_max bound the number of optimisations.
        """
        problem = HorizonProblem(
            self._states[-1], self._previous, self._pursuit.target, self._scene
        )
        begin = time.perf_counter()
        solution = self._horizon.step(problem, self._guess)
        self._times.append(time.perf_counter() - begin)
        self._statuses.append(solution.status)
        if solution.violation > self._settings.tolerance:
            self._stand()
            self._pursuit.skip(self._cop)
            self._switches.append(len(self._states) - 1)
        else:
            self._apply(solution.states)

    def _stand(self) -> None:
        self._previous = np.zeros_like(self._states[-1])
        self._guess = np.tile(self._states[-1], (self._settings.horizon, 1))

    def _apply(self, states: FloatArray) -> None:
        cops = self._collocation.evaluate(states, self._scene).cop
        applied = min(self._settings.applied_states, len(states))
        for state, cop in zip(states[:applied], cops[:applied], strict=True):
            self._previous = state - self._states[-1]
            self._cop = cop
            self._states.append(state)
            if self._pursuit.observe(cop):
                self._switches.append(len(self._states) - 1)
                break
        self._guess = np.vstack([states[applied:], np.repeat(states[-1:], applied, axis=0)])

    def path(self) -> Path:
        if len(self._states) == 1 and len(self._targets):
            raise PlanningError(
                f"no motion towards any of {len(self._targets)} landmarks was found (solver: "
                f"{self._statuses[-1]}); start from another posture or lower the margins"
            )
        return Path(
            states=np.array(self._states),
            targets=self._targets,
            nearest=self._pursuit.nearest,
            switches=np.array(self._switches, dtype=np.int64),
            statuses=tuple(self._statuses),
            solve_times=np.array(self._times),
        )
