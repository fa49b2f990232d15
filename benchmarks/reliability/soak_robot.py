"""A robot that stands, as fast as driver and calibrator can follow it.

Simulated time, joint angles and the bytes of its shoes' device; frames are lost and damaged on
purpose. The stand-in robot of the other rows follows the clock on the wall, and has no device.
"""

from __future__ import annotations

import time

import numpy as np
from geometry_msgs.msg import PointStamped
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState

from reliability.live_robots import PERIOD_NS, SUPPORT, start_calibrator
from reliability.live_world import World
from reliability.tries import BrokenError
from ros.bodies import nao, nao_shoe, parameters, readings
from shoecal_core.arrays import FloatArray
from shoecal_core.planning.posture import stance
from shoecal_core.robot.kinematics import Kinematics
from shoecal_core.shoe.load_cases import double_support_outputs
from shoecal_core.shoe.sensing import Sensing
from shoecal_ros.common import qos
from shoecal_ros.common.conversions import JointSample, joints_to_ros, time_from_ros, time_to_ros
from shoecal_ros.common.realtime_executor import BATCH, drained
from shoecal_ros.serial.device import SimulatedDevice
from shoecal_ros.serial.frame import Info
from shoecal_ros.simulator.device_file import write_device

FRAMES = 100
"""In a second."""
TICK = 5
"""Frames in a tick of simulated time; those of two are no more than a controller's topic holds."""
JOINTS = 2
"""Frames for each message of joint angles."""
STANCES, NOISE_N = 64, 0.05
"""Readings of the standing robot that come in turn, and how much they differ."""
NEAR_M = 1e-6
"""Of a CoP."""
LOST = DAMAGED = 0.002
"""Shares of the frames."""
PATIENCE_S = 100.0
START_S = 600.0
"""A busy machine may take so long for what must come."""
SETTLED_S = 1.0
BITS, SCALE = 24, 10.0 / 2**24
NEVER_STALE = {"stale_s": PATIENCE_S, "live_stale_s": PATIENCE_S}
"""By the wall clock; here the robot waits for the nodes."""


