"""What every adapter does: take trajectories that may be followed, stop when they may no more."""

from __future__ import annotations

import time
from abc import abstractmethod
from typing import Any

import numpy as np
from numpy.typing import NDArray
from sensor_msgs.msg import JointState
from trajectory_msgs.msg import JointTrajectory as JointTrajectoryMsg

from shoecal_core.errors import ShoecalError
from shoecal_core.model.joint_trajectory import JointTrajectory
from shoecal_ros.common import qos
from shoecal_ros.common.codes import Code, Problem
from shoecal_ros.common.conversions import trajectory_from_ros
from shoecal_ros.common.health import Condition
from shoecal_ros.common.hold import LONGEST_S, is_hold
from shoecal_ros.common.node import ShoecalNode
from shoecal_ros.common.robot_files import RobotFiles
from shoecal_ros.inputs.armed_input import ArmedInput
from shoecal_ros.inputs.joints import JointInput

FloatArray = NDArray[np.float64]
STALE_S = 0.5


class Adapter(ShoecalNode):
    """Between `joint_trajectory` and a robot's driver.

    Nothing is sent before somebody has armed the robot. A robot on its way that is armed no more is
    stopped by the adapter itself, once; a command to hold, which whoever disarms a moving robot
    sends just after that, only lets it do so at once: where it says to hold does not count then.

    Attributes:
        robot: whose joints are told.
        joints: what the robot tells of them.
    """

    def __init__(self, name: str) -> None:
        super().__init__(name)
        self.robot = self.settings(RobotFiles).load_robot()
        self.joints = JointInput(self.robot, STALE_S)
        self.subscribe(JointState, "joint_states", self._hear, qos.NEWEST)
        self._arming = ArmedInput(self)
        self._moves = False
        self._disarmings = 0
        self._refused: Problem | None = None
        self.trouble: Problem | None = None
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

    def watch(self) -> None:
        """Stop what may move no more, and tell how things are."""
        armed = self._arming.armed
        # Armed again is not allowed to go on: who disarms and arms at once wants it stopped, too.
        if not armed or self._arming.disarmings != self._disarmings:
            self._stop()
        problem = self._refused or self.trouble or self.joints.problem
        state = "armed" if armed else "not armed"
        self.health.note("robot", Condition.of(problem, state))
        super().watch()

    def close(self) -> None:
        """Leave no robot on its way."""
        self._stop()

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
                self._refused = None
            except ShoecalError as error:
                told = f"trajectory refused: {error}"
                self._refused = Problem(Code.TRAJECTORY_REFUSED, told)

    def _admit(self, trajectory: JointTrajectory) -> None:
        latest = self.joints.latest
        if latest is None:
            raise ShoecalError(str(self.joints.problem))
        measured: FloatArray = latest.angles[0]
        # A robot that tells nothing more may still be stopped, and so may one that is not armed.
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
        self.follow(trajectory, measured)
        # What holds some joints, or takes long, is a motion that may have to be stopped.
        moved = {self.robot.joint_names[joint] for joint in self.robot.moved}
        rests = holds and moved <= set(trajectory.names) and trajectory.duration <= LONGEST_S
        self._moves, self._disarmings = not rests, self._arming.disarmings
