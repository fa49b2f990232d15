"""The optimisation over one horizon (paper, equations 9 to 14).

    minimise    sum |c[i] - c_ref|^2_Qc + |u[i] - u[i-1]|^2_Qu
    subject to  q[i] = q[i-1] + u[i-1]              state
                c[i] = CoP(q[i]) in SP              stability
                q_min < q[i] < q_max                joint limits
                Dist(q[i]) > d_min                  collision
                TF(q[i]) = T0                       foot transform
                |u[i]| < joint speed * step time
                |torque(q[i])| < torque limit

The last two are not the paper's: a small robot's motors are slow and weak. For motions that the
paper does not have, the torso's lean and height may be pursued beside the CoP, and polygon and
foot transform may change from state to state: so a foot is lifted, carried and put down.

The transitions u are differences of states, so the states alone are unknowns and the state
equation holds exactly. Solvers stand behind one protocol; what they return is certified here.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import casadi as ca
import numpy as np
import shapely
from numpy.typing import NDArray

from shoecal_core.batch import Batch
from shoecal_core.planning.legs import FootPose, LegExpressions, Legs
from shoecal_core.planning.settings import PlannerSettings
from shoecal_core.settings import SettingError

FloatArray = NDArray[np.float64]


TASKS = 5
"""What is pursued: CoP forward and sideways, lean forward and sideways, height."""
FOOT_ROWS = 6
"""Of the foot transform: way and turn."""


@dataclass(frozen=True)
class Scene:
    """What n states in a row have to keep; n is 1 where all states keep the same.

    Attributes:
        foot_poses: (n, 12) T0, poses of the right sole in the left sole's frame, as
            FootPose.parameters.
        shares: (n, 2) least and greatest share of the weight on the left foot.
        normals: (n, h, 2) outward, of the edges of where the CoP may be.
        offsets: (n, h) a CoP c is inside where normals @ c <= offsets [m].
        others: (m,) all joint angles, of which those beside the legs count [rad].
    """

    foot_poses: FloatArray
    shares: FloatArray
    normals: FloatArray
    offsets: FloatArray
    others: FloatArray

    @classmethod
    def of(
        cls,
        polygon: shapely.Polygon,
        margin: float,
        foot_pose: FootPose,
        others: FloatArray,
        share: tuple[float, float] = (0.0, 1.0),
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
        return cls(
            foot_pose.parameters[None], np.array([share]), normals[None], offsets[None], others
        )

    @classmethod
    def row(cls, scenes: Sequence[Scene]) -> Scene:
        """Scenes of one state each, one after another; the first one's other joints."""
        if len(scenes) == 1:
            return scenes[0]
        edges = max(scene.offsets.shape[1] for scene in scenes)
        padded = [scene.padded(edges) for scene in scenes]
        return cls(
            np.concatenate([scene.foot_poses for scene in padded]),
            np.concatenate([scene.shares for scene in padded]),
            np.concatenate([scene.normals for scene in padded]),
            np.concatenate([scene.offsets for scene in padded]),
            padded[0].others,
        )

    def padded(self, edges: int) -> Scene:
        """With as many edges, those that are missing as 0 * c <= infinity."""
        count, present = self.offsets.shape
        if present == edges:
            return self
        normals, offsets = np.zeros((count, edges, 2)), np.full((count, edges), np.inf)
        normals[:, :present], offsets[:, :present] = self.normals, self.offsets
        return dataclasses.replace(self, normals=normals, offsets=offsets)

    @property
    def first(self) -> Scene:
        """Of the first state."""
        return self.head(1)

    def head(self, count: int) -> Scene:
        """Of the first states; also where all keep the same."""
        return dataclasses.replace(
            self,
            foot_poses=self.foot_poses[:count],
            shares=self.shares[:count],
            normals=self.normals[:count],
            offsets=self.offsets[:count],
        )

    def beyond(self, cop: FloatArray) -> FloatArray:
        """(n, h) how far CoPs (n, 2) are beyond lines through the origin along each edge [m]."""
        outside: FloatArray = (self.normals @ cop[..., None])[..., 0]
        return outside


@dataclass(frozen=True)
class Aim:
    """What the states of one optimisation pursue.

    Attributes:
        targets: (n, 5) CoP in the left sole's frame [m], lean, and height of the base above the
            left sole [m]; n is 1 where all states pursue the same.
        weights: (5,) of their squared distances; zero for what is not pursued.
    """

    targets: FloatArray
    weights: FloatArray

    @classmethod
    def at(cls, cop: FloatArray, settings: PlannerSettings) -> Aim:
        """A place (2,) for the CoP [m] (the paper's c_ref), and nothing else."""
        weights = np.array([settings.cop_weight_x, settings.cop_weight_y, 0.0, 0.0, 0.0])
        return cls(np.array([[*cop, 0.0, 0.0, 0.0]]), weights)


