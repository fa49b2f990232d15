"""Own steps: from one double support to another, quasi-statically, one foot after the other.

The weight goes over one foot, the other one is lifted, carried and put down, and the weight goes
back between both. Each step is planned from measured joint angles, so errors do not add up.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from shoecal_core.arrays import FloatArray
from shoecal_core.planning.checking.findings import CheckFailedError
from shoecal_core.planning.horizon.rolling import PlanningError, Progress
from shoecal_core.planning.legs import FootPose
from shoecal_core.planning.motion import Motion
from shoecal_core.planning.motion_catalogue import InitialStance
from shoecal_core.planning.planner import Planner
from shoecal_core.planning.posture import UnreachableError
from shoecal_core.planning.segment import in_standing
from shoecal_core.planning.support_phase import SupportPhase
from shoecal_core.planning.swing import NoSwingPathError, swing_path, swing_segment
from shoecal_core.planning.timing import TimingError
from shoecal_core.robot.double_support import DoubleSupport

NAME = "step"
"""Of the motion."""
STEPS_MAX = 12
"""Steps to one double support; who needs more goes astray."""
_MUCH_LONGER = 1.4
"""Ways in the air whose numbers of states have this ratio."""
_NO_STEP = (PlanningError, CheckFailedError, NoSwingPathError, TimingError, UnreachableError)


class StepError(PlanningError):
    """A double support that the robot cannot step into from where it stands."""


def require_steps_left(taken: int, goal: DoubleSupport) -> None:
    """Whether a robot that has taken steps towards a double support may take another one.

    Raises:
        StepError: when it has taken STEPS_MAX.
    """
    if taken >= STEPS_MAX:
        raise StepError(
            f"not at {goal} after {STEPS_MAX} steps; let step_error be larger than what gears "
            "give, and see that the soles do not slip"
        )


class Stepper:
    """Plans steps of one robot.

    Attributes:
        planner: that plans all of a step's parts.
        support_phase: of the last step; mostly the other foot carries next, so that motors cool.
    """

    def __init__(self, planner: Planner) -> None:
        self.planner = planner
        self.support_phase = SupportPhase.RIGHT

    def step(
        self,
        joint_angles: FloatArray,
        goal: DoubleSupport,
        *,
        progress: Callable[[Progress], None] = lambda _: None,
        canceled: Callable[[], bool] = lambda: False,
    ) -> Motion | None:
        """The next step from measured joint angles (m,) [rad]; None when the feet stand there.

        It leads to the goal itself where that can be reached in one step, else to a double
        support on the way. Check by calling again when it is done.

        Raises:
            StepError: when no step leads there.
            StartError, PlanningCanceledError: as Planner.plan_from.
        """
        standing = self.planner.standing(joint_angles)
        if self.arrived(standing.foot_pose, goal):
            return None
        self._require_reach(goal)
        reasons: list[str] = []
        for via in self._ways(standing.foot_pose, goal):
            for support_phase in self._feet(standing.foot_pose, via):
                try:
                    motion = self._planned(
                        joint_angles, standing, via, support_phase, progress, canceled
                    )
                except _NO_STEP as error:
                    reasons.append(str(error))
                else:
                    self.support_phase = support_phase
                    return motion
        raise StepError(
            f"no step leads from {standing.foot_pose.support} to {goal} ({reasons[0]}); choose "
            "feet nearer to the neutral stance"
        )

    def arrived(self, foot_pose: FootPose, goal: DoubleSupport) -> bool:
        """Whether the feet stand in a double support, as well as measured angles can show."""
        settings, there = self.planner.settings, foot_pose.support
        way = float(np.hypot(there.dx - goal.dx, there.dy - goal.dy))
        return (
            way < settings.step_error and abs(there.dtheta - goal.dtheta) < settings.step_yaw_error
        )

    def _require_reach(self, goal: DoubleSupport) -> None:
        """No step towards a goal in which the robot could not stand, or not on either foot."""
        try:
            self.planner.stance(goal)
            self.planner.require_one_foot(goal)
        except UnreachableError as error:
            cure = "" if self.planner.settings.one_foot else "; or draw others: set one_foot"
            raise StepError(f"no step leads to {goal}: {error}{cure}") from error

    def _ways(self, foot_pose: FootPose, goal: DoubleSupport) -> list[DoubleSupport]:
        """Where the next step may lead, best first: there at once, or by way of neutral."""
        here = foot_pose.support
        half = DoubleSupport(
            (here.dx + goal.dx) / 2.0, (here.dy + goal.dy) / 2.0, (here.dtheta + goal.dtheta) / 2.0
        )
        ways = (goal, half, self.planner.legs.robot.neutral)
        return [via for via in ways if not self.arrived(foot_pose, via)]

    def _feet(self, foot_pose: FootPose, via: DoubleSupport) -> tuple[SupportPhase, SupportPhase]:
        """Which foot may carry, best first: the one that has rested, if that is not much longer."""
        last, rested = self.support_phase, self.support_phase.other
        robot, settings = self.planner.legs.robot, self.planner.settings
        try:
            long, short = (
                len(swing_path(robot, foot_pose, FootPose.of(via), support_phase, settings))
                for support_phase in (rested, last)
            )
        except NoSwingPathError:
            return rested, last
        return (last, rested) if long > _MUCH_LONGER * short else (rested, last)

    def _planned(
        self,
        joint_angles: FloatArray,
        standing: InitialStance,
        goal: DoubleSupport,
        support_phase: SupportPhase,
        progress: Callable[[Progress], None],
        canceled: Callable[[], bool],
    ) -> Motion:
        planner, settings = self.planner, self.planner.settings
        robot, begin, end = planner.legs.robot, standing.foot_pose, FootPose.of(goal)
        room = planner.with_sag((begin, end), support_phase, joint_angles)
        way = swing_path(robot, begin, end, support_phase, room)
        ended = planner.standing(planner.stance(goal))
        aim = in_standing(standing.on_one(end, support_phase), end, support_phase)
        segments = (
            standing.pursuing("shift", standing.on_one(begin, support_phase)[None], support_phase),
            swing_segment("swing", aim, way, support_phase, settings),
            ended.pursuing("back", ended.tasks[None], support_phase),
        )
        return planner.follow(joint_angles, NAME, segments, progress=progress, canceled=canceled)