class SoakRobot:
    """Robot and device; the nodes `shoe_driver` and `calibrator` are started with it.

    Attributes:
        lost: frames that were sampled, but did not go out whole.
        whole: frames that did.
    """

    def __init__(self, world: World, rng: np.random.Generator) -> None:
        self.world = world
        self.lost = self.whole = 0
        self._stamp_ns, self._sequence, self._begin_ns = 1000 * 10**9, 0, 0
        self._counts, self._cop = _stances(rng)
        self._missing: dict[int, FloatArray] = {}
        self._heard_at = 0.0
        angles = nao().from_legs(stance(nao(), SUPPORT))
        self._joints = joints_to_ros(JointSample(0, nao().joint_names, angles))
        port, config = world.folder / "port", world.folder / "device.yaml"
        self._device = SimulatedDevice(port, Info("soak", 1, len(nao_shoe().names), 100.0))
        write_device(config, nao_shoe(), port, BITS)
        self._clock = world.node.create_publisher(Clock, "/clock", qos.CLOCK)
        self._joints_topic = world.node.create_publisher(JointState, "joint_states", qos.RAW)
        self._cops = world.node.create_subscription(PointStamped, "shoe/cop", self._take, qos.RAW)
        world.start("shoe_driver", {"use_sim_time": True, "config_file": config})
        start_calibrator(world, use_sim_time=True, **NEVER_STALE)
        self._begin()

    def second(self, rng: np.random.Generator) -> None:
        """A second of the robot's.

        Raises:
            BrokenError: when a whole frame gives another CoP than it should.
        """
        for fates in rng.random((FRAMES // TICK, TICK)):
            before_ns = self._stamp_ns
            self._pass_time(fates)
            # While one tick is under way, CoPs of the one before come: all processes are busy.
            self._until_cops(before_ns)

    def check_counted(self) -> None:
        """Check the frames that driver and calibrator have counted as lost.

        Raises:
            BrokenError: when they are not those that were not sent whole.
        """
        world = self.world
        self._until_cops(self._stamp_ns)
        world.until(lambda: self._count("shoe_driver", "device", "frames") == self.whole)
        world.until(lambda: self._count("calibrator", "voltages", "lost_frames") >= self.lost)
        driver = self._count("shoe_driver", "device", "lost_frames")
        calibrator = self._count("calibrator", "voltages", "lost_frames")
        if (driver, calibrator) != (self.lost, self.lost):
            raise BrokenError(
                f"{self.lost} frames lost; {driver} counted by the driver, {calibrator} behind it"
            )

    def _count(self, node: str, subject: str, figure: str) -> int:
        found = self.world.diagnosis(node, subject)
        values = {} if found is None else {each.key: each.value for each in found.values}
        return int(values.get(figure, 0))

    def _begin(self) -> None:
        """Let time pass, slowly enough for nodes that are just starting, until CoPs come."""
        next_tick = 0.0

        def heard() -> bool:
            nonlocal next_tick
            if time.monotonic() > next_tick:
                next_tick = time.monotonic() + SETTLED_S / 2.0
                self._pass_time(np.ones(TICK))
            return self._heard_at > 0.0

        world = self.world
        world.until(lambda: self._joints_topic.get_subscription_count() > 0, START_S)
        world.until(lambda: world.node.count_publishers("shoe/cop") > 0, START_S)
        world.until(heard, START_S)
        world.until(lambda: time.monotonic() - self._heard_at > SETTLED_S, START_S)
        self._missing.clear()
        self._begin_ns = self._stamp_ns

    def _until_cops(self, last_ns: int) -> None:
        """Wait for the CoPs of all frames up to one."""
        self.world.until(
            lambda: all(stamp_ns > last_ns for stamp_ns in self._missing),
            PATIENCE_S,
            "the CoP of every whole frame",
        )

    def _pass_time(self, fates: FloatArray) -> None:
        """A tick of simulated time; fates, drawn from 0 to 1, decide which frames are whole."""
        begin_ns = self._stamp_ns
        # Nothing is stamped later than the clock shows.
        self._clock.publish(Clock(clock=time_to_ros(begin_ns + TICK * PERIOD_NS)))
        for index, fate in enumerate(fates.tolist()):
            self._stamp_ns = begin_ns + (index + 1) * PERIOD_NS
            if index % JOINTS == 0:
                self._joints.header.stamp = time_to_ros(self._stamp_ns)
                self._joints_topic.publish(self._joints)
            self._send(fate)

    def _send(self, fate: float) -> None:
        """Sample a frame; some are not sent, and some are damaged on the line."""
        row = self._sequence % STANCES
        if fate < LOST:
            self._device.lose_frames(1)
        elif fate < LOST + DAMAGED:
            self._device.corrupt_next(int(fate * 1e6) % 60)
        time_us, status = self._stamp_ns // 1000, [0] * len(self._counts[row])
        sent = self._device.send(self._sequence, time_us, self._counts[row], status)
        self._sequence = (self._sequence + 1) % 2**32
        if fate < LOST + DAMAGED:
            self.lost += 1
        elif sent:
            self.whole += 1
            self._missing[self._stamp_ns] = self._cop[row]

    def _take(self, first: PointStamped) -> None:
        """All that have come: waking up costs more than hearing."""
        with self._cops.handle:
            others = drained(self._cops, PointStamped, BATCH, raw=False)
        for message in (first, *others):
            self._hear(message)

    def _hear(self, message: PointStamped) -> None:
        self._heard_at = time.monotonic()
        stamp_ns = time_from_ros(message.header.stamp)
        expected = self._missing.pop(stamp_ns, None)
        if stamp_ns <= self._begin_ns:
            return  # of the beginning, when some were lost
        if expected is None:
            raise BrokenError("a CoP of no frame that was sent whole")
        if np.hypot(message.point.x - expected[0], message.point.y - expected[1]) > NEAR_M:
            raise BrokenError(f"CoP {message.point.x}, {message.point.y} instead of {expected}")


def _stances(rng: np.random.Generator) -> tuple[list[list[int]], FloatArray]:
    """Counts of the cells, a row each, and the CoP (STANCES, 2) that they mean."""
    shoe = nao_shoe()
    law = parameters(shoe)
    place = Kinematics(nao()).states(nao().from_legs(stance(nao(), SUPPORT))[None]).cop[:, 0]
    outputs = double_support_outputs(shoe, SUPPORT, nao().weight, place)
    outputs = outputs + rng.normal(0.0, NOISE_N, (STANCES, len(shoe.names)))
    counts = np.rint(readings(shoe, law, outputs) / SCALE)
    cop = Sensing(shoe, law).measure(counts * SCALE).combined_cop(SUPPORT)
    return counts.astype(int).tolist(), cop
