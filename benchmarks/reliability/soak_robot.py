"""A robot that stands, as fast as driver and calibrator can follow it.

Simulated time, joint angles and the bytes of its shoes' device; frames are lost and damaged on
purpose.
"""

from __future__ import annotations

import random
import time

import numpy as np
from geometry_msgs.msg import PointStamped
from numpy.typing import NDArray
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState

from reliability.live_world import World
from reliability.tries import BrokenError
from ros.bodies import calibration, nao, nao_shoe, parameters, readings
from shoecal_core.calibration.calibration import save_calibration
from shoecal_core.files import write_yaml
from shoecal_core.model.double_support import DoubleSupport
from shoecal_core.model.kinematics import Kinematics
from shoecal_core.planning.posture import stance
from shoecal_core.sensing.load_cases import double_support_outputs
from shoecal_core.sensing.sensing import Sensing
from shoecal_ros.common import qos
from shoecal_ros.common.conversions import JointSample, joints_to_ros, time_from_ros, time_to_ros
from shoecal_ros.common.realtime_executor import BATCH, drained
from shoecal_ros.serial.device import SimulatedDevice
from shoecal_ros.serial.frame import Info

FloatArray = NDArray[np.float64]

SUPPORT = DoubleSupport(0.0, -0.112, 0.0)
PERIOD_NS = 10_000_000
TICK = 5
"""Frames in a tick of simulated time; those of two are no more than a controller's topic holds."""
JOINTS = 2
"""Frames for each message of joint angles."""
STANCES, NOISE_N = 64, 0.05
"""Readings of the standing robot that come in turn, and how much they differ."""
NEAR = 1e-6
"""Of a CoP [m]."""
LOST = DAMAGED = 0.002
"""Shares of the frames."""
FRAMES = "shoe_driver", "device", "frames"
LOST_FIRST = "shoe_driver", "device", "lost_frames"
LOST_LATER = "calibrator", "voltages", "lost_frames"
PATIENCE_S = 100.0
START_S = 600.0
"""A busy machine may take so long for what must come."""
SETTLED_S = 1.0
BITS, SCALE = 24, 10.0 / 2**24
QUIET = {"use_sim_time": True}
NEVER_STALE = {"stale_s": 100.0, "live_stale_s": 100.0}
"""By the wall clock; here the robot waits for the nodes."""


