"""What every adapter does: take trajectories that may be followed, stop when they may no more."""

from __future__ import annotations

import math
import time
from abc import abstractmethod
from typing import Any

import numpy as np
from numpy.typing import NDArray
from sensor_msgs.msg import JointState
from trajectory_msgs.msg import JointTrajectory as JointTrajectoryMsg

from shoecal_core.errors import ShoecalError
from shoecal_core.robot.joint_trajectory import JointTrajectory
from shoecal_ros.adapters.controller import FOUND_S
from shoecal_ros.adapters.unwatched import Unwatched
from shoecal_ros.common import qos
from shoecal_ros.common.codes import Code, Problem, joined
from shoecal_ros.common.conversions import trajectory_from_ros
from shoecal_ros.common.health import Condition, Level
from shoecal_ros.common.hold import LONGEST_S, is_hold
from shoecal_ros.common.node import ShoecalNode
from shoecal_ros.common.robot_files import RobotFiles
from shoecal_ros.inputs.armed_input import SHORT_LEASE_S, ArmedInput
from shoecal_ros.inputs.joints import JointInput

FloatArray = NDArray[np.float64]
STALE_S = 0.5
NOT_HEARD = "not armed: no node publishes whether it is"
REPORTED_S = 10.0
"""For so long it is reported that a trajectory was refused."""


class Adapter(ShoecalNode):
    """Between `joint_trajectory` and a robot's driver.

    Nothing is sent before somebody has armed the robot. A robot on its way that is armed no more is
    stopped by the adapter itself, once; a command to hold, which the node that disarms a moving
    robot sends just after that, only lets it do so at once: its angles do not count then.
    What an adapter before this one may have sent to a robot that is armed already is stopped, too.

    Attributes:
        robot: whose joints are commanded.
        joints: what the robot reports of them.
    """

    def __init__(self, name: str) -> None:
        super().__init__(name)
        self.robot = self.settings(RobotFiles).load_robot()
        senders = self.peers.expect_one_sender("joint_states")
        self.joints = JointInput(self.robot, STALE_S, senders=senders)
        self.subscribe(JointState, "joint_states", self._hear, qos.NEWEST)
        self._arming = ArmedInput(self, lease_s=SHORT_LEASE_S)
        self._unwatched = Unwatched(self, self._arming)
        self._moves = False
        self._disarmings = 0
        self._begun_s = self.now_s
        self._refused_s = -math.inf
        self._refusal = ""
        self._accepted = self._refused = 0
        self.subscribe(JointTrajectoryMsg, "joint_trajectory", self._take, qos.COMMAND)

    @abstractmethod
    def follow(self, trajectory: JointTrajectory, measured: FloatArray) -> None:
        """Let the robot follow a trajectory, joint angles (m,) [rad] being what they are.

        Raises:
            ShoecalError: when it cannot.
        """

    @abstractmethod
    def stop(self) -> None:
        """Let the robot stay where it is, if it is on its way."""

    @property
    @abstractmethod
    def missing(self) -> str:
        """What is missing on the robot's side, and the cure; empty where all is there."""

    @property
    def trouble(self) -> Problem | None:
        """What the robot's side does that it should not."""
        return None

    def stop_unwatched(self) -> None:
        """Stop what the robot does without this adapter; nothing where it takes set points."""

    def watch(self) -> None:
        """Stop what may move no more, and report how things are."""
        armed = self._arming.armed
        # Armed again is not allowed to go on: who disarms and arms at once wants it stopped, too.
        if not armed or self._arming.disarmings != self._disarmings:
            self._stop()
        if self._unwatched.to_be_stopped():
            self.stop_unwatched()
        known = armed or self._unwatched.judged
        well = "armed" if armed else "not armed" if known else NOT_HEARD
        self.health.note("robot", self._condition(well))
        super().watch()

    def close(self) -> None:
        """Leave no robot on its way."""
        self._stop()

    def go_on(self) -> None:
        """The robot goes on with the motion before: it did not take the last command."""
        self._moves = True
        self._unwatched.come_back()

    def _condition(self, well: str) -> Condition:
        """What lasts stands before what has happened."""
        refused = (
            Problem(Code.TRAJECTORY_REFUSED, self._refusal)
            if self.now_s - self._refused_s < REPORTED_S
            else None
        )
        errors = [problem for problem in (self.trouble, self.joints.problem, refused) if problem]
        missing = self.missing if self.now_s - self._begun_s > FOUND_S else ""
        warnings = [Problem(Code.DRIVER_MISSING, missing)] if missing else []
        reported = joined([*errors, *warnings])
        # A topic has no answer: this shows a sender whether its command was accepted.
        figures = self.joints.heard.figures() | {
            "trajectories_accepted": str(self._accepted),
            "trajectories_refused": str(self._refused),
        }
        if reported is None:
            return Condition(Level.OK, well, figures)
        level = Level.ERROR if errors else Level.WARN
        return Condition(level, reported.message, figures, code=reported.code)

    def _stop(self) -> None:
        """A robot that is coming to rest already is left to it."""
        if self._moves:
            self._moves = False
            self.stop()

    @property
    def now_s(self) -> float:
        """Monotonic wall clock: a robot's motors know no other [s]."""
        return time.monotonic()

    def _hear(self, messages: list[Any]) -> None:
        self.joints.take(messages)

    def _take(self, messages: list[Any]) -> None:
        for message in messages:
            try:
                self._admit(trajectory_from_ros(message))
                self._accepted += 1
                self._refused_s = -math.inf
            except ShoecalError as error:
                self._refused += 1
                self._refused_s, self._refusal = self.now_s, f"trajectory refused: {error}"

    def _admit(self, trajectory: JointTrajectory) -> None:
        if self._arming.disarmings != self._disarmings:
            # Even if it may move again by now, and the new one be refused.
            self._stop()
        latest = self.joints.latest
        if latest is None:
            raise ShoecalError(str(self.joints.problem))
        measured: FloatArray = latest.angles[0]
        # A robot that reports nothing more may still be stopped, and so may one that is not armed.
        holds = is_hold(trajectory, self.robot, measured)
        if not holds and self.joints.problem:
            raise ShoecalError(str(self.joints.problem))
        if not self._arming.armed:
            if not holds:
                raise ShoecalError("not armed: call the service shoe/arm first")
            self._stop()
            return
        # Who sends two angles for one motor, or some beyond its limits, is refused here.
        trajectory.full(self.robot, measured)
        if missing := self.missing:
            if holds:
                self._stop()
            raise ShoecalError(missing)
        self.follow(trajectory, measured)
        self._unwatched.replace()
        # What holds some joints, or takes long, is a motion that may have to be stopped.
        moved = {self.robot.joint_names[joint] for joint in self.robot.moved}
        rests = holds and moved <= set(trajectory.names) and trajectory.duration <= LONGEST_S
        self._moves, self._disarmings = not rests, self._arming.disarmings
