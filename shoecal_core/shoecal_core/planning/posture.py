"""Inverse kinematics: standing with both feet flat at a double support."""

from __future__ import annotations

import contextlib
from dataclasses import dataclass
from functools import cached_property

import casadi as ca
import numpy as np
import shapely

from shoecal_core.arrays import FloatArray
from shoecal_core.errors import ShoecalError
from shoecal_core.planning.legs import (
    BALANCE_EDGES,
    BALANCE_NAMES,
    FootPose,
    LegExpressions,
    Legs,
    least_balance,
)
from shoecal_core.planning.load_sharing import SharingSpread
from shoecal_core.planning.reach import BOUND, Excess, Loose
from shoecal_core.planning.settings import PlannerSettings
from shoecal_core.planning.support_phase import SupportPhase
from shoecal_core.robot.double_support import DoubleSupport
from shoecal_core.robot.robot import Robot
from shoecal_core.robot.standing import feet_gap

_OPTIONS: dict[str, bool | int | float | str] = {
    "print_time": False,
    "ipopt.print_level": 0,
    "ipopt.sb": "yes",
    "ipopt.max_iter": 200,
    "ipopt.tol": 1e-9,
    "ipopt.mu_init": 1e-2,
}
_RESERVE_ON_ONE = Loose(torque=-0.05, limits=-0.03)
"""A motion to a posture at its bounds goes beyond them between two states, and the feet never stand
quite where they should: a NAO's knee at its limit needed 2.2 % more on the way."""
_RESIDUAL = 1e-7
"""m, rad, share of a torque limit above 1 N m; a posture that violates its constraints by more than
this is none. IPOPT relaxes bounds in proportion to them."""


_ASIDE = 0.008
"""m; on one foot the CoP may be so far from its middle where this spares the motors."""
_UPRIGHT_WEIGHT = 5.0
"""Of an upright torso, against joint angles near the nominal ones."""
_ASIDE_WEIGHT = 100.0
"""1/m^2, of that against joint angles near the nominal ones."""
_INWARD_WEIGHT = 1e3
"""Of the part of the way by which a place of the CoP is moved in: the least there is counts more
than any posture."""
_RESERVE = 1.15
"""On the sharing's interval where a place is moved in: motions come there in other postures."""

_NEAR_STEPS = 10
"""Where a NAO or Wren can stand, three or four are enough."""
_NEAR_STEP = 0.3
"""rad, or of the way in; slopes hold no farther."""
_LEFT_WEIGHT = 1e4
"""Of what a step leaves unmended, from 0 to 1, against its square [rad^2]."""
_NEAR_RESERVE = 1e-5
"""m, rad, N m, share of the weight; a step aims so far inside its bounds, so as not to end at
rounding outside them."""

_FLAT_RESERVE = 0.004
"""m; of the weight's lever to the edges of the soles, for the same reason."""


class UnreachableError(ShoecalError):
    """Feet on which the robot cannot stand within its margins.

    Attributes:
        support: the double support asked for, or that of the feet while one is in the air.
        miss: what is left between feet or CoP and where they should be [m, rad].
        overload: torque of a motor beyond its share [N m].
        unbalanced: what of load, grip, tilt and clearance is not kept, for people; empty where
            all is.
    """

    def __init__(
        self,
        robot: str,
        support: DoubleSupport,
        miss: float,
        overload: float,
        support_phase: SupportPhase = SupportPhase.BOTH,
        unbalanced: str = "",
    ) -> None:
        self.support, self.miss, self.overload = support, miss, overload
        self.unbalanced = unbalanced
        on = (
            ""
            if support_phase is SupportPhase.BOTH
            else f" on its {support_phase.value} foot alone"
        )
        super().__init__(
            f"robot '{robot}' cannot stand{on} with the right foot at {support} (misses by "
            f"{miss:.2g} m or rad, torque too large by {max(0.0, overload):.2g} N m"
            f"{', ' if unbalanced else ''}{unbalanced}); choose feet nearer to the neutral "
            "stance, or change joint_margin, stance_margin, knee_margin or torque_share"
        )