@dataclass(frozen=True)
class HorizonProblem:
    """One optimisation.

    Attributes:
        start: (k,) q[0], leg angles now [rad].
        previous: (k,) u[-1], the transition that led there [rad].
        aim: what q[1] to q[N] pursue.
        scene: what they have to keep.
    """

    start: FloatArray
    previous: FloatArray
    aim: Aim
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

    def head(self, count: int) -> Limits:
        """Of the first states."""
        return dataclasses.replace(
            self,
            lower=self.lower[:count],
            upper=self.upper[:count],
            offsets=self.offsets[:count],
            clearances=self.clearances[:count],
        )


@dataclass(frozen=True)
class StateValues:
    """What the constraints say of n states.

    Attributes:
        tasks: (n, 5) CoP [m], lean, height [m], as in Aim.
        foot_error: (n, 6) way [m] and turn [rad] from T0.
        distances: (n, p) of the capsule pairs [m].
        torques: (n, k) of the motors [N m].
    """

    tasks: FloatArray
    foot_error: FloatArray
    distances: FloatArray
    torques: FloatArray

    @classmethod
    def of_rows(cls, rows: FloatArray, motors: int) -> StateValues:
        """From (n, r) all of them side by side, torques of k motors last."""
        foot, torques = TASKS + FOOT_ROWS, rows.shape[1] - motors
        return cls(rows[:, :TASKS], rows[:, TASKS:foot], rows[:, foot:torques], rows[:, torques:])

    @property
    def cop(self) -> FloatArray:
        """(n, 2) left sole's frame [m]."""
        return self.tasks[:, :2]


