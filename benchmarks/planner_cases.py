"""Robots, supports, and the optimisation problems that planning in them poses."""

from __future__ import annotations

import dataclasses
import time
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pages import ROOT
from shoecal_core.model.double_support import DoubleSupport
from shoecal_core.model.robot import Robot
from shoecal_core.model.robot_file import load_robot
from shoecal_core.planning.checking.check import check_motion
from shoecal_core.planning.checking.findings import Finding
from shoecal_core.planning.horizon.collocation import Collocation
from shoecal_core.planning.horizon.problem import HorizonProblem, Solution, Solver
from shoecal_core.planning.horizon.rolling import Path as Planned
from shoecal_core.planning.horizon.rolling import RollingHorizon
from shoecal_core.planning.horizon.sqp import SqpSolver
from shoecal_core.planning.legs import Legs
from shoecal_core.planning.motion import Motion, timed
from shoecal_core.planning.motion_catalogue import motion_kind
from shoecal_core.planning.planner import Planner
from shoecal_core.planning.segment import MotionSegment
from shoecal_core.planning.settings import PlannerSettings
from shoecal_core.planning.supports.draw import draw_supports
from shoecal_core.sensing.shoe import Shoe, load_shoe
from shoecal_core.workspace import config_dir

FloatArray = NDArray[np.float64]
OUT = ROOT / "out" / "planner"


@dataclass(frozen=True)
class Case:
    """A robot with its shoes, as the repository holds it."""

    name: str
    robot: Robot
    shoe: Shoe

    @classmethod
    def named(cls, name: str) -> Case:
        shoe = load_shoe(config_dir() / "shoes" / f"{name}_shoe.yaml")
        return cls(name, load_robot(config_dir() / "robots" / f"{name}.yaml", shoe), shoe)

    def supports(self, count: int, settings: PlannerSettings, seed: int) -> list[DoubleSupport]:
        """As the planner chooses them for one calibration."""
        return draw_supports(self.robot, self.shoe, settings, count, seed)

    def collocation(self, settings: PlannerSettings) -> Collocation:
        return Collocation(Legs(self.robot), settings)

    def fast_solver(self, settings: PlannerSettings, mode: str) -> SqpSolver:
        """The fast solver in one of its modes."""
        return SqpSolver(self.collocation(dataclasses.replace(settings, mode=mode)))


@dataclass(frozen=True)
class Span:
    """Time that something took.

    Attributes:
        wall: by the clock [s].
        cpu: of the processor, all threads together [s]; other programs leave it alone.
    """

    wall: float
    cpu: float


class Stopwatch:
    """Times from its making on."""

    def __init__(self) -> None:
        self._wall, self._cpu = time.perf_counter(), time.process_time()

    def read(self) -> Span:
        return Span(time.perf_counter() - self._wall, time.process_time() - self._cpu)


@dataclass(frozen=True)
class Solve:
    """One call of a solver: what it was asked, what it answered, and how long it took."""

    problem: HorizonProblem
    guess: FloatArray
    solution: Solution
    span: Span


class Recorder:
    """A solver that remembers every call."""

    def __init__(self, solver: Solver) -> None:
        self._solver = solver
        self.solves: list[Solve] = []

    def solve(self, problem: HorizonProblem, guess: FloatArray) -> Solution:
        """See Solver."""
        watch = Stopwatch()
        solution = self._solver.solve(problem, guess)
        self.solves.append(Solve(problem, guess, solution, watch.read()))
        return solution


@dataclass(frozen=True)
class Loop:
    """Planning in closed loop in one double support.

    Attributes:
        support: where.
        solves: of the solver under test.
        rescues: of the solver that steps in where that one fails.
        planned: states.
        motion: as it would be sent.
        findings: of the independent check.
        foot_error: largest of the applied states [m, rad].
        violation: largest of any constraint of the applied states [m, rad, N m].
        span: all of it took, timing and check excluded.
    """

    support: DoubleSupport
    solves: tuple[Solve, ...]
    rescues: tuple[Solve, ...]
    planned: Planned
    motion: Motion
    findings: tuple[Finding, ...]
    foot_error: float
    violation: float
    span: Span


def closed_loop(
    planner: Planner,
    support: DoubleSupport,
    solver: Solver,
    rescue: Sequence[Solver] = (),
    motion: str = "landmarks",
) -> Loop:
    """Plan a motion with one solver, and check it whatever comes out.

    Args:
        planner: of the robot.
        support: where it stands.
        solver: under test.
        rescue: tried where that one fails.
        motion: on the menu, of one segment.
    """
    recorder, others = Recorder(solver), [Recorder(other) for other in rescue]
    legs, settings = planner.legs, planner.settings
    horizon = RollingHorizon(planner.horizon.collocation, [recorder, *others])
    angles = planner.stance(support)
    (segment,) = motion_kind(motion).segments(planner.standing(angles))
    watch = Stopwatch()
    planned = horizon.roll(angles[legs.robot.legs], segment, angles)
    span = watch.read()
    made = timed(legs, [(segment, planned)], motion, angles, settings)
    foot_error, violation = applied_violation(planner, segment, planned, angles)
    return Loop(
        support=support,
        solves=tuple(recorder.solves),
        rescues=tuple(solve for other in others for solve in other.solves),
        planned=planned,
        motion=made,
        findings=check_motion(legs, made, settings).findings,
        foot_error=foot_error,
        violation=violation,
        span=span,
    )


def applied_violation(
    planner: Planner, segment: MotionSegment, planned: Planned, others: FloatArray
) -> tuple[float, float]:
    """Of all planned states: largest error of the feet, largest violation of any constraint.

    Bounds are those of a start that keeps them all, as a stance does.
    """
    collocation, settings = planner.horizon.collocation, planner.settings
    states = planned.states
    scene = segment.scene(planner.legs.robot, settings, others, 0)
    values = collocation.evaluate(states, scene)
    excess = [
        np.abs(values.foot_error),
        scene.beyond(values.cop) - scene.offsets,
        collocation.lower - states,
        states - collocation.upper,
        settings.capsule_clearance - values.distances,
        np.abs(values.torques) - collocation.torque,
        np.abs(np.diff(states, axis=0)) - collocation.transition,
    ]
    worst = max(float(part.max()) for part in excess if part.size)
    return float(excess[0].max()), max(0.0, worst)


def with_horizon(settings: PlannerSettings, horizon: int) -> PlannerSettings:
    """The same with N states."""
    return dataclasses.replace(settings, horizon=horizon)


def evenly(items: Sequence[Solve], most: int) -> list[Solve]:
    """At most so many, evenly spaced over all."""
    if len(items) <= most:
        return list(items)
    return [items[int(place)] for place in np.linspace(0, len(items) - 1, most)]
