"""Inverse kinematics: standing with both feet flat at a double support."""

from __future__ import annotations

import casadi as ca
import numpy as np
import shapely
from numpy.typing import NDArray

from shoecal_core.errors import ShoecalError
from shoecal_core.model.double_support import DoubleSupport
from shoecal_core.model.robot import Robot
from shoecal_core.model.standing import feet_gap
from shoecal_core.planning.legs import FootPose, LegExpressions, Legs
from shoecal_core.planning.settings import PlannerSettings
from shoecal_core.planning.support_phase import SupportPhase

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
"""m, rad, share of a torque limit above 1 N m; a posture that violates its constraints by more than
this is none. IPOPT relaxes bounds in proportion to them."""


_ASIDE = 0.008
"""m; on one foot the CoP may be so far from its middle where this spares the motors."""
_UPRIGHT_WEIGHT = 5.0
"""Of an upright torso, against joint angles near the nominal ones."""
_ASIDE_WEIGHT = 100.0
"""1/m^2, of that against joint angles near the nominal ones."""


class UnreachableError(ShoecalError):
    """Feet on which the robot cannot stand within its margins.

    Attributes:
        support: the double support asked for, or that of the feet while one is in the air.
        miss: what is left between feet or CoP and where they should be [m, rad].
        overload: torque of a motor beyond its share [N m].
    """

    def __init__(
        self,
        robot: str,
        support: DoubleSupport,
        miss: float,
        overload: float,
        support_phase: SupportPhase = SupportPhase.BOTH,
    ) -> None:
        self.support = support
        self.miss = miss
        self.overload = overload
        on = (
            ""
            if support_phase is SupportPhase.BOTH
            else f" on its {support_phase.value} foot alone"
        )
        super().__init__(
            f"robot '{robot}' cannot stand{on} with the right foot at dx {support.dx:g} m, "
            f"dy {support.dy:g} m, dtheta {support.dtheta:g} rad (misses by {miss:.2g} m or rad, "
            f"torque too large by {max(0.0, overload):.2g} N m); choose feet nearer to the neutral "
            "stance, or change joint_margin, stance_margin, knee_margin or torque_share"
        )


class FeetOverlapError(UnreachableError):
    """A double support in which one foot would stand on the other."""

    def __init__(self, robot: str, support: DoubleSupport) -> None:
        self.support, self.miss, self.overload = support, 0.0, 0.0
        ShoecalError.__init__(
            self,
            f"robot '{robot}': the outlines of the feet overlap with the right foot at dx "
            f"{support.dx:g} m, dy {support.dy:g} m, dtheta {support.dtheta:g} rad; choose a place "
            "farther from the left foot",
        )


class StanceSolver:
    """Inverse kinematics of one robot, written out once for all its stances."""

    def __init__(self, legs: Legs, settings: PlannerSettings) -> None:
        self._legs = legs
        # A way to the CoP ends within the radius of it.
        self._kept_from_edge = settings.one_foot_margin + settings.landmark_radius
        self._lower, self._upper = legs.bounds(settings, settings.stance_margin)
        robot = legs.robot
        self._torque = robot.effort_limit[robot.legs] * settings.torque_share
        terms = LegExpressions(robot)
        target = ca.SX.sym("target", 2)
        cost = ca.sumsqr(terms.angles - legs.nominal)
        cost += _UPRIGHT_WEIGHT * ca.sumsqr(terms.lean)
        cost += _ASIDE_WEIGHT * ca.sumsqr(terms.cop - target)
        parameters = ca.vertcat(terms.foot_pose, terms.share, target, terms.others)
        constraints = ca.vertcat(terms.torques, terms.cop - target, terms.foot_error)
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
            UnreachableError: when no posture within the margins does it, or the feet overlap.
        """
        robot = self._legs.robot
        if not feet_gap(robot, support) > 0.0:
            raise FeetOverlapError(robot.name, support)
        target = middle(robot, support) if cop_target is None else cop_target
        return self._solved(FootPose.of(support), SupportPhase.BOTH, target, 0.0, robot.posture)

    def solve_on_one(
        self, foot_pose: FootPose, support_phase: SupportPhase, others: FloatArray
    ) -> FloatArray:
        """Leg angles (k,) [rad] of standing on one foot, the other one anywhere in the air.

        The CoP is near the middle of the foot that carries.

        Args:
            foot_pose: of the right sole in the left sole's frame.
            support_phase: the foot.
            others: (m,) all joint angles, of which those beside the legs count [rad].

        Raises:
            UnreachableError: when no posture within the margins does it.
        """
        polygon = support_phase.polygon(self._legs.robot, foot_pose)
        centre = polygon.centroid
        room = (polygon.exterior.distance(centre) - self._kept_from_edge) / np.sqrt(2.0)
        target = np.array([centre.x, centre.y])
        return self._solved(foot_pose, support_phase, target, np.clip(room, 0.0, _ASIDE), others)

    def _solved(
        self,
        foot_pose: FootPose,
        support_phase: SupportPhase,
        target: FloatArray,
        aside: float,
        others: FloatArray,
    ) -> FloatArray:
        bounds = np.concatenate([self._torque, [aside, aside], np.zeros(6)])
        result = self._solver(
            x0=np.clip(self._legs.nominal, self._lower, self._upper),
            p=np.concatenate([foot_pose.parameters, support_phase.share, target, others]),
            lbx=self._lower,
            ubx=self._upper,
            lbg=-bounds,
            ubg=bounds,
        )
        # IPOPT relaxes bounds by rounding; inside is inside.
        angles: FloatArray = np.clip(np.array(result["x"]).ravel(), self._lower, self._upper)
        beyond = np.abs(np.array(result["g"]).ravel()) - bounds
        if not np.all(beyond < _RESIDUAL * np.maximum(bounds, 1.0)):
            miss, overload = float(beyond[-8:].max()), float(beyond[:-8].max())
            raise UnreachableError(
                self._legs.robot.name, foot_pose.support, miss, overload, support_phase
            )
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
