"""Values and derivatives of everything that the states of a horizon pursue and keep."""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca
import numpy as np

from shoecal_core.arrays import FloatArray
from shoecal_core.planning.horizon.collocation import Collocation
from shoecal_core.planning.horizon.problem import (
    FOOT_ROWS,
    TASKS,
    HorizonProblem,
    Limits,
    Scene,
    StateValues,
)
from shoecal_core.planning.legs import BALANCE
from shoecal_core.robot.symbolic import evaluate


@dataclass(frozen=True)
class Linearised:
    """N states, and what changes with them to first order.

    Attributes:
        states: (N, k) leg angles [rad].
        values: of the states.
        tasks, foot: (N, 5, k), (N, 6, k) slopes.
        rest: (N, p + 5 + k, k) slopes of capsule distances, balance and torques.
    """

    states: FloatArray
    values: StateValues
    tasks: FloatArray
    foot: FloatArray
    rest: FloatArray


class Linearisation:
    """Derivatives of one robot's states; holding one means that they have been written out."""

    def __init__(self, collocation: Collocation) -> None:
        self._collocation = collocation
        given, rows = _expressions(collocation)
        slopes = ca.densify(ca.jacobian(rows, given[0]))
        self._shape = slopes.shape
        # CasADi stores by columns.
        self._slopes = ca.Function(
            "state_slopes",
            [ca.vertcat(*given)],
            [ca.vertcat(rows, ca.vec(slopes.T))],
        )

    def __call__(self, states: FloatArray, scene: Scene) -> Linearised:
        """Of states (N, k) [rad] in their scenes."""
        count, size = self._shape
        found = evaluate(self._slopes, self._collocation.inputs(states, scene))
        slopes = found[:, count:].reshape(len(states), count, size)
        foot = TASKS + FOOT_ROWS
        return Linearised(
            states=states,
            values=StateValues.of_rows(found[:, :count], size),
            tasks=slopes[:, :TASKS],
            foot=slopes[:, TASKS:foot],
            rest=slopes[:, foot:],
        )


class Curvature:
    """Second derivatives of what is pursued and of the foot transform, weighted and summed.

    Those of capsule distances and torques are left out: they matter little, and are most of the
    work. Holding one means that they have been written out.
    """

    def __init__(self, collocation: Collocation) -> None:
        self._collocation = collocation
        given, rows = _expressions(collocation)
        prices = ca.SX.sym("prices", TASKS + FOOT_ROWS)
        second = ca.hessian(ca.dot(prices, rows[: TASKS + FOOT_ROWS]), given[0])[0]
        self._second = ca.Function(
            "state_curvature",
            [ca.vertcat(*given, prices)],
            [ca.vec(ca.densify(second))],
        )

    def __call__(self, states: FloatArray, scene: Scene, prices: FloatArray) -> FloatArray:
        """(N, k, k) of states (N, k) [rad] in their scenes, with prices (N, 11) of the rows."""
        count, size = states.shape
        given = np.hstack([self._collocation.inputs(states, scene), prices])
        return evaluate(self._second, given).reshape(count, size, size)


class Inequalities:
    """What the states of one problem keep, in rows.

    Edges, distances, balance, torques, limits, moves.

    Attributes:
        scene: that they belong to.
        low, high: (N, r) bounds of the rows.
    """

    def __init__(self, problem: HorizonProblem, limits: Limits) -> None:
        self.scene = problem.scene
        self._start = problem.start
        shape = limits.lower.shape
        torque, move = (
            np.broadcast_to(bound, shape) for bound in (limits.torque, limits.transition)
        )
        edges = np.broadcast_to(limits.offsets, (shape[0], limits.offsets.shape[1]))
        free_edges = np.full_like(edges, np.inf)
        bounded_below = np.hstack([limits.clearances, limits.balance])
        free_above = np.full_like(bounded_below, np.inf)
        self.low = np.hstack([-free_edges, bounded_below, -torque, limits.lower, -move])
        self.high = np.hstack([edges, free_above, torque, limits.upper, move])

    def values(self, linear: Linearised) -> FloatArray:
        """(N, r) of the rows, in their units [m, N, N m, rad]."""
        states = linear.states
        values = np.empty_like(self.low)
        pairs, size = linear.values.distances.shape[1], states.shape[1]
        edges = values.shape[1] - pairs - BALANCE - 3 * size
        values[:, :edges] = self.scene.beyond(linear.values.cop)
        values[:, edges : edges + pairs] = linear.values.distances
        values[:, edges + pairs : -3 * size] = linear.values.balance
        values[:, -3 * size : -2 * size] = linear.values.torques
        values[:, -2 * size : -size] = states
        values[0, -size:] = states[0] - self._start
        values[1:, -size:] = states[1:] - states[:-1]
        return values

    def violation(self, linear: Linearised) -> float:
        """Largest one, the foot transform's included [m, rad, N m]."""
        values = self.values(linear)
        foot = float(np.abs(linear.values.foot_error).max())
        return max(foot, float((self.low - values).max()), float((values - self.high).max()))


def _expressions(collocation: Collocation) -> tuple[list[ca.SX], ca.SX]:
    """What a state's values take, and the values."""
    state = collocation.state
    given = [ca.SX.sym(state.name_in(i), state.size1_in(i)) for i in range(state.n_in())]
    rows: ca.SX = ca.vertcat(*state.call(given))
    return given, rows
