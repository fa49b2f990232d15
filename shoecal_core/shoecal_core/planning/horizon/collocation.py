"""The optimisation over one horizon (paper, equations 9 to 14).

    minimise    sum |c[i] - c_ref|^2_Qc + |u[i] - u[i-1]|^2_Qu
    subject to  q[i] = q[i-1] + u[i-1]              state
                c[i] = CoP(q[i]) in SP              stability
                q_min < q[i] < q_max                joint limits
                Dist(q[i]) > d_min                  collision
                TF(q[i]) = T0                       foot transform
                |u[i]| < joint speed * step time
                |torque(q[i])| < torque limit
                load(q[i]) > least load             of each foot that stands
                |sideways force(q[i])| < friction * load(q[i])
                tilt(q[i]) < largest tilt           of the torso

The last five are not the paper's: a small robot's motors are slow and weak, and a foot without load
slips. Loads, sideways forces and torques are those of load_sharing; loads and torques keep half the
width of their interval as a margin. For motions that the paper does not have, the torso's lean and
height may be pursued with the CoP, and polygon and foot transform may change from state to state:
so a foot is lifted, carried and put down.

The transitions u are differences of states, so the states alone are unknowns and the state
equation holds exactly. Solvers stand behind one protocol; what they return is certified here.
"""

from __future__ import annotations

import casadi as ca
import numpy as np

from shoecal_core.arrays import FloatArray
from shoecal_core.planning.horizon.problem import (
    HorizonProblem,
    HorizonSolution,
    Limits,
    Scene,
    StateValues,
)
from shoecal_core.planning.legs import BALANCE_NAMES, LegExpressions, Legs, least_balance
from shoecal_core.planning.load_sharing import SharingSpread
from shoecal_core.planning.settings import PlannerSettings
from shoecal_core.robot.symbolic import evaluate

RECOVERY = 0.25
"""Part of a step's way used to come back inside a constraint."""

_SHIFTED, _ROLLED, _RIGHTED = 0.03, 0.005, 0.02
"""Of the weight: what of it goes from foot to foot between two states; of the weight's lever to a
foot's edge [m] and of the cosine of the torso's tilt, the same."""


class Collocation:
    """The problem of one robot and one set of settings, in functions of one state each.

    Attributes:
        legs: what moves.
        settings: weights and margins.
        state: angles, foot pose, others, share -> tasks, foot error, distances, balance, torques
            of one state.
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
            terms.balance,
            terms.torques,
        ]
        self.state = ca.Function("state", given, found, {"cse": True})
        self._rows = ca.Function(
            "state_rows", [ca.vertcat(*given)], [ca.vertcat(*found)], {"cse": True}
        )
        self._relative_jacobian = ca.Function(
            "relative_jacobian", [terms.angles, terms.others], [terms.relative_jacobian]
        )

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
        """(k,) largest |torque| of the motors, however the feet share the load [N m]."""
        robot = self.legs.robot
        torque: FloatArray = robot.effort_limit[robot.legs] * self.settings.torque_share
        return torque

    def evaluate(self, states: FloatArray, scene: Scene) -> StateValues:
        """Values of states (n, k) [rad] in their scenes."""
        return StateValues.of_rows(
            evaluate(self._rows, self.inputs(states, scene)), states.shape[1]
        )

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
        turn = RECOVERY * self.transition * steps
        way = RECOVERY * settings.com_speed * settings.step_time * steps
        # Edges that move with a foot are those of the foot that stands: of the first state.
        first = scene.first
        beyond = first.beyond(_seen_at_first(now, first)) - first.offsets
        spread = self._spread(problem.start, problem.scene)
        return Limits(
            lower=np.minimum(self.lower, problem.start + turn),
            upper=np.maximum(self.upper, problem.start - turn),
            offsets=scene.offsets + np.maximum(0.0, beyond - way),
            clearances=np.minimum(settings.capsule_clearance, now.distances[0] + way),
            balance=self._balance(scene, now, spread),
            transition=self.transition,
            torque=np.maximum(self.torque - spread.torque[0], np.abs(now.torques[0])),
        )

    def _spread(self, state: FloatArray, scene: Scene) -> SharingSpread:
        """Of the sharing of the load in a state (k,) [rad]; on one foot there is none."""
        robot = self.legs.robot
        if not np.ptp(scene.shares[0]):
            return SharingSpread.none(robot)
        jacobian = np.array(self._relative_jacobian(state, scene.others))
        return SharingSpread.of(robot, jacobian[None])

    def _balance(self, scene: Scene, now: StateValues, spread: SharingSpread) -> FloatArray:
        """(N, 13) least of what LegExpressions.balance lists; a start outside is led back."""
        robot = self.legs.robot
        least = least_balance(robot, self.settings, scene.loaded, spread)
        steps = np.arange(1, self.settings.horizon + 1)[:, None]
        back = RECOVERY * steps * np.repeat([_SHIFTED, _ROLLED, _RIGHTED], [4, 8, 1])
        led: FloatArray = np.minimum(least, now.balance + back)
        return led

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
        spread = self._spread(state, scene)
        least = least_balance(robot, settings, scene.first.loaded, spread)[0]
        found += [
            f"{name}: {value:.2f} of {bound:.2f} that are kept however the feet share the load"
            for name, value, bound in zip(BALANCE_NAMES, now.balance[0], least, strict=True)
            if value < bound - settings.tolerance
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
    ) -> tuple[float, float]:
        """Cost (equation 9) and largest violation of any constraint [m, rad, N m] of states (N, k).

        The violation is zero or more.
        """
        values = self.evaluate(states, problem.scene)
        moves = self.transitions(problem, states)
        excess = [
            np.abs(values.foot_error),
            problem.scene.beyond(values.cop) - limits.offsets,
            limits.lower - states,
            states - limits.upper,
            limits.clearances - values.distances,
            limits.balance - values.balance,
            np.abs(values.torques) - limits.torque,
            np.abs(moves) - limits.transition,
        ]
        worst = max(float(part.max()) for part in excess if part.size)
        return self.cost(problem, states, values), max(0.0, worst)

    def certified(
        self,
        problem: HorizonProblem,
        states: FloatArray,
        status: str,
        iterations: int,
        done: bool,
        limits: Limits | None = None,
    ) -> HorizonSolution:
        """A solution with its own evidence.

        Args:
            problem: that is solved.
            states: (N, k) [rad].
            status: of the solver.
            iterations: that it took.
            done: the solver's own word.
            limits: of the problem, where they are known.
        """
        cost, violation = np.inf, np.inf
        if np.all(np.isfinite(states)):
            cost, violation = self.assess(problem, limits or self.limits(problem), states)
        return HorizonSolution(
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