class FeetOverlapError(UnreachableError):
    """A double support in which one foot would stand on the other."""

    def __init__(self, robot: str, support: DoubleSupport) -> None:
        self.support, self.miss, self.overload, self.unbalanced = support, 0.0, 0.0, ""
        ShoecalError.__init__(
            self,
            f"robot '{robot}': the outlines of the feet overlap with the right foot at {support}; "
            "choose a place farther from the left foot",
        )


@dataclass(frozen=True)
class _Task:
    """What a posture shall be.

    Attributes:
        foot_pose: of the right sole in the left sole's frame.
        support_phase: the feet that stand.
        target: (2,) place of the CoP, left sole's frame [m].
        others: (m,) all joint angles, of which those outside the legs count [rad].
        aside: how far the CoP may be from its place, forward and sideways [m].
        inward: greatest part of the way to the middle between the feet by which it may be moved.
    """

    foot_pose: FootPose
    support_phase: SupportPhase
    target: FloatArray
    others: FloatArray
    aside: float = 0.0
    inward: float = 0.0


class StanceSolver:
    """Inverse kinematics of one robot, written out once for all its stances."""

    def __init__(self, legs: Legs, settings: PlannerSettings) -> None:
        self._legs, self._settings = legs, settings
        # A way to the CoP ends within the radius of it.
        self._kept_from_edge = settings.one_foot_margin + settings.landmark_radius
        self._lower, self._upper = legs.bounds(settings, settings.stance_margin)
        robot = legs.robot
        self._torque = robot.effort_limit[robot.legs] * settings.torque_share
        terms = LegExpressions(robot)
        target, centre = ca.SX.sym("target", 2), ca.SX.sym("centre", 2)
        inward = ca.SX.sym("inward")
        place = target + inward * (centre - target)
        cost = ca.sumsqr(terms.angles - legs.nominal)
        cost += _UPRIGHT_WEIGHT * ca.sumsqr(terms.lean)
        cost += _ASIDE_WEIGHT * ca.sumsqr(terms.cop - place)
        cost += _INWARD_WEIGHT * inward
        parameters = ca.vertcat(terms.foot_pose, terms.share, target, centre, terms.others)
        rows = ca.vertcat(
            terms.balance, terms.distances, terms.torques, terms.cop - place, terms.foot_error
        )
        # Before derivatives are taken: it makes these shorter by a fifth.
        cost, rows, relative = ca.cse([cost, rows, terms.relative_jacobian])
        moved = ca.vertcat(terms.angles, inward)
        self._problem = {"x": moved, "p": parameters, "f": cost, "g": rows}
        self._rows = ca.Function(
            "rows", [moved, parameters], [rows, ca.jacobian(rows, moved), relative]
        )
        self._relative_jacobian = ca.Function(
            "relative_jacobian", [terms.angles, terms.others], [relative]
        )
        self._step_weights = ca.DM(np.diag([*np.ones(moved.numel()), _LEFT_WEIGHT]))
        every = ca.Sparsity.dense(rows.numel(), moved.numel() + 1)
        self._shortest = ca.conic(
            "shortest",
            "daqp",
            {"h": self._step_weights.sparsity(), "a": every},
            {"error_on_fail": False, "daqp": {"primal_tol": _NEAR_RESERVE / 100.0}},
        )

    @cached_property
    def _solver(self) -> ca.Function:
        # Writing its Hessian down takes long, and many stances need no optimum.
        return ca.nlpsol("stance", "ipopt", self._problem, _OPTIONS)

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
        return self._solved(self._at_middle(support, cop_target))[0]

    def near(self, support: DoubleSupport) -> FloatArray:
        """Leg angles (k,) [rad] of any posture that `solve` could have found, for less work.

        Args:
            support: where the right foot is.

        Raises:
            UnreachableError: as `solve`.
        """
        robot = self._legs.robot
        if feet_gap(robot, support) > 0.0:
            task = self._at_middle(support)
            if (found := self._near(task, self._legs.nominal)) is not None:
                return found
        return self.solve(support)

    def reaches(
        self, foot_pose: FootPose, place: FloatArray, inward: float, start: FloatArray
    ) -> bool:
        """Whether a posture near a start has the CoP at a place, however the feet share the load.

        For less work than `within_reach`, which may still find one where this finds none.

        Args:
            foot_pose: of the right sole in the left sole's frame.
            place: (2,) in the left sole's frame [m].
            inward: greatest part of the way to the middle between the feet by which it may be
                moved in.
            start: (k,) leg angles [rad].
        """
        posture = self._legs.robot.posture
        task = _Task(foot_pose, SupportPhase.BOTH, place, posture, inward=inward)
        return self._near(task, start) is not None

    def within_reach(
        self, foot_pose: FootPose, places: FloatArray, others: FloatArray
    ) -> FloatArray:
        """Places (L, 2) for the CoP on both feet, each moved in as little as needed (L, 2) [m].

        Inward is towards the middle between the feet. NaN where the robot can stand nowhere on that
        way within its margins, however the feet share the load.

        Args:
            foot_pose: of the right sole in the left sole's frame.
            places: in the left sole's frame.
            others: (m,) all joint angles, of which those outside the legs count [rad].
        """
        centre = middle(self._legs.robot, foot_pose.support)
        found = np.full(places.shape, np.nan)
        for place, row in zip(places, found, strict=True):
            task = _Task(foot_pose, SupportPhase.BOTH, place, others, inward=1.0)
            with contextlib.suppress(UnreachableError):
                row[:] = place + self._solved(task)[1] * (centre - place)
        return found

    def solve_on_one(
        self, foot_pose: FootPose, support_phase: SupportPhase, others: FloatArray
    ) -> FloatArray:
        """Leg angles (k,) [rad] of standing on one foot, the other one anywhere in the air.

        The CoP is near the middle of the foot that carries.

        Args:
            foot_pose: of the right sole in the left sole's frame.
            support_phase: the foot.
            others: (m,) all joint angles, of which those outside the legs count [rad].

        Raises:
            UnreachableError: when no posture within the margins does it.
        """
        task = self._on_one(foot_pose, support_phase, others)
        with contextlib.suppress(UnreachableError):
            return self._found(task, _RESERVE_ON_ONE)[0][:-1]
        return self._solved(task)[0]

    def _at_middle(self, support: DoubleSupport, cop_target: FloatArray | None = None) -> _Task:
        robot = self._legs.robot
        target = middle(robot, support) if cop_target is None else cop_target
        return _Task(FootPose.of(support), SupportPhase.BOTH, target, robot.posture)

    def _on_one(
        self, foot_pose: FootPose, support_phase: SupportPhase, others: FloatArray
    ) -> _Task:
        polygon = support_phase.polygon(self._legs.robot, foot_pose)
        centre = polygon.centroid
        room = (polygon.exterior.distance(centre) - self._kept_from_edge) / np.sqrt(2.0)
        target = np.array([centre.x, centre.y])
        aside = float(np.clip(room, 0.0, _ASIDE))
        return _Task(foot_pose, support_phase, target, others, aside=aside)

    def require_one_foot(self, support: DoubleSupport, others: FloatArray) -> None:
        """Nothing, where the robot can have all its weight on one foot or the other.

        Args:
            support: where both feet stand.
            others: (m,) all joint angles, of which those that are not of the legs count [rad].

        Raises:
            UnreachableError: when it can on neither.
        """
        foot_pose = FootPose.of(support)
        tasks = (
            self._on_one(foot_pose, phase, others)
            for phase in (SupportPhase.LEFT, SupportPhase.RIGHT)
        )
        if any(self._near(task, self._legs.nominal) is not None for task in tasks):
            return
        try:
            self.solve_on_one(foot_pose, SupportPhase.LEFT, others)
        except UnreachableError:
            self.solve_on_one(foot_pose, SupportPhase.RIGHT, others)

    def loosened(
        self, foot_pose: FootPose, place: FloatArray | None, inward: float, loose: Loose
    ) -> Excess | None:
        """What standing on both feet asks for beyond its bounds, where some of these are loosened.

        Args:
            foot_pose: of the right sole in the left sole's frame.
            place: (2,) of the CoP in the left sole's frame [m]; None for the middle between the
                feet.
            inward: greatest part of the way to that middle by which the place may be moved in.
            loose: the bounds that are widened.

        Returns:
            None where the widened bounds rule it out, too.
        """
        robot = self._legs.robot
        target = middle(robot, foot_pose.support) if place is None else place
        task = _Task(foot_pose, SupportPhase.BOTH, target, robot.posture, inward=inward)
        try:
            found, beyond = self._found(task, loose)
        except UnreachableError:
            return None
        count, pairs = len(BALANCE_NAMES), len(robot.collision_pairs)
        angles = found[:-1]
        return Excess(
            balance=beyond[:count],
            clearance=beyond[count : count + pairs],
            torque=beyond[count + pairs : -8],
            limits=np.maximum(self._lower - angles, angles - self._upper),
        )

    def _solved(self, task: _Task) -> tuple[FloatArray, float]:
        """Leg angles, and the part of the way to the middle by which the place is moved in."""
        found, _ = self._found(task, BOUND)
        return found[:-1], float(found[-1])

    def _found(self, task: _Task, loose: Loose) -> tuple[FloatArray, FloatArray]:
        """Leg angles and way in (k + 1,), and by how much each bound as it is is violated (r,).

        The width of the sharing's interval is that of the posture found without it, with a reserve.

        Raises:
            UnreachableError: where nothing is within the loosened bounds.
        """
        start = np.append(np.clip(self._legs.nominal, self._lower, self._upper), 0.0)
        spread = SharingSpread.none(self._legs.robot)
        found, beyond, own = self._tried(task, start, spread, loose)
        if task.inward and np.all(beyond < 0.0):
            jacobian = np.array(self._relative_jacobian(found[:-1], task.others))
            spread = SharingSpread.of(self._legs.robot, jacobian[None]).scaled(_RESERVE)
            found, beyond, own = self._tried(task, found, spread, loose)
        if not np.all(beyond < 0.0):
            raise self._unreachable(task, beyond)
        return found, own

    def _tried(
        self, task: _Task, start: FloatArray, spread: SharingSpread, loose: Loose
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Leg angles and way in (k + 1,), and by how much each constraint is violated (r,): as it
        is loosened, and as it is.
        """
        least, bounds = self._bounds(task, spread)
        torques = len(self._torque)
        asked, allowed = least.copy(), bounds.copy()
        asked[: len(BALANCE_NAMES)] -= loose.balance_share
        asked[len(BALANCE_NAMES) :] -= loose.clearance_m
        allowed[:torques] = np.maximum(0.0, loose.torque_factor * self._torque - spread.torque[0])
        lower = np.append(self._lower - loose.limits_rad, 0.0)
        upper = np.append(self._upper + loose.limits_rad, task.inward)
        result = self._solver(
            x0=start,
            p=self._parameters(task),
            lbx=lower,
            ubx=upper,
            lbg=np.concatenate([asked, -allowed]),
            ubg=np.concatenate([np.full(len(asked), np.inf), allowed]),
        )
        # IPOPT relaxes bounds by rounding; inside is inside.
        found = np.clip(np.array(result["x"]).ravel(), lower, upper)
        values = np.array(result["g"]).ravel()
        return found, _beyond(values, asked, allowed), _beyond(values, least, bounds)

    def _near(self, task: _Task, start: FloatArray) -> FloatArray | None:
        """Leg angles (k,) within all bounds, near a start (k,) [rad]; None where none are found.

        Each step is the shortest one after which all is kept, by its slope here, or as much of what
        is not kept is mended as can be. The sharing's interval is that of the posture itself, where
        `_found` wants one.
        """
        robot, parameters = self._legs.robot, self._parameters(task)
        lower, upper = np.append(self._lower, 0.0), np.append(self._upper, task.inward)
        found = np.clip(np.append(start, task.inward), lower, upper)
        spread = SharingSpread.none(robot)
        for _ in range(_NEAR_STEPS):
            values, slopes, relative = (np.array(part) for part in self._rows(found, parameters))
            values = values.ravel()
            if task.inward:
                spread = SharingSpread.of(robot, relative[None]).scaled(_RESERVE)
            least, bounds = self._bounds(task, spread)
            if np.all(_beyond(values, least, bounds) < 0.0):
                angles: FloatArray = found[:-1]
                return angles
            low = np.concatenate([least, -bounds]) - values
            high = np.concatenate([np.full(len(least), np.inf), bounds]) - values
            inside = np.minimum(_NEAR_RESERVE, (high - low) / 2.0)
            low, high = low + inside, high - inside
            left = np.clip(0.0, low, high)
            step = self._shortest(
                h=self._step_weights,
                a=np.column_stack([slopes, left]),
                lba=low,
                uba=high,
                lbx=np.append(np.maximum(lower - found, -_NEAR_STEP), 0.0),
                ubx=np.append(np.minimum(upper - found, _NEAR_STEP), 1.0),
            )
            found = np.clip(found + np.array(step["x"]).ravel()[:-1], lower, upper)
        return None

    def _parameters(self, task: _Task) -> FloatArray:
        """Of the problem, in its order."""
        centre = middle(self._legs.robot, task.foot_pose.support)
        return np.concatenate(
            [task.foot_pose.parameters, task.support_phase.share, task.target, centre, task.others]
        )

    def _bounds(self, task: _Task, spread: SharingSpread) -> tuple[FloatArray, FloatArray]:
        """Least of the first constraints (r - s,), and greatest size of the others (s,)."""
        robot, loaded = self._legs.robot, np.array([task.support_phase.feet])
        least = np.append(
            least_balance(robot, self._settings, loaded, spread)[0],
            np.full(len(robot.collision_pairs), self._settings.capsule_clearance),
        )
        if task.inward:
            least[BALANCE_EDGES] += _FLAT_RESERVE
        torque = np.maximum(0.0, self._torque - spread.torque[0])
        return least, np.concatenate([torque, np.full(2, task.aside), np.zeros(6)])

    def _unreachable(self, task: _Task, beyond: FloatArray) -> UnreachableError:
        robot = self._legs.robot
        pairs = tuple(
            f"clearance of {robot.capsules[a].name} and {robot.capsules[b].name}"
            for a, b in robot.collision_pairs
        )
        kept = (*BALANCE_NAMES, *pairs)
        unbalanced = [
            f"{what} is not kept"
            for what, excess in zip(kept, beyond[: len(kept)], strict=True)
            if excess > 0.0
        ]
        miss, overload = float(beyond[-8:].max()), float(beyond[len(kept) : -8].max())
        return UnreachableError(
            robot.name, task.foot_pose.support, miss, overload, task.support_phase,
            ", ".join(unbalanced),
        )  # fmt: skip


def _beyond(values: FloatArray, least: FloatArray, bounds: FloatArray) -> FloatArray:
    """(r,) by how much values violate a least (r - s,), or a bound of their size (s,)."""
    beyond = np.concatenate([least - values[: len(least)], np.abs(values[len(least) :]) - bounds])
    scale = np.maximum(np.concatenate([np.abs(least), bounds]), 1.0)
    scale[~np.isfinite(scale)] = 1.0
    found: FloatArray = beyond - _RESIDUAL * scale
    return found


def stance(
    robot: Robot, support: DoubleSupport, settings: PlannerSettings | None = None
) -> FloatArray:
    """As StanceSolver.solve, for a single call: leg angles (k,) [rad]."""
    return StanceSolver(Legs(robot), settings or PlannerSettings()).solve(support)


def middle(robot: Robot, support: DoubleSupport) -> FloatArray:
    """(2,) midpoint between the centres of both sensing polygons, left sole's frame [m]."""
    left, right = (
        np.array(shapely.Polygon(foot.sensing_polygon).centroid.coords[0]) for foot in robot.feet
    )
    centre: FloatArray = (left + support.right_to_left(right)) / 2.0
    return centre