@dataclass(frozen=True)
class Solution:
    """What a solver found, certified.

    Attributes:
        states: (N, k) leg angles q[1] to q[N] [rad].
        cost: of the states.
        violation: largest violation of any constraint by any state, or by those that are applied
            where the mode is not `converged` [m, rad or N m].
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
        state: angles, foot pose, others, share -> tasks, foot error, distances, torques of one
            state.
    """

    def __init__(self, legs: Legs, settings: PlannerSettings) -> None:
        self.legs = legs
        self.settings = settings
        terms = LegExpressions(legs.robot)
        self.lower, self.upper = legs.bounds(settings)
        given = [terms.angles, terms.foot_pose, terms.others, terms.share]
        found = [
            ca.vertcat(terms.cop, terms.lean, terms.height),
            terms.foot_error,
            terms.distances,
            terms.torques,
        ]
        self.state = ca.Function("state", given, found, {"cse": True})
        rows = ca.Function("state_rows", [ca.vertcat(*given)], [ca.vertcat(*found)], {"cse": True})
        self._rows = Batch(rows, least=1)

    @property
    def edges(self) -> int:
        """Most edges of where the CoP may be.

        A convex hull has no more edges than the polygons it is made of have corners.
        """
        return sum(len(foot.sensing_polygon) for foot in self.legs.robot.feet)

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
        """Values of states (n, k) [rad] in their scenes."""
        return StateValues.of_rows(self._rows(self.inputs(states, scene)), states.shape[1])

    def inputs(self, states: FloatArray, scene: Scene) -> FloatArray:
        """(n, i) what `state` takes, side by side, of states (n, k) [rad] in their scenes."""
        size, others = states.shape[1], len(scene.others)
        inputs = np.empty((len(states), size + 12 + others + 2))
        inputs[:, :size] = states
        inputs[:, size : size + 12] = scene.foot_poses
        inputs[:, size + 12 : -2] = scene.others
        inputs[:, -2:] = scene.shares
        return inputs

    def limits(self, problem: HorizonProblem) -> Limits:
        """Bounds of every state; each bound that the start violates moves in by a rate."""
        settings, scene = self.settings, problem.scene
        now = self.evaluate(problem.start[None], scene.first)
        steps = np.arange(1, settings.horizon + 1)[:, None]
        turn = settings.recovery * self.transition * steps
        way = settings.recovery * settings.com_speed * settings.step_time * steps
        # Edges that move with a foot are those of the foot that stands: of the first state.
        first = scene.first
        beyond = first.beyond(_seen_at_first(now, first)) - first.offsets
        return Limits(
            lower=np.minimum(self.lower, problem.start + turn),
            upper=np.maximum(self.upper, problem.start - turn),
            offsets=scene.offsets + np.maximum(0.0, beyond - way),
            clearances=np.minimum(settings.capsule_clearance, now.distances[0] + way),
            transition=self.transition,
            torque=np.maximum(self.torque, np.abs(now.torques[0])),
        )

    def outside(self, state: FloatArray, scene: Scene) -> tuple[str, ...]:
        """What a state (k,) [rad] does not keep of the first state's scene, for people."""
        robot, settings = self.legs.robot, self.settings
        now = self.evaluate(state[None], scene.first)
        found = [
            f"joint '{name}' is {excess:.3f} rad beyond its limit less joint_margin or knee_margin"
            for name, excess in zip(
                robot.leg_names, np.maximum(self.lower - state, state - self.upper), strict=True
            )
            if excess > settings.tolerance
        ]
        beyond = float(np.max(scene.first.beyond(now.cop) - scene.first.offsets))
        if beyond > settings.tolerance:
            found.append(f"the CoP is {1e3 * beyond:.1f} mm beyond stability_margin")
        found += [
            f"capsules '{robot.capsules[a].name}' and '{robot.capsules[b].name}' are "
            f"{1e3 * distance:.1f} mm apart, capsule_clearance is "
            f"{1e3 * settings.capsule_clearance:g} mm"
            for (a, b), distance in zip(robot.collision_pairs, now.distances[0], strict=True)
            if distance < settings.capsule_clearance - settings.tolerance
        ]
        found += [
            f"motor '{name}' holds {abs(torque):.2f} N m, torque_share allows {limit:.2f} N m"
            for name, torque, limit in zip(
                robot.leg_names, now.torques[0], self.torque, strict=True
            )
            if abs(torque) > limit + settings.tolerance
        ]
        return tuple(found)

    def transitions(self, problem: HorizonProblem, states: FloatArray) -> FloatArray:
        """(N, k) u[0] to u[N-1] of states (N, k) [rad]."""
        return np.diff(np.vstack([problem.start, states]), axis=0)

    def cost(self, problem: HorizonProblem, states: FloatArray, values: StateValues) -> float:
        """Equation 9, of states (N, k) [rad] and their values."""
        aim = problem.aim
        pull = np.sum(aim.weights * (values.tasks - aim.targets) ** 2)
        moves = self.transitions(problem, states)
        change = np.diff(np.vstack([problem.previous, moves]), axis=0)
        return float(pull + self.settings.transition_weight * np.sum(change**2))

    def assess(
        self,
        problem: HorizonProblem,
        limits: Limits,
        states: FloatArray,
        first: int | None = None,
    ) -> tuple[float, float]:
        """Cost (equation 9) and largest violation of any constraint [m, rad, N m] of states (N, k).

        The violation is zero or more; it is that of so many first states, of all where no number
        is given.
        """
        values = self.evaluate(states, problem.scene)
        moves = self.transitions(problem, states)
        excess = [
            np.abs(values.foot_error),
            problem.scene.beyond(values.cop) - limits.offsets,
            limits.lower - states,
            states - limits.upper,
            limits.clearances - values.distances,
            np.abs(values.torques) - limits.torque,
            np.abs(moves) - limits.transition,
        ]
        worst = max(float(part[:first].max()) for part in excess if part.size)
        return self.cost(problem, states, values), max(0.0, worst)

    def certified(
        self,
        problem: HorizonProblem,
        states: FloatArray,
        status: str,
        iterations: int,
        done: bool,
        *,
        first: int | None = None,
        limits: Limits | None = None,
    ) -> Solution:
        """A solution with its own evidence.

        Args:
            problem: that is solved.
            states: (N, k) [rad].
            status: of the solver.
            iterations: that it took.
            done: the solver's own word.
            first: so many states' violation counts; all where not given.
            limits: of the problem, where they are known.
        """
        cost, violation = np.inf, np.inf
        if np.all(np.isfinite(states)):
            cost, violation = self.assess(problem, limits or self.limits(problem), states, first)
        return Solution(
            states=states,
            cost=cost,
            violation=violation,
            converged=done and violation <= self.settings.tolerance,
            status=status,
            iterations=iterations,
        )


def _seen_at_first(now: StateValues, first: Scene) -> FloatArray:
    """(1, 2) a start's CoP [m], in the left sole's frame as it is at the first state.

    Where the right foot alone stands, the left sole moves with it from state to state.
    """
    if first.shares[0, 1] > 0.0:
        return now.cop
    away, turn = now.foot_error[0, :2], now.foot_error[0, 5]
    place = first.foot_poses[0, 9:11]
    x, y = now.cop[0] - place - away
    return np.array([[place[0] + x + turn * y, place[1] + y - turn * x]])