class SoakRobot:
    """Robot and device; the nodes `shoe_driver` and `calibrator` are started with it.

    Attributes:
        lost: frames that were sampled, but did not go out whole.
        whole: frames that did.
    """

    def __init__(self, world: World, rng: random.Random) -> None:
        self._world, self._rng = world, rng
        self.lost = self.whole = 0
        self._stamp_ns, self._sequence = 1000 * 10**9, 0
        self._joints = joints_to_ros(
            JointSample(0, nao().joint_names, nao().from_legs(stance(nao(), SUPPORT)))
        )
        self._counts, self._cop = _stances(np.random.default_rng(rng.randrange(2**32)))
        self.device = SimulatedDevice(
            world.folder / "port", Info("soak", 1, len(nao_shoe().names), 100.0)
        )
        self._clock_topic = world.node.create_publisher(Clock, "/clock", qos.CLOCK)
        self._joints_topic = world.node.create_publisher(JointState, "joint_states", qos.RAW)
        self._missing: dict[int, FloatArray] = {}
        self._heard, self._heard_at, self._wrong = 0, 0.0, ""
        self._first_ns = 0
        self._cops = world.node.create_subscription(PointStamped, "shoe/cop", self._take, qos.RAW)
        self._next_tick = 0.0
        self._start()

    def second(self) -> str:
        """A second of the robot's; what was wrong in it, empty when nothing was."""
        wrong = [told for _ in range(100 // TICK) if (told := self._tick())]
        return wrong[0] if wrong else ""

    def counted(self) -> tuple[int, int]:
        """Frames lost as driver and calibrator tell them, once all that was sent is told.

        Raises:
            BrokenError: when a frame gives no CoP, or the driver never tells of all.
        """
        if wrong := self._wait(self._stamp_ns) or self._wrong:
            raise BrokenError(wrong)
        try:
            self._world.until(lambda: self._told(*FRAMES) == self.whole, PATIENCE_S)
            self._world.until(lambda: self._told(*LOST_LATER) >= self.lost, PATIENCE_S)
        except AssertionError as error:
            told = f"{self._told(*FRAMES)} frames, {self._told(*LOST_LATER)} lost"
            raise BrokenError(f"{self.whole} frames, {self.lost} lost; told: {told}") from error
        return self._told(*LOST_FIRST), self._told(*LOST_LATER)

    def _told(self, node: str, subject: str, figure: str) -> int:
        found = self._world.diagnosis(node, subject)
        values = {} if found is None else {each.key: each.value for each in found.values}
        return int(values.get(figure, 0))

    def _start(self) -> None:
        world, device = self._world, self._world.folder / "device.yaml"
        state = world.folder / "state"
        state.mkdir()
        channels = [{"index": k, "cell": name} for k, name in enumerate(nao_shoe().names)]
        converter = {"volts_per_count": SCALE, "bits": BITS, "encoding": "signed"}
        write_yaml(
            device,
            {
                "format": 1, "port": str(world.folder / "port"), "baud": 115200,
                "mode": "binary", "alarm_s": 100.0, "converter": converter, "channels": channels,
            },
        )  # fmt: skip
        save_calibration(calibration(nao(), nao_shoe()), state / "calibration.yaml")
        world.start("shoe_driver", {**QUIET, "config_file": device})
        world.start(
            "calibrator",
            {**QUIET, **NEVER_STALE, "state_dir": state, "sessions_dir": world.folder / "sessions"},
        )
        world.until(lambda: self._joints_topic.get_subscription_count() > 0, START_S)
        world.until(lambda: world.node.count_publishers("shoe/cop") > 0, START_S)
        world.until(self._begun, START_S)
        world.until(lambda: time.monotonic() - self._heard_at > SETTLED_S, START_S)
        self._missing.clear()
        self._first_ns = self._stamp_ns

    def _begun(self) -> bool:
        """Let time pass, slowly enough for nodes that are just starting, until CoPs come."""
        if time.monotonic() > self._next_tick:
            self._next_tick = time.monotonic() + SETTLED_S / 2.0
            self._pass_time(hurt=False)
        return self._heard > 0

    def _tick(self) -> str:
        """A step of simulated time; what was wrong in it.

        It ends when the frames of the step before have given their CoPs: all processes are busy.
        """
        before_ns = self._stamp_ns
        self._pass_time(hurt=True)
        late, wrong = self._wait(before_ns), self._wrong
        self._wrong = ""
        return late or wrong

    def _wait(self, last_ns: int) -> str:
        """Wait for the CoPs of all frames up to one; what is wrong when they do not come."""
        try:
            self._world.until(lambda: all(one > last_ns for one in self._missing), PATIENCE_S)
        except AssertionError:
            told = f"{len(self._missing)} frames gave no CoP, the first of {min(self._missing)} ns"
            self._missing.clear()
            return told
        return ""

    def _pass_time(self, *, hurt: bool) -> None:
        begin_ns = self._stamp_ns
        # Nothing is stamped later than the clock shows.
        self._clock_topic.publish(Clock(clock=time_to_ros(begin_ns + TICK * PERIOD_NS)))
        for index in range(TICK):
            self._stamp_ns = begin_ns + (index + 1) * PERIOD_NS
            if index % JOINTS == 0:
                self._joints.header.stamp = time_to_ros(self._stamp_ns)
                self._joints_topic.publish(self._joints)
            self._send(self._rng.random() if hurt else 1.0)

    def _send(self, fate: float) -> None:
        """Sample a frame; some are not sent, and some are damaged on the line."""
        row = self._sequence % STANCES
        if fate < LOST:
            self.device.lose_frames(1)
        elif fate < LOST + DAMAGED:
            self.device.corrupt_next(int(fate * 1e6) % 60)
        time_us, status = self._stamp_ns // 1000, [0] * len(self._counts[row])
        sent = self.device.send(self._sequence, time_us, self._counts[row], status)
        self._sequence = (self._sequence + 1) % 2**32
        if sent and fate >= LOST + DAMAGED:
            self.whole += 1
            self._missing[self._stamp_ns] = self._cop[row]
        elif fate < LOST + DAMAGED:
            self.lost += 1

    def _take(self, first: PointStamped) -> None:
        """All that have come: waking up costs more than hearing."""
        with self._cops.handle:
            others = drained(self._cops, PointStamped, BATCH, raw=False)
        for message in (first, *others):
            self._hear(message)

    def _hear(self, message: PointStamped) -> None:
        self._heard += 1
        self._heard_at = time.monotonic()
        stamp_ns = time_from_ros(message.header.stamp)
        expected = self._missing.pop(stamp_ns, None)
        if stamp_ns <= self._first_ns:
            return  # of the beginning, when some were lost
        if expected is None:
            self._wrong = "a CoP of no frame that was sent whole"
        elif np.hypot(message.point.x - expected[0], message.point.y - expected[1]) > NEAR:
            self._wrong = f"CoP {message.point.x}, {message.point.y} instead of {expected}"


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
