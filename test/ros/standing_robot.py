"""A robot that stands and says so: joint angles, and readings of chosen forces."""

from __future__ import annotations

import math
import time
from dataclasses import replace

import numpy as np
from sensor_msgs.msg import JointState
from shoecal_msgs.msg import ShoeVoltages

from ros.bodies import nao, nao_shoe, parameters, readings
from ros.world import World
from shoecal_core.arrays import FloatArray
from shoecal_core.planning.posture import stance
from shoecal_core.robot.double_support import DoubleSupport
from shoecal_core.robot.kinematics import Kinematics
from shoecal_core.shoe.load_cases import double_support_outputs
from shoecal_core.shoe.wrench import at_cop, weight_below
from shoecal_ros.common import qos
from shoecal_ros.common.conversions import JointSample, joints_to_ros, voltages_to_ros
from shoecal_ros.common.voltage_frame import VoltageFrame

PERIOD_NS = 20_000_000
ARMS = ("LShoulderPitch", "LShoulderRoll", "RShoulderPitch", "RShoulderRoll")


class StandingRobot:
    """Publishes on wall-clock time while the world is waiting.

    Attributes:
        angles: (m,) of its joints [rad].
        forces: on the left and the right foot [N].
        places: of these forces, each in its own sole's frame [m].
        drift: (n,) added to what the cells feel [N].
        status: of cells that are not good.
        tells_joints, tells_voltages: whether it does.
        apart: whether each foot's readings come in frames of their own.
        tells_left, tells_right: whether those of each foot come then.
        first: foot whose frame is sent first then.
        speed: of its left knee [rad/s].
        stamp_ns: of the last sample [ns].
        stamped_now: whether stamps are the computer's time.
        ahead_ns: by which the shoes' clock is ahead of the robot's [ns].
        temperature: that its shoes tell [degC].
        waving: whether it moves its arms.
        pace: its own seconds in one of the wall clock's.
        modelled: whether the cells feel what the model expects, in place of `forces`.
        told_at: when it last told joints, voltages and those of the left and of the right foot, by
            the monotonic wall clock [s].
        longest_s: longest time from one telling to the next, by the same clock, since this was set
            to zero [s].
    """

    def __init__(self, world: World, support: DoubleSupport, *, period_ns: int = PERIOD_NS) -> None:
        self._period_ns = period_ns
        self.support = support
        self.angles = nao().from_legs(stance(nao(), support))
        self.forces = (25.0, nao().weight - 25.0)
        self.places = np.array([[0.02, 0.005], [0.03, -0.01]])
        self.drift = np.zeros(len(nao_shoe().names))
        self.status: dict[str, int] = {}
        self.publishes_joints = self.publishes_voltages = True
        self.apart, self.publishes_left, self.publishes_right = False, True, True
        self.first = 0
        self.longest_s, self._reported = 0.0, time.monotonic()
        self.speed = 0.0
        self.ahead_ns = 0
        self.temperature = math.nan
        self.waving = self.modelled = False
        self._kinematics = Kinematics(nao())
        self.pace = 1
        self.stamp_ns = 10**9
        self.stamped_now = False
        self._count = 0
        self._joints = world.node.create_publisher(JointState, "joint_states", qos.RAW)
        self._voltages = world.node.create_publisher(ShoeVoltages, "shoe/voltages", qos.RAW)
        self.published_at = dict.fromkeys(("joints", "voltages", "left", "right"), 0.0)
        self._timer = world.node.create_timer(period_ns / 1e9, self._tell)

    def publish_every(self, period_ns: int) -> None:
        """Tell everything with this period from now on [ns]."""
        self._period_ns = self._timer.timer_period_ns = period_ns

    def stand_as_modelled(self) -> None:
        """Let both feet's forces be what the model expects of these angles."""
        cop = Kinematics(nao()).states(self.angles[None]).cop[0, 0]
        left = np.array([cop[0], 0.0])
        right = self.support.left_to_right(np.array([cop[0], self.support.dy]))
        share = cop[1] / self.support.dy
        at_right = self.support.right_to_left(right)
        # Both forces on one line across the feet, as far along it as the CoM is.
        assert abs(at_right[0] - cop[0]) < 1e-9
        self.forces = ((1.0 - share) * nao().weight, share * nao().weight)
        self.places = np.stack([left, right])

    def publish_garbled_joints(self) -> None:
        """One message whose angles are no numbers."""
        sample = JointSample(self.stamp_ns, nao().joint_names, np.full_like(self.angles, math.nan))
        self._joints.publish(joints_to_ros(sample))

    def step_to(self, support: DoubleSupport) -> None:
        """Stand at another double support."""
        self.support = support
        self.angles = nao().from_legs(stance(nao(), support))

    def _tell(self) -> None:
        before, self._reported = self._reported, time.monotonic()
        self.longest_s = max(self.longest_s, self._reported - before)
        period_s = self.pace * self._period_ns / 1e9
        self.stamp_ns += self.pace * self._period_ns
        if self.stamped_now:
            self.stamp_ns = max(self.stamp_ns, time.time_ns())
        self.angles[nao().joint("LKneePitch")] += self.speed * period_s
        if self.waving:
            for number, joint in enumerate(ARMS):
                swing = 2.0 * np.pi * (0.05 + 0.02 * number)
                speed = 0.4 * swing * np.sin(swing * self.stamp_ns / 1e9)
                self.angles[nao().joint(joint)] += speed * period_s
        if self.publishes_joints:
            sample = JointSample(self.stamp_ns, nao().joint_names, self.angles)
            self._joints.publish(joints_to_ros(sample))
            self.published_at["joints"] = time.monotonic()
        if self.publishes_voltages:
            for frame in self._frames():
                self._voltages.publish(voltages_to_ros(replace(frame, sequence=self._count)))
                self._count += 1
                self.published_at["voltages"] = time.monotonic()
            for foot, tells in (("left", self.publishes_left), ("right", self.publishes_right)):
                if tells:
                    self.published_at[foot] = self.published_at["voltages"]

    def _frames(self) -> list[VoltageFrame]:
        whole, shoe = self._frame(), nao_shoe()
        if not self.apart:
            return [whole]
        return [
            replace(
                whole,
                cells=tuple(np.array(shoe.names)[own].tolist()),
                voltage=whole.voltage[own],
                status=whole.status[own],
            )
            for foot in (self.first, 1 - self.first)
            if (self.publishes_left, self.publishes_right)[foot]
            for own in (shoe.of_foot(foot),)
        ]

    def _frame(self) -> VoltageFrame:
        shoe = nao_shoe()
        voltage = readings(shoe, parameters(shoe), self._felt())
        status = np.array([self.status.get(name, 0) for name in shoe.names], dtype=np.uint8)
        voltage[status == ShoeVoltages.NO_DATA] = np.nan
        return VoltageFrame(
            self.stamp_ns + self.ahead_ns,
            "standing_robot",
            self._count,
            shoe.names,
            voltage,
            status,
            self.temperature,
        )

    def _felt(self) -> FloatArray:
        """(n,) outputs of the cells [N]."""
        shoe = nao_shoe()
        outputs = self.drift.copy()
        if self.modelled:
            place = self._kinematics.states(self.angles[None]).cop[:, 0]
            outputs += double_support_outputs(shoe, self.support, nao().weight, place)[0]
            return outputs
        for foot in (0, 1):
            own = shoe.of_foot(foot)
            wanted = at_cop(np.array(self.forces[foot]), self.places[foot])
            felt = wanted - weight_below(shoe)[foot]
            outputs[own] += np.linalg.lstsq(shoe.columns[own].T, felt, rcond=None)[0]
        return outputs
