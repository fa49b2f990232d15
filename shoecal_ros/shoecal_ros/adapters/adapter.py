"""What every adapter does: take trajectories that may be followed, stop when they may no more."""

from __future__ import annotations

import math
import time
from abc import abstractmethod
from dataclasses import dataclass
from typing import Any

import numpy as np
from sensor_msgs.msg import JointState
from trajectory_msgs.msg import JointTrajectory as JointTrajectoryMsg

from shoecal_core.arrays import FloatArray
from shoecal_core.errors import ShoecalError
from shoecal_core.robot.joint_trajectory import JointTrajectory
from shoecal_core.settings import Settings, setting
from shoecal_ros.adapters.controller import FOUND_S
from shoecal_ros.adapters.stream import PEAK, STOP_S
from shoecal_ros.common import qos
from shoecal_ros.common.codes import Code, Problem, joined
from shoecal_ros.common.conversions import time_from_ros, trajectory_from_ros
from shoecal_ros.common.health import Condition, Level
from shoecal_ros.common.hold import LONGEST_S, is_hold
from shoecal_ros.common.node import ShoecalNode
from shoecal_ros.common.robot_files import RobotFiles
from shoecal_ros.inputs.armed_input import SHORT_LEASE_S, ArmedInput
from shoecal_ros.inputs.joints import JointBatch, JointInput

STALE_S = 0.5
NOT_HEARD = "not armed: no node publishes whether it is"
OLDEST_S = 0.2
"""An older command was meant for a robot that has moved on since."""
JOIN_RAD = 0.05
"""A trajectory that begins at once begins so near to where the robot is. More than the planner's
`start_error` of 0.03 rad, less than a robot is left behind by while pieces fail to come for a
second."""
REPORTED_S = 10.0
"""For so long it is reported that a trajectory was refused."""


@dataclass(frozen=True)
class GateSettings(Settings):
    """What no trajectory may exceed, from any sender."""

    joint_speed: float = setting(
        1.0, "rad/s", "a trajectory with a faster joint is refused; planned ones stay below 0.4",
        minimum=1e-3,
    )  # fmt: skip
    joint_acceleration: float = setting(
        20.0, "rad/s^2", "likewise of its acceleration; planned ones stay below 4", minimum=1e-3
    )


class Adapter(ShoecalNode):
    """Between `joint_trajectory` and a robot's driver.

    Nothing is sent before somebody has armed the robot. A robot on its way that is armed no more is
    stopped by the adapter itself, once; a command to hold, which the node that disarms a moving
    robot sends just after that, only lets it do so at once: its angles do not count then.

    Attributes:
        robot: whose joints are commanded.
        joints: what the robot reports of them.
    """

    def __init__(self, name: str) -> None:
        super().__init__(name)
        self.robot = self.settings(RobotFiles).load_robot()
        self._gate = self.settings(GateSettings)
        senders = self.peers.expect_one_sender("joint_states")
        self.joints = JointInput(self.robot, STALE_S, senders=senders)
        self.subscribe(JointState, "joint_states", self._hear, qos.NEWEST)
        self._arming = ArmedInput(self, lease_s=SHORT_LEASE_S)
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
    def commanded(self, names: tuple[str, ...]) -> FloatArray | None:
        """(k,) where joints are commanded to be by now [rad]; None where some are not."""

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

    def watch(self) -> None:
        """Stop what may move no more, and report how things are."""
        armed = self._arming.armed
        # Armed again is not allowed to go on: who disarms and arms at once wants it stopped, too.
        if not armed or self._arming.disarmings != self._disarmings:
            self._stop()
        well = "armed" if armed else "not armed" if self._arming.heard else NOT_HEARD
        self.health.note("robot", self._condition(well))
        super().watch()

    def close(self) -> None:
        """Leave no robot on its way."""
        self._stop()

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
                self._admit(trajectory_from_ros(message), time_from_ros(message.header.stamp))
                self._accepted += 1
                self._refused_s = -math.inf
            except ShoecalError as error:
                self._refused += 1
                self._refused_s, self._refusal = self.now_s, f"trajectory refused: {error}"

    def _admit(self, trajectory: JointTrajectory, stamp_ns: int) -> None:
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
        self._check_age(stamp_ns, latest)
        # Who sends two angles for one motor, or some beyond its limits, is refused here.
        self._check_rates(trajectory.full(self.robot, measured), measured)
        self._check_begin(trajectory, measured)
        if missing := self.missing:
            if holds:
                self._stop()
            raise ShoecalError(missing)
        self.follow(trajectory, measured)
        # What holds some joints, or takes long, is a motion that may have to be stopped.
        moved = {self.robot.joint_names[joint] for joint in self.robot.moved}
        rests = holds and moved <= set(trajectory.names) and trajectory.duration <= LONGEST_S
        self._moves, self._disarmings = not rests, self._arming.disarmings

    def _check_age(self, stamp_ns: int, latest: JointBatch) -> None:
        """Refuse what waited on its way here, as after a sleep of this process or another.

        A stamp is of the clock of `joint_states`; none stands for a command of this moment.
        """
        age_s = (int(latest.stamp_ns[0]) - stamp_ns) / 1e9 + self.joints.heard.age_s
        if stamp_ns and age_s > OLDEST_S:
            raise ShoecalError(
                f"it is {age_s:.2f} s old by its stamp (at most {OLDEST_S:g} s); see that the "
                "computer is not overloaded and that stamps are of the clock of joint_states"
            )

    def _check_begin(self, trajectory: JointTrajectory, measured: FloatArray) -> None:
        """Refuse what begins neither where the robot is nor where it is commanded to be by now.

        So begins what goes on without a robot that came to rest, as its pieces did not come here.

        Args:
            trajectory: to be followed.
            measured: (m,) joint angles [rad].
        """
        names = trajectory.names
        if trajectory.times[0] > 0.0:  # the robot has that long to get there
            return
        off = np.abs(trajectory.positions[0] - measured[[self.robot.joint(one) for one in names]])
        commanded = self.commanded(names)
        if commanded is not None:
            off = np.minimum(off, np.abs(trajectory.positions[0] - commanded))
        joint = int(np.argmax(off))
        if off[joint] > JOIN_RAD:
            raise ShoecalError(
                f"joint '{names[joint]}' begins {off[joint]:.3g} rad from where it is "
                f"(at most {JOIN_RAD:g} rad); send one that begins where the robot stands"
            )

    def _check_rates(self, trajectory: JointTrajectory, measured: FloatArray) -> None:
        """Refuse what is too fast for any motion of shoecal, its begin at (m,) [rad] included."""
        speeds, accelerations = trajectory.peaks()
        # Where it begins elsewhere, joints pass over to it.
        speeds = np.maximum(speeds, PEAK * np.abs(trajectory.positions[0] - measured) / STOP_S)
        gate, limits = self._gate, self.robot.velocity_limit
        fastest = np.where(limits > 0.0, np.minimum(limits, gate.joint_speed), gate.joint_speed)
        hardest = np.full_like(fastest, gate.joint_acceleration)
        for what, unit, reached, most in (
            ("speed", "rad/s", speeds, fastest),
            ("acceleration", "rad/s^2", accelerations, hardest),
        ):
            joint = int(np.argmax(reached / most))
            if reached[joint] > most[joint]:
                raise ShoecalError(
                    f"joint '{self.robot.joint_names[joint]}' would reach {reached[joint]:.3g} "
                    f"{unit} (joint_{what} {most[joint]:.3g} {unit}); send a slower motion"
                )
