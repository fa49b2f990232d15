"""The optimisation over one horizon (paper, equations 9 to 14).

    minimise    sum |c[i] - c_ref|^2_Qc + |u[i] - u[i-1]|^2_Qu
    subject to  q[i] = q[i-1] + u[i-1]              state
                c[i] = CoP(q[i]) in SP              stability
                q_min < q[i] < q_max                joint limits
                Dist(q[i]) > d_min                  collision
                TF(q[i]) = T0                       foot transform
                |u[i]| < joint speed * step time
                |torque(q[i])| < torque limit

The last two are not the paper's: a small robot's motors are slow and weak.
The transitions u are differences of states, so the states alone are unknowns and the state
equation holds exactly. Solvers stand behind one protocol; what they return is certified here.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import casadi as ca
import numpy as np
import shapely
from numpy.typing import NDArray

from shoecal_core.planning.legs import FootPose, LegExpressions, Legs
from shoecal_core.planning.settings import PlannerSettings
from shoecal_core.settings import SettingError

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class Scene:
    """What stays the same during a motion.

    Attributes:
        foot_pose: T0, the pose of the right sole in the left sole's frame.
        normals: (h, 2) outward, of the sensing polygon's edges.
        offsets: (h,) a CoP c is inside where normals @ c <= offsets [m].
        others: (m,) all joint angles, of which those beside the legs count [rad].
    """

    foot_pose: FootPose
    normals: FloatArray
    offsets: FloatArray
    others: FloatArray

    @classmethod
    def of(
        cls, polygon: shapely.Polygon, margin: float, foot_pose: FootPose, others: FloatArray
    ) -> Scene:
        """Half planes of a convex polygon, moved inwards by a margin [m]."""
        if polygon.buffer(-margin).is_empty:
            raise SettingError(
                "stability_margin", f"{margin:g} m leaves nothing of the sensing polygon; lower it"
            )
        corners = np.asarray(shapely.geometry.polygon.orient(polygon).exterior.coords)
        edges = np.diff(corners, axis=0)
        normals = np.column_stack([edges[:, 1], -edges[:, 0]])
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
        offsets = np.sum(normals * corners[:-1], axis=1) - margin
        return cls(foot_pose, normals, offsets, others)


@dataclass(frozen=True)
class HorizonProblem:
    """One optimisation.

    Attributes:
        start: (k,) q[0], leg angles now [rad].
        previous: (k,) u[-1], the transition that led there [rad].
        target: (2,) c_ref, left sole's frame [m].
        scene: the rest.
    """

    start: FloatArray
    previous: FloatArray
    target: FloatArray
    scene: Scene


@dataclass(frozen=True)
class Limits:
    """Bounds of every state of a horizon; a start outside of them is led back step by step.

    Attributes:
        lower, upper: (N, k) of the leg angles [rad].
        offsets: (N, h) of the half planes [m].
        clearances: (N, p) of the capsule pairs' distances [m].
        transition: (k,) of |u| [rad].
        torque: (k,) of the motors [N m].
    """

    lower: FloatArray
    upper: FloatArray
    offsets: FloatArray
    clearances: FloatArray
    transition: FloatArray
    torque: FloatArray


@dataclass(frozen=True)
class StateValues:
    """What the constraints say of n states.

    Attributes:
        cop: (n, 2) left sole's frame [m].
        foot_error: (n, 6) way [m] and turn [rad] from T0.
        distances: (n, p) of the capsule pairs [m].
        torques: (n, k) of the motors [N m].
    """

    cop: FloatArray
    foot_error: FloatArray
    distances: FloatArray
    torques: FloatArray


@dataclass(frozen=True)
class Solution:
    """What a solver found, certified.

    Attributes:
        states: (N, k) leg angles q[1] to q[N] [rad].
        cost: of the states.
        violation: largest violation of any constraint [m, rad or N m].
        converged: the solver's own word, and the violation within tolerance.
        status: of the solver, for people.
        iterations: that it took.
    """

    states: FloatArray
    cost: float
    violation: float
    converged: bool
    status: str
    iterations: int


class Solver(Protocol):
    """Solves one horizon's problem after another."""

    def solve(self, problem: HorizonProblem, guess: FloatArray) -> Solution:
        """Find states (N, k) from a guess of them (N, k) [rad]."""
        ...


