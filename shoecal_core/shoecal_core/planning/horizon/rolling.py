"""Algorithm 1 of the paper: a horizon that rolls from landmark to landmark."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from shoecal_core.arrays import FloatArray, IntArray
from shoecal_core.errors import ShoecalError
from shoecal_core.planning.horizon.collocation import Collocation
from shoecal_core.planning.horizon.problem import HorizonProblem, HorizonSolution, Scene, Solver
from shoecal_core.planning.segment import MotionSegment
from shoecal_core.planning.settings import PlannerSettings

_SHRUNK = (1.0, 0.5, 0.2)
"""Parts of the way to a target that are tried in turn."""


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
    switches: IntArray
    statuses: tuple[str, ...]
    solve_times: FloatArray

    @classmethod
    def joined(cls, paths: Sequence[Path]) -> Path:
        """Paths of which each begins where the one before has ended."""
        counts = np.cumsum([0, *(len(path.states) - 1 for path in paths)])
        return cls(
            states=np.vstack([paths[0].states[:1], *(path.states[1:] for path in paths)]),
            targets=np.vstack([path.targets for path in paths]),
            nearest=np.concatenate([path.nearest for path in paths]),
            switches=np.concatenate(
                [path.switches + count for path, count in zip(paths, counts, strict=False)]
            ),
            statuses=tuple(status for path in paths for status in path.statuses),
            solve_times=np.concatenate([path.solve_times for path in paths]),
        )


class Pursuit:
    """Which target is pursued, and when the next one is due.

    The next is due when the CoP is nearer than the landmark radius, or when it has come no
    nearer for some steps. The last one is pursued like the others. Where the torso's lean and
    height are pursued too, their distances count by their weights against the CoP's.
    """

    def __init__(
        self,
        targets: FloatArray,
        now: FloatArray,
        settings: PlannerSettings,
        weights: FloatArray | None = None,
    ) -> None:
        """Begin with the first target.

        Args:
            targets: (L, n) the CoP's places [m] in the first two columns.
            now: (n,) where the robot is.
            settings: radius and patience.
            weights: (n,) of the squared distances; the CoP's alone count where not given.
        """
        self._targets = targets
        self._settings = settings
        self._scale = (
            np.zeros(len(now)) if weights is None else np.sqrt(weights / weights[:2].max())
        )
        self._scale[:2] = 1.0
        self.index = 0
        self.nearest = np.full(len(targets), np.inf)
        self._idle = 0
        self._distance = 0.0
        self._begin(now)

    @property
    def done(self) -> bool:
        """Whether there is nothing left to pursue."""
        return self.index >= len(self._targets)

    @property
    def target(self) -> FloatArray:
        """(n,) the one pursued, the last one when all is done."""
        target: FloatArray = self._targets[min(self.index, len(self._targets) - 1)]
        return target

    @property
    def distance(self) -> float:
        """To the target pursued; zero when there is none [m]."""
        return self._distance

    def observe(self, now: FloatArray) -> bool:
        """Take note of where a step has led (n,); True when another target is due."""
        distance = self._away(now)
        progress = self._distance - distance
        self._idle = self._idle + 1 if progress < self._settings.progress_min else 0
        self._distance = distance
        self.nearest[self.index] = min(self.nearest[self.index], distance)
        close = distance < self._settings.landmark_radius
        if close or self._idle >= self._settings.progress_patience:
            self.skip(now)
            return True
        return False

    def skip(self, now: FloatArray) -> None:
        """Take the next target; its distance counts from where the robot is now (n,)."""
        self.index += 1
        self._begin(now)

    def _begin(self, now: FloatArray) -> None:
        self._idle = 0
        self._distance = 0.0
        if not self.done:
            self._distance = self._away(now)
            self.nearest[self.index] = self._distance

    def _away(self, now: FloatArray) -> float:
        return float(np.linalg.norm((now - self.target) * self._scale))


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

    def step(self, problem: HorizonProblem, guess: FloatArray) -> HorizonSolution:
        """One optimisation; of unconverged ones the least violated.

        Every solver starts from `guess` (N, k) [rad] and, failing that, from standing still where
        that is another one.
        """
        still = np.tile(problem.start, (self.collocation.settings.horizon, 1))
        begins = (guess,) if np.array_equal(guess, still) else (guess, still)
        found: list[HorizonSolution] = []
        for solver in self._solvers:
            for begin in begins:
                found.append(self._tried(solver, problem, begin))
                if found[-1].converged:
                    return found[-1]
        return min(found, key=lambda solution: solution.violation)

    def _tried(self, solver: Solver, problem: HorizonProblem, begin: FloatArray) -> HorizonSolution:
        """What a solver finds; one that raises, or returns no numbers, has found nothing."""
        try:
            solution = solver.solve(problem, begin)
        except (RuntimeError, ArithmeticError, np.linalg.LinAlgError) as error:
            status, states = type(error).__name__, np.full_like(begin, np.nan)
        else:
            if np.all(np.isfinite(solution.states)):
                return solution
            status, states = solution.status, solution.states
        return self.collocation.certified(problem, states, status, 0, False)

    def roll(
        self,
        start: FloatArray,
        segment: MotionSegment,
        others: FloatArray,
        *,
        progress: Callable[[Progress], None] = lambda _: None,
        canceled: Callable[[], bool] = lambda: False,
    ) -> Path:
        """Follow a segment from rest at leg angles (k,) [rad].

        Args:
            start: where the robot stands.
            segment: what to pursue and to keep.
            others: (m,) all joint angles, of which those outside the legs count [rad].
            progress: called before every optimisation.
            canceled: asked before every optimisation.

        Raises:
            PlanningCanceledError: when `canceled` says so.
            PlanningError: when nothing could be planned towards any target, or a foot on its
                way cannot go on.
        """
        roll = _Roll(self, start, segment, others)
        while not roll.done:
            if canceled():
                raise PlanningCanceledError
            progress(roll.progress)
            roll.advance()
        return roll.path()


class _Roll:
    """One segment while it is being planned."""

    def __init__(
        self, horizon: RollingHorizon, start: FloatArray, segment: MotionSegment, others: FloatArray
    ) -> None:
        self._horizon = horizon
        self._collocation = horizon.collocation
        self._settings = horizon.collocation.settings
        self._course = segment
        self._others = others
        self._begin = self._scene(0)
        self._states = [start]
        self._tasks = self._local(start[None], 0)[0]
        arrival = segment.weights if segment.arrival is None else segment.arrival
        self._pursuit = Pursuit(segment.targets, self._tasks, self._settings, arrival)
        self._switches: list[int] = []
        self._statuses: list[str] = []
        self._times: list[float] = []
        self._stand()

    @property
    def done(self) -> bool:
        arrived = len(self._states) >= len(self._course.foot_poses)
        return (self._pursuit.done and arrived) or len(self._states) > self._settings.steps_max

    @property
    def progress(self) -> Progress:
        pursuit = self._pursuit
        count = len(self._course.targets)
        return Progress(min(pursuit.index, count), count, len(self._states) - 1, pursuit.distance)

    def advance(self) -> None:
        """Optimise once and take over its first states.

        A solution that violates a constraint is never taken over: a place nearer by is aimed
        at, and where that fails too the next target is pursued instead, from rest. So targets
        and steps_max bound the number of optimisations.
        """
        for part in _SHRUNK:
            solution = self._optimised(part)
            if solution.violation <= self._settings.tolerance:
                self._apply(solution.states)
                return
        if self._course.moving:
            raise PlanningError(
                f"part '{self._course.name}': the foot cannot go on after state "
                f"{len(self._states) - 1} of {len(self._course.foot_poses) - 1} (solver: "
                f"{self._statuses[-1]}); choose feet nearer to each other's neutral place"
            )
        self._stand()
        self._pursuit.skip(self._tasks)
        self._switches.append(len(self._states) - 1)

    def _optimised(self, part: float) -> HorizonSolution:
        """Towards a place that is only a part of the way to the target."""
        here = len(self._states) - 1
        target = self._tasks + part * (self._pursuit.target - self._tasks)
        aim = self._course.aim(target, self._settings.horizon, here)
        scene = self._scene(here) if self._course.moving else self._begin
        problem = HorizonProblem(self._states[-1], self._previous, aim, scene)
        begin = time.perf_counter()
        solution = self._horizon.step(problem, self._guess)
        self._times.append(time.perf_counter() - begin)
        self._statuses.append(solution.status)
        return solution

    def _stand(self) -> None:
        self._previous = np.zeros_like(self._states[-1])
        self._guess = np.tile(self._states[-1], (self._settings.horizon, 1))

    def _apply(self, states: FloatArray) -> None:
        applied = min(self._settings.applied_states, len(states))
        tasks = self._local(states[:applied], len(self._states))
        for state, self._tasks in zip(states, tasks, strict=False):
            self._previous = state - self._states[-1]
            self._states.append(state)
            if not self._pursuit.done and self._pursuit.observe(self._tasks):
                self._switches.append(len(self._states) - 1)
                break
        self._guess = np.vstack([states[applied:], np.repeat(states[-1:], applied, axis=0)])

    def _local(self, states: FloatArray, first: int) -> FloatArray:
        """(n, 5) what is pursued, of states (n, k) that begin with one of the part's."""
        tasks = self._collocation.evaluate(states, self._begin.first).tasks
        local = [self._course.local(row, first + index) for index, row in enumerate(tasks)]
        return np.array(local)

    def _scene(self, state: int) -> Scene:
        robot = self._collocation.legs.robot
        return self._course.scene(robot, self._settings, self._others, state)

    def path(self) -> Path:
        segment = self._course
        if len(self._states) == 1 and len(segment.targets):
            outside = self._collocation.outside(self._states[0], self._begin)
            begins = f"; it begins outside: {', '.join(outside)}" if outside else ""
            raise PlanningError(
                f"no motion towards any of {len(segment.targets)} landmarks was found (solver: "
                f"{self._statuses[-1]}{begins}); start from another posture or lower the margins"
            )
        return Path(
            states=np.array(self._states),
            targets=segment.left_targets,
            nearest=self._pursuit.nearest,
            switches=np.array(self._switches, dtype=np.int64),
            statuses=tuple(self._statuses),
            solve_times=np.array(self._times),
        )
