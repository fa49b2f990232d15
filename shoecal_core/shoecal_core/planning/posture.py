"""Inverse kinematics: standing with both feet flat at a double support."""

from __future__ import annotations

import casadi as ca
import numpy as np
import shapely
from numpy.typing import NDArray

from shoecal_core.errors import ShoecalError
from shoecal_core.model.double_support import DoubleSupport
from shoecal_core.model.robot import Robot
from shoecal_core.planning.legs import FootPose, LegExpressions, Legs
from shoecal_core.planning.settings import PlannerSettings

FloatArray = NDArray[np.float64]

_OPTIONS: dict[str, bool | int | float | str] = {
    "print_time": False,
    "ipopt.print_level": 0,
    "ipopt.sb": "yes",
    "ipopt.max_iter": 45,
    "ipopt.tol": 1e-9,
    "ipopt.mu_init": 1e-2,
}
_RESIDUAL = 1e-7
"""m, rad, N m; a posture that violates its constraints by more than this is none."""


class UnreachableError(ShoecalError):
    """A double support in which the robot cannot stand within its margins.

    Attributes:
        support: the one asked for.
        miss: what is left between feet or CoP and where they should be [m, rad].
        overload: torque of a motor beyond its share [N m].
    """

    def __init__(self, robot: str, support: DoubleSupport, miss: float, overload: float) -> None:
        self.support = support
        self.miss = miss
        self.overload = overload
        super().__init__(
            f"robot '{robot}' cannot stand with the right foot at dx {support.dx:g} m, "
            f"dy {support.dy:g} m, dtheta {support.dtheta:g} rad (misses by {miss:.2g} m or rad, "
            f"torque too large by {max(0.0, overload):.2g} N m); choose feet nearer to the neutral "
            "stance, or change joint_margin, stance_margin, knee_margin or torque_share"
        )


class StanceSolver:
    """Inverse kinematics of one robot, compiled once for every double support."""

    def __init__(self, legs: Legs, settings: PlannerSettings) -> None:
        self._legs = legs
        self._lower, self._upper = legs.bounds(settings, settings.stance_margin)
        robot = legs.robot
        self._torque = robot.effort_limit[robot.legs] * settings.torque_share
        terms = LegExpressions(robot)
        target = ca.SX.sym("target", 2)
        torques = ca.substitute(terms.torques, terms.share, ca.SX([0.0, 1.0]))
        cost = ca.sumsqr(terms.angles - legs.nominal)
        cost += settings.upright_weight * ca.sumsqr(terms.lean)
        parameters = ca.vertcat(terms.foot_pose, target, terms.others)
        constraints = ca.vertcat(torques, terms.foot_error, terms.cop - target)
        problem = {"x": terms.angles, "p": parameters, "f": cost, "g": constraints}
        self._solver = ca.nlpsol("stance", "ipopt", problem, _OPTIONS)

    def solve(self, support: DoubleSupport, cop_target: FloatArray | None = None) -> FloatArray:
        """Leg angles (k,) [rad]: both feet flat, torso upright, knees bent, motors not strained.

        The posture is the one nearest to the robot's own; the other joints stand as there.

        Args:
            support: where the right foot is.
            cop_target: (2,) CoP in the left sole's frame [m]; the middle between the sensing
                polygons where not given.

        Raises:
            UnreachableError: when no posture within the margins does it.
        """
        robot = self._legs.robot
        target = middle(robot, support) if cop_target is None else cop_target
        start = np.clip(self._legs.nominal, self._lower, self._upper)
        result = self._solver(
            x0=start,
            p=np.concatenate([FootPose.of(support).parameters, target, robot.posture]),
            lbx=self._lower,
            ubx=self._upper,
            lbg=np.concatenate([-self._torque, np.zeros(8)]),
            ubg=np.concatenate([self._torque, np.zeros(8)]),
        )
        # IPOPT relaxes bounds by rounding; inside is inside.
        angles: FloatArray = np.clip(np.array(result["x"]).ravel(), self._lower, self._upper)
        values = np.array(result["g"]).ravel()
        miss = float(np.abs(values[-8:]).max())
        overload = float((np.abs(values[:-8]) - self._torque).max())
        if not max(miss, overload) < _RESIDUAL:
            raise UnreachableError(robot.name, support, miss, overload)
        return angles


def stance(
    robot: Robot,
    support: DoubleSupport,
    settings: PlannerSettings | None = None,
    cop_target: FloatArray | None = None,
) -> FloatArray:
    """As StanceSolver.solve, for a single call: leg angles (k,) [rad]."""
    solver = StanceSolver(Legs(robot), settings or PlannerSettings())
    return solver.solve(support, cop_target)


def middle(robot: Robot, support: DoubleSupport) -> FloatArray:
    """(2,) midpoint between the centres of both sensing polygons, left sole's frame [m]."""
    left, right = (
        np.array(shapely.Polygon(foot.sensing_polygon).centroid.coords[0]) for foot in robot.feet
    )
    centre: FloatArray = (left + support.right_to_left(right)) / 2.0
    return centre