class Collocation:
    """The problem of one robot and one set of settings, in functions of one state each.

    Attributes:
        legs: what moves.
        settings: weights and margins.
        state: angles, foot pose, others -> CoP, foot error, distances, torques of one state.
    """

    def __init__(self, legs: Legs, settings: PlannerSettings) -> None:
        self.legs = legs
        self.settings = settings
        terms = LegExpressions(legs.robot)
        self.lower, self.upper = legs.bounds(settings)
        self.state = ca.Function(
            "state",
            [terms.angles, terms.foot_pose, terms.others],
            [terms.cop, terms.foot_error, terms.distances, terms.torques],
            {"cse": True},
        )

    @property
    def cop_weights(self) -> FloatArray:
        """(2,) Q_c [1/m^2]."""
        return np.array([self.settings.cop_weight_x, self.settings.cop_weight_y])

    @property
    def transition(self) -> FloatArray:
        """(k,) largest |u| [rad]."""
        robot = self.legs.robot
        speed = np.minimum(robot.velocity_limit[robot.legs], self.settings.joint_speed)
        return speed * self.settings.step_time

    @property
    def torque(self) -> FloatArray:
        """(k,) largest |torque| of the motors [N m]."""
        robot = self.legs.robot
        torque: FloatArray = robot.effort_limit[robot.legs] * self.settings.torque_share
        return torque

    def evaluate(self, states: FloatArray, scene: Scene) -> StateValues:
        """Values of states (n, k) [rad]."""
        count = len(states)
        pose = np.tile(scene.foot_pose.parameters[:, None], count)
        others = np.tile(scene.others[:, None], count)
        values = self.state(states.T, pose, others)
        return StateValues(*(np.array(value).T for value in values))

    def limits(self, problem: HorizonProblem) -> Limits:
        """Bounds of every state; each bound that the start violates moves in by a rate."""
        settings = self.settings
        now = self.evaluate(problem.start[None], problem.scene)
        steps = np.arange(1, settings.horizon + 1)[:, None]
        turn = settings.recovery * self.transition * steps
        way = settings.recovery * settings.com_speed * settings.step_time * steps
        outside = problem.scene.normals @ now.cop[0]
        return Limits(
            lower=np.minimum(self.lower, problem.start + turn),
            upper=np.maximum(self.upper, problem.start - turn),
            offsets=np.maximum(problem.scene.offsets, outside - way),
            clearances=np.minimum(settings.capsule_clearance, now.distances[0] + way),
            transition=self.transition,
            torque=np.maximum(self.torque, np.abs(now.torques[0])),
        )

    def transitions(self, problem: HorizonProblem, states: FloatArray) -> FloatArray:
        """(N, k) u[0] to u[N-1] of states (N, k) [rad]."""
        return np.diff(np.vstack([problem.start, states]), axis=0)

    def assess(
        self, problem: HorizonProblem, limits: Limits, states: FloatArray
    ) -> tuple[float, float]:
        """Cost (equation 9) and largest violation of any constraint [m, rad, N m] of states (N, k).

        The violation is zero or more.
        """
        values = self.evaluate(states, problem.scene)
        moves = self.transitions(problem, states)
        pull = np.sum(self.cop_weights * (values.cop - problem.target) ** 2)
        change = np.diff(np.vstack([problem.previous, moves]), axis=0)
        cost = pull + self.settings.transition_weight * np.sum(change**2)
        excess = [
            np.abs(values.foot_error),
            values.cop @ problem.scene.normals.T - limits.offsets,
            limits.lower - states,
            states - limits.upper,
            limits.clearances - values.distances,
            np.abs(values.torques) - limits.torque,
            np.abs(moves) - limits.transition,
        ]
        worst = max(float(part.max()) for part in excess if part.size)
        return float(cost), max(0.0, worst)

    def certified(
        self, problem: HorizonProblem, states: FloatArray, status: str, iterations: int, done: bool
    ) -> Solution:
        """A solution with its own evidence."""
        cost, violation = np.inf, np.inf
        if np.all(np.isfinite(states)):
            cost, violation = self.assess(problem, self.limits(problem), states)
        return Solution(
            states=states,
            cost=cost,
            violation=violation,
            converged=done and violation <= self.settings.tolerance,
            status=status,
            iterations=iterations,
        )
