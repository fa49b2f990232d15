"""Plans in the worker, sends trajectories and watches them done; whatever asks for it."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from typing import TypeVar

import numpy as np
from shoecal_msgs.action import Plan

from shoecal_core.arrays import FloatArray
from shoecal_core.errors import NameNotFoundError, ShoecalError
from shoecal_core.planning.checking.findings import CheckFailedError
from shoecal_core.planning.horizon.rolling import PlanningCanceledError, PlanningError, Progress
from shoecal_core.planning.legs import FootPose
from shoecal_core.planning.motion import Motion
from shoecal_core.planning.motion_catalogue import PUT_DOWN
from shoecal_core.planning.posture import UnreachableError
from shoecal_core.planning.swing import stance_foot
from shoecal_core.planning.timing import TimingError
from shoecal_core.robot.joint_trajectory import JointTrajectory
from shoecal_ros.common.actions import FEEDBACK_S
from shoecal_ros.common.hold import hold
from shoecal_ros.common.refusal import RefusedError
from shoecal_ros.common.renewal import TIMEOUT_S, Renewal
from shoecal_ros.common.waiting import until
from shoecal_ros.common.worker import Work
from shoecal_ros.inputs.joints import JointBatch
from shoecal_ros.planner.following import Follower, FollowingError, FollowingState
from shoecal_ros.planner.order import Mover, Order
from shoecal_ros.planner.part import StreamedPart
from shoecal_ros.planner.watch import MotionWatch

R = TypeVar("R")

ANSWER_S = 30.0
"""Wall-clock time in which cancelled planning must end."""
HELD_UP_S = 0.05
"""For longer than that no piece takes to be made (2 ms) unless the process was stopped: so long
the robot may be ahead of where it begins."""
CURE = "see that the robot's motors are on and that it listens to joint_trajectory"

_CODES: tuple[tuple[type[ShoecalError], int], ...] = (
    (PlanningCanceledError, Plan.Result.CANCELED),
    (CheckFailedError, Plan.Result.CHECK_FAILED),
    (PlanningError, Plan.Result.INFEASIBLE),
    (UnreachableError, Plan.Result.INFEASIBLE),
    (TimingError, Plan.Result.INFEASIBLE),
    (NameNotFoundError, Plan.Result.BAD_GOAL),
)


class Execution:
    """One order being carried out; refusals carry codes of `Plan.Result`.

    Attributes:
        names: of the joints that are commanded.
    """

    def __init__(self, mover: Mover, order: Order) -> None:
        self._mover = mover
        self._order = order
        self._disarmings = mover.arming.disarmings
        self._watch: MotionWatch | None = None
        self._part: StreamedPart | None = None
        self.names = tuple(mover.robot.joint_names[index] for index in mover.robot.moved)

    @property
    def following(self) -> bool:
        """Whether the robot is on a trajectory that was sent for it."""
        return self._part is not None

    # Before a motion

    def measured(self) -> FloatArray:
        """(m,) joint angles by now [rad].

        Raises:
            RefusedError: when there are none.
        """
        angles: FloatArray = self._latest().angles[0]
        return angles

    def check_ready(self) -> None:
        """Whether the robot may begin to move.

        Raises:
            RefusedError: when it is not armed, was disarmed meanwhile, has no driver that listens,
                or is too hot.
        """
        if not self._order.sends:
            return
        self._check_armed()
        listeners = self._mover.listeners
        listeners.look()
        if listeners.missing:
            raise RefusedError(Plan.Result.NOT_FOLLOWED, f"not begun: {listeners.missing}")
        moving, senses = self._mover.moving, self._mover.senses
        reason = senses.hot(moving.hot_degc - moving.cool_by) or senses.unwatched(self.measured())
        if reason is not None:
            raise RefusedError(reason.code, f"not begun: {reason.message}")

    async def planned(self, start: Callable[[], Work[R]]) -> R:
        """What a worker's work gives; the robot may be disarmed, or the order cancelled.

        Raises:
            RefusedError: when nothing comes out.
        """
        worker = self._mover.worker
        await until(lambda: self._interrupted or not worker.busy, math.inf)
        self._check_interrupted()
        work = start()
        while not work.done and not self._interrupted:
            await until(lambda: work.done or self._interrupted, FEEDBACK_S)
            if isinstance(work.progress, Progress):
                reported = work.progress
                self._order.feed(
                    "planning", reported.landmark / max(1, reported.landmarks), reported.landmark
                )
        if not work.done:
            worker.cancel()
            await until(lambda: work.done, ANSWER_S)
        self._check_interrupted()
        try:
            return work.result()
        except ShoecalError as error:
            code = next((code for kind, code in _CODES if isinstance(error, kind)), None)
            raise RefusedError(Plan.Result.FAILED if code is None else code, str(error)) from error

    def check_start(self, start: FloatArray) -> None:
        """Whether the robot still stands where a motion was planned from, (m,) [rad].

        Raises:
            RefusedError: names the joint that moved.
        """
        moved = np.abs(self.measured() - start)[self._mover.robot.moved]
        limit = self._mover.moving.start_error
        if moved.max() > limit:
            raise RefusedError(
                Plan.Result.FAILED,
                f"joint '{self.names[int(np.argmax(moved))]}' moved by {moved.max():.3f} rad "
                f"while the motion was planned (start_error {limit:g} rad); let the robot stand "
                "still and plan again",
            )

    def commanded(self, motion: Motion, ahead: FloatArray | float = 0.0) -> JointTrajectory:
        """What is sent: the joints that the planner moves; the others stay as they are.

        Args:
            motion: as planned.
            ahead: (k,) added to the leg angles [rad].
        """
        robot = self._mover.robot
        legs = motion.positions[:, robot.legs] + ahead
        positions = np.clip(robot.from_legs(legs), robot.lower, robot.upper)
        return JointTrajectory(self.names, motion.time, positions[:, robot.moved])

    # During a motion

    async def follow(self, trajectory: JointTrajectory, motion: Motion) -> None:
        """Send a trajectory and watch it done; whatever goes wrong stops the robot gently.

        It is sent piece by piece (`Renewal`), each after the robot was seen to be well.

        Args:
            trajectory: as it is sent.
            motion: as it was planned.

        Raises:
            RefusedError: why it was stopped.
        """
        moving = self._mover.moving
        planned = JointTrajectory(motion.joint_names, motion.time, motion.positions)
        seen = self._latest()
        # By the stamps of the joint angles: whose clock they follow does not matter then.
        renewal = Renewal(trajectory)
        follower = Follower(
            planned, renewal, int(seen.stamp_ns[0]), moving.follow_error, moving.follow_late
        )
        part = StreamedPart(motion, planned, renewal, follower, seen)
        if self._watch is None:
            phase = motion.phases[0].support_phase
            self._watch = MotionWatch(self._mover.senses, seen.angles[0], phase)
        self._watch.begin(motion)
        # The recorder starts before the motion does.
        self._order.feed("moving", 0.0, 0)
        self._part = part
        self._renew(part)
        while self.following:
            await self._news(part.seen)
            look = self._look(part)
            if look.verdict is not FollowingState.DOUBTFUL:
                self._renew(part)
            self._order.feed("moving", look.progress, part.landmark(look.progress))
            if look.verdict is FollowingState.ARRIVED:
                self._part = None

    def hold(self, angles: FloatArray) -> None:
        """Come to rest at all joint angles (m,) [rad]."""
        joints = self._mover.joints
        # By its stamp an adapter that was asleep meanwhile can tell that it is of before.
        stamp_ns = 0 if joints.problem or joints.latest is None else int(joints.latest.stamp_ns[0])
        self._mover.command(hold(self._mover.robot, angles, self._mover.moving.stop_time), stamp_ns)
        self._part = None

    def halt(self) -> None:
        """Stop the robot gently where it is, if it is on its way."""
        if self._part is not None:
            self._stop(self._part)

    # Inside

    def _renew(self, part: StreamedPart) -> None:
        """Send the next piece where it is due: it begins where the last one is by now.

        Joint angles from before a sleep would lead the robot back to where it was then, and so
        would a piece that was begun before it: the next joint angles bring another.
        """
        if not part.renewal.due(part.elapsed) or self._mover.awake.catches_up():
            return
        begun_s, rate = time.monotonic(), self._mover.robot_time.rate
        piece = part.renewal.piece(part.elapsed, TIMEOUT_S * rate)
        sent = self._mover.command(piece, part.stamp_ns, not_after=begun_s + HELD_UP_S)
        ended_s = time.monotonic()
        # What a stop in the midst of sending kept back had ended by its stamp when it came.
        if sent and (ended_s - begun_s) * rate <= piece.duration:
            part.sent_s = ended_s
        else:
            part.renewal.take_back()

    def _stop(self, part: StreamedPart) -> None:
        """Come to rest on the way that was checked, from where the robot is commanded to be by now.

        What was sent may have gone on since the newest joint angles, but ends at rest: a stop that
        comes late is no way back. Where it rests already it may have been moved since.
        """
        robot, stop_s = self._mover.robot, self._mover.moving.stop_time
        since_s = (time.monotonic() - part.sent_s) * self._mover.robot_time.rate
        if since_s > part.renewal.timeout_s:
            self._part = None
            return
        elapsed = max(part.elapsed, part.renewal.begun + since_s)
        path_time = part.renewal.stopped(elapsed, stop_s)
        angles = part.planned.at(np.array(path_time)).copy()
        angles[robot.moved] = part.renewal.trajectory.at(np.array(path_time))
        self.hold(angles)

    def _look(self, part: StreamedPart) -> FollowingError:
        """Take new joint angles, or whatever else has come; hold where something is wrong."""
        problem = self._mover.joints.problem
        if problem is not None:
            raise self._stopped(
                part, Plan.Result.NO_JOINT_STATES, f"stopped while moving: {problem}"
            )
        part.seen = self._latest()
        try:
            self._check_interrupted()
        except RefusedError as refusal:
            raise self._stopped(part, refusal.code, str(refusal)) from None
        missing = self._mover.listeners.missing
        if missing:
            raise self._stopped(part, Plan.Result.NOT_FOLLOWED, f"stopped: {missing}")
        self._check_time(part)
        look = part.follower.look(part.stamp_ns, part.angles)
        if look.verdict is FollowingState.LOST:
            bound = self._mover.moving.follow_error
            # Whatever keeps it off its way: it is not to go on with that.
            self.hold(part.follower.at_rest(part.angles))
            raise self._stopped(
                part,
                Plan.Result.NOT_FOLLOWED,
                f"stopped: joint '{look.joint}' is {look.error:.3f} rad off its trajectory "
                f"(follow_error {bound:g} rad); {CURE}",
            )
        if look.verdict is not FollowingState.DOUBTFUL:
            self._check_concerns(part)
        return look

    def _check_time(self, part: StreamedPart) -> None:
        """End a motion of which nothing was sent for long; the robot rests already.

        Either joint angles came late, of which `stale_s` says how late they may, or this node was
        away as long, and does not know what has become of the robot.
        """
        # Before the first piece it waits for that one.
        away_s, problem = part.elapsed - max(part.renewal.begun, 0.0), ""
        late_s = self._mover.moving.stale_s * self._mover.robot_time.rate
        if away_s < 0.0:
            problem = (
                f"stamps of joint_states went back by {-away_s:.1f} s; see what sets that clock"
            )
        elif not part.renewal.done and away_s > late_s + part.renewal.timeout_s:
            problem = (
                f"the planner or the joint angles were held up for {away_s:.1f} s, in which the "
                "robot came to rest; see that the computer is not overloaded"
            )
        if problem:
            self._part = None
            reason = f"stopped: {problem}, and ask for the motion again"
            raise self._stopped(part, Plan.Result.FAILED, reason)

    def _check_concerns(self, part: StreamedPart) -> None:
        """Stop at once, or where both feet carry again."""
        assert self._watch is not None
        elapsed = part.renewal.motion_time(part.elapsed)
        reason = self._watch.look(elapsed, part.angles)
        if reason is not None and not reason.can_wait:
            raise self._stopped(part, reason.code, f"stopped: {reason.message}")
        part.waiting = part.waiting or reason
        if part.waiting is not None and self._watch.both_carry(elapsed):
            raise self._stopped(part, part.waiting.code, f"stopped: {part.waiting.message}")

    def _stopped(self, part: StreamedPart, code: int, message: str) -> RefusedError:
        """Stop a robot that is still on its way; why, and what to do on one foot."""
        self.halt()
        feet = self._mover.kinematics.states(part.angles[None])
        foot, height = stance_foot(FootPose(feet.rotation[0], feet.translation[0]))
        if height > self._mover.planning.sole_height:
            message += f"; the robot stands on its {foot} foot: arm and plan motion '{PUT_DOWN}'"
        return RefusedError(code, message)

    async def _news(self, seen: JointBatch) -> None:
        """Wait for other joint angles than those seen, or for a reason to stop."""
        joints = self._mover.joints
        await until(
            lambda: self._interrupted or joints.problem is not None or joints.latest is not seen,
            math.inf,
        )

    @property
    def _interrupted(self) -> bool:
        return self._order.is_canceled() or (self._order.sends and not self._armed)

    @property
    def _armed(self) -> bool:
        """Armed, and never disarmed since the order came: arming again is not meant for it."""
        arming = self._mover.arming
        return arming.armed and arming.disarmings == self._disarmings

    def _check_interrupted(self) -> None:
        if self._order.is_canceled():
            raise RefusedError(Plan.Result.CANCELED, "cancelled")
        self._check_armed()

    def _check_armed(self) -> None:
        if self._order.sends and not self._armed:
            raise RefusedError(
                Plan.Result.NOT_ARMED,
                "disarmed since this was asked for: ask for it again"
                if self._mover.arming.armed
                else "not armed: call the service shoe/arm with data true first",
            )

    def _latest(self) -> JointBatch:
        joints = self._mover.joints
        if joints.problem or joints.latest is None:
            raise RefusedError(Plan.Result.NO_JOINT_STATES, str(joints.problem))
        return joints.latest
