"""The one entry point: a support or measured joint angles in, a checked motion out."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence
from functools import cached_property

import numpy as np
import shapely

from shoecal_core.arrays import FloatArray
from shoecal_core.errors import ShapeError
from shoecal_core.planning.checking.body_track import track
from shoecal_core.planning.checking.check import check_motion
from shoecal_core.planning.checking.findings import Report
from shoecal_core.planning.deflection import deflected, sag_of_foot
from shoecal_core.planning.horizon.collocation import Collocation
from shoecal_core.planning.horizon.ipopt import IpoptSolver
from shoecal_core.planning.horizon.problem import Scene, Solver
from shoecal_core.planning.horizon.rolling import Path, PlanningError, Progress, RollingHorizon
from shoecal_core.planning.horizon.sqp import SqpSolver
from shoecal_core.planning.legs import FootPose, Legs
from shoecal_core.planning.motion import Motion, timed
from shoecal_core.planning.motion_catalogue import PUT_DOWN, InitialStance, motion_kind
from shoecal_core.planning.posture import StanceSolver
from shoecal_core.planning.segment import MotionSegment
from shoecal_core.planning.settings import PlannerSettings
from shoecal_core.planning.support_phase import SupportPhase
from shoecal_core.planning.swing import lifted, stance_foot
from shoecal_core.robot.double_support import DoubleSupport
from shoecal_core.robot.robot import Robot

_PACES = (1.0, 0.85, 0.7)
"""Factors on all speeds that are tried in turn."""


class StartError(PlanningError):
    """A robot that does not stand as a motion must begin."""


class Planner:
    """Plans motions of one robot; holding one means that its problem has been written out.

    Attributes:
        legs: what moves.
        settings: of planning.
        horizon: of the rolling optimisation.
    """

    def __init__(self, robot: Robot, settings: PlannerSettings) -> None:
        self.legs = Legs(robot)
        self.settings = settings
        self.horizon = _rolling(self.legs, settings)
        self._stance = StanceSolver(self.legs, settings)

    def stance(self, support: DoubleSupport) -> FloatArray:
        """(m,) all joint angles of standing in a double support [rad]; see StanceSolver."""
        return self.legs.robot.from_legs(self._stance.solve(support))

    def require_one_foot(self, support: DoubleSupport) -> None:
        """Nothing, where the robot can have all its weight on one foot of a double support.

        Raises:
            UnreachableError: when it can on neither.
        """
        self._stance.require_one_foot(support, self.legs.robot.posture)

    def with_sag(
        self, ends: Sequence[FootPose], support_phase: SupportPhase, others: FloatArray
    ) -> PlannerSettings:
        """Settings whose lift and clearance of a step are larger by what deflection takes of them.

        Args:
            ends: of the step, both feet on the floor.
            support_phase: the foot that stands during the step.
            others: (m,) all joint angles, of which those outside the legs count [rad].

        Raises:
            UnreachableError: when the robot cannot stand on that foot.
        """
        robot, settings, taken = self.legs.robot, self.settings, [(0.0, 0.0)]
        for end in ends:
            up = lifted(end, support_phase, settings.step_lift)
            legs = self._stance.solve_on_one(up, support_phase, others)
            posture = robot.from_legs(legs, others)[None]
            torques = track(robot, posture, support_phase.share).torques
            true = self.legs.foot_pose(deflected(robot, posture, torques)[0])
            taken.append(sag_of_foot(robot, up, true, support_phase))
        drop, inward = (max(column) for column in zip(*taken, strict=True))
        return dataclasses.replace(
            settings,
            step_lift=settings.step_lift + drop,
            step_clearance=settings.step_clearance + inward,
        )

    def plan(
        self,
        support: DoubleSupport,
        motion: str = "landmarks",
        *,
        progress: Callable[[Progress], None] = lambda _: None,
        canceled: Callable[[], bool] = lambda: False,
    ) -> Motion:
        """A checked motion that begins at the stance of a double support.

        Raises:
            UnreachableError: when the robot cannot stand there.
            PlanningError, PlanningCanceledError, CheckFailedError: when there is no motion.
            NameNotFoundError: for a motion that is not in the catalogue.
        """
        return self.plan_from(self.stance(support), motion, progress=progress, canceled=canceled)

    def plan_from(
        self,
        joint_angles: FloatArray,
        motion: str = "landmarks",
        *,
        progress: Callable[[Progress], None] = lambda _: None,
        canceled: Callable[[], bool] = lambda: False,
    ) -> Motion:
        """A checked motion from measured joint angles (m,) [rad].

        The feet stay where these angles say they are. A start a little outside the margins is
        led back inside gently.

        Raises:
            StartError: when the robot does not stand on both feet (`put_down`: on one), or
                leans too far.
            Else as `plan`.
        """
        kind = motion_kind(motion)
        at = self.standing_on_one(joint_angles) if kind.on_one else self.standing(joint_angles)
        segments = kind.segments(at)
        return self.follow(joint_angles, motion, segments, progress=progress, canceled=canceled)

    def follow(
        self,
        joint_angles: FloatArray,
        name: str,
        segments: Sequence[MotionSegment],
        *,
        progress: Callable[[Progress], None] = lambda _: None,
        canceled: Callable[[], bool] = lambda: False,
    ) -> Motion:
        """A checked motion along segments, one after another, from all joint angles (m,) [rad].

        A motion that its check finds too fast is done more slowly. One that does not pass for
        another reason is planned once more in finer steps, and where that is not enough in finer
        ones still, unless a foot is on its way in it: where the CoP turns round at a landmark, a
        motion leaves what its states keep by a quarter then between two of them.

        Raises:
            PlanningError, PlanningCanceledError, CheckFailedError: when there is no motion.
        """
        if not segments:
            raise PlanningError(f"motion '{name}' has no parts; give at least one")

        def checked(horizon: RollingHorizon) -> tuple[Motion, Report]:
            parts = self._parts(horizon, joint_angles, segments, progress, canceled)
            for pace in _PACES:
                paced = horizon.collocation.settings.paced(pace)
                found = timed(self.legs, parts, name, joint_angles, paced)
                seen = check_motion(self.legs, found, self.settings)
                if not seen.too_fast:
                    break
            return found, seen

        planned, report = checked(self.horizon)
        if not report.kept and not any(segment.moving for segment in segments):
            planned, report = checked(self._finer)
            if not report.kept:
                planned, report = checked(self._finest)
        report.require()
        return planned

    @cached_property
    def _finer(self) -> RollingHorizon:
        return _rolling(self.legs, self.settings.finer())

    @cached_property
    def _finest(self) -> RollingHorizon:
        return _rolling(self.legs, self.settings.finer().finer())

    def _parts(
        self,
        horizon: RollingHorizon,
        joint_angles: FloatArray,
        segments: Sequence[MotionSegment],
        progress: Callable[[Progress], None],
        canceled: Callable[[], bool],
    ) -> list[tuple[MotionSegment, Path]]:
        """Every segment with its path, each from where the one before has ended."""
        parts: list[tuple[MotionSegment, Path]] = []
        start = joint_angles[self.legs.robot.legs]
        landmarks, states = sum(len(segment.targets) for segment in segments), 0
        before = 0

        def report(now: Progress) -> None:
            progress(Progress(before + now.landmark, landmarks, states + now.steps, now.distance))

        for segment in segments:
            path = horizon.roll(start, segment, joint_angles, progress=report, canceled=canceled)
            parts.append((segment, path))
            start = path.states[-1]
            before, states = before + len(segment.targets), states + len(path.states) - 1
        return parts

    def standing(self, joint_angles: FloatArray) -> InitialStance:
        """What all joint angles (m,) [rad] of a robot on both feet say.

        Raises:
            StartError: when it does not stand on both feet, or leans too far.
        """
        foot_pose = self._measured(joint_angles)
        _, height = stance_foot(foot_pose)
        if height > self.settings.sole_height:
            raise StartError(
                f"one sole is {1e3 * height:.1f} mm above the other (sole_height "
                f"{1e3 * self.settings.sole_height:g} mm); a robot on one foot puts the other one "
                f"down by the motion '{PUT_DOWN}', else check the joint offsets"
            )
        return self._standing(joint_angles, foot_pose, SupportPhase.BOTH)

    def standing_on_one(self, joint_angles: FloatArray) -> InitialStance:
        """What all joint angles (m,) [rad] of a robot that was stopped on one foot say.

        Raises:
            StartError: when it stands on both feet, or leans too far.
        """
        foot_pose = self._measured(joint_angles)
        support_phase, height = stance_foot(foot_pose)
        if height <= self.settings.sole_height:
            raise StartError(
                f"both feet stand (one sole is {1e3 * height:.1f} mm above the other); there is "
                "none to put down"
            )
        return self._standing(joint_angles, foot_pose, support_phase)

    def _measured(self, joint_angles: FloatArray) -> FootPose:
        """The pose between the soles, level to each other."""
        robot, settings = self.legs.robot, self.settings
        if joint_angles.shape != robot.posture.shape:
            raise ShapeError("joint angles", f"({len(robot.posture)},)", joint_angles.shape)
        if not np.all(np.isfinite(joint_angles)):
            raise StartError("joint angles that are not finite numbers; wait for all joints")
        pose = self.legs.foot_pose(joint_angles)
        tilt = float(np.arccos(np.clip(pose.rotation[2, 2], -1.0, 1.0)))
        if tilt > settings.sole_tilt:
            raise StartError(
                f"the soles are tilted by {tilt:.3f} rad against each other (sole_tilt "
                f"{settings.sole_tilt:g} rad); let the robot stand flat, or check the joint offsets"
            )
        return pose

    def _standing(
        self, joint_angles: FloatArray, foot_pose: FootPose, support_phase: SupportPhase
    ) -> InitialStance:
        robot = self.legs.robot
        polygon = support_phase.polygon(robot, foot_pose)
        cop = self.legs.cop(joint_angles[None])[0]
        beyond = polygon.distance(shapely.Point(cop))
        if beyond > 0.0:
            raise StartError(
                f"the CoM is {1e3 * beyond:.1f} mm outside the sensing polygon of the feet that "
                "stand; let the robot stand upright first"
            )
        scene = Scene.of(polygon, 0.0, foot_pose, joint_angles, support_phase.share)

        def tasks(leg_angles: FloatArray) -> FloatArray:
            """(5,) CoP [m], lean, height [m] at leg angles (k,) [rad]."""
            found: FloatArray = self.horizon.collocation.evaluate(leg_angles[None], scene).tasks[0]
            return found

        def on_one(pose: FootPose, foot: SupportPhase) -> FloatArray:
            """(5,) the same, standing on one foot."""
            return tasks(self._stance.solve_on_one(pose, foot, joint_angles))

        def within_reach(places: FloatArray) -> FloatArray:
            """(L, 2) places for the CoP, moved in to where it can be [m]."""
            return self._stance.within_reach(foot_pose, places, joint_angles)

        now = tasks(joint_angles[robot.legs])
        return InitialStance(
            robot, self.settings, foot_pose, now, on_one, within_reach, support_phase
        )


def _rolling(legs: Legs, settings: PlannerSettings) -> RollingHorizon:
    """One horizon's problem written out, with its solvers."""
    collocation = Collocation(legs, settings)
    return RollingHorizon(collocation, _solvers(collocation))


def _solvers(collocation: Collocation) -> list[Solver]:
    """The one that is set, and the reference where the fast one fails."""
    reference = IpoptSolver(collocation)
    if collocation.settings.solver == "ipopt":
        return [reference]
    return [SqpSolver(collocation), reference]
