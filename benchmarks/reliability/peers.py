"""Others on the same topics who do not fit.

Beside a real calibrator and a real planner appears a node of a drawn name: it publishes joint
angles or voltages best effort or as another type, listens to CoP with a quality of service that
is not offered, sends a cell that another source sends already, the robot's joints in another
posture, a CoP of its own or messages that do not hold together, or is a second calibrator, a
process of its own, under another name or, launched twice, under the same. Within 5 s the
calibrator's diagnostics must name it, by node or by source, or say what is wrong with its messages,
and say so no more when it is gone; of those who fit (the planner, the robot) they must say nothing.
Where both calibrators have one name, so have their diagnostics, and one of the two must report it.
Simulated: the robot, of which only messages exist.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
from geometry_msgs.msg import PointStamped
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import JointState
from shoecal_msgs.msg import ShoeVoltages
from std_msgs.msg import String

from reliability.live_robots import WaitedForRobot, start_calibrator
from reliability.live_world import World, is_well, live_tries
from reliability.row import Row
from ros.bodies import nao, nao_shoe
from shoecal_ros.common import qos
from shoecal_ros.common.conversions import JointSample, joints_to_ros

BEST_EFFORT = QoSProfile(depth=10, reliability=ReliabilityPolicy.BEST_EFFORT)
LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
PERIOD_S = 0.05
WITHIN_S = 5.0
CALIBRATOR = "calibrator"
CELL = nao_shoe().names[3]


def _publish(node: Node, topic: str, message: Any) -> None:
    """Publish a message again and again, with stamps that grow."""
    publisher = node.create_publisher(type(message), topic, qos.RAW)

    def publish() -> None:
        message.header.stamp.sec += 1
        publisher.publish(message)

    node.create_timer(PERIOD_S, publish)


def _voltages(node: Node, **values: list[float]) -> None:
    message = ShoeVoltages(cell=[CELL], **values)
    message.header.frame_id = f"{node.get_name()}_source"
    _publish(node, "shoe/voltages", message)


def _other_posture(node: Node) -> None:
    robot = nao()
    other = np.clip(np.zeros_like(robot.posture), robot.lower, robot.upper)
    _publish(node, "joint_states", joints_to_ros(JointSample(10**9, robot.joint_names, other)))


Misfit = tuple[Callable[[Node], object], str, str]
"""What a node does; subject and text of the diagnostic that must report it, {} for its name."""

MISFITS: tuple[Misfit, ...] = (
    (lambda node: node.create_publisher(JointState, "joint_states", BEST_EFFORT), "peers", "{}"),
    (lambda node: node.create_publisher(ShoeVoltages, "shoe/voltages", BEST_EFFORT), "peers", "{}"),
    (lambda node: node.create_publisher(String, "shoe/voltages", 10), "peers", "{}"),
    (
        lambda node: node.create_subscription(PointStamped, "shoe/cop", lambda _: None, LATCHED),
        "peers",
        "{}",
    ),
    (lambda node: _voltages(node, voltage=[1.0], status=[0]), "voltages", "{}_source"),
    (_voltages, "voltages", "0 voltages and 0 statuses for 1 cells"),
    (_other_posture, "joints", "{}"),
    (
        lambda node: node.create_publisher(PointStamped, "shoe/cop", qos.LIVE),
        "peers",
        "'/{}' publishes /shoe/cop, too",
    ),
)
KINDS = len(MISFITS) + 2
"""The last two are calibrators: of another name, and launched twice."""


class Scene:
    """A calibrator, a planner, and others that come and go."""

    def __init__(self, world: World) -> None:
        self.world = world
        self.robot = WaitedForRobot(world)
        start_calibrator(world)
        world.start("planner", {"stale_s": 5.0})
        world.until_reported("planner", "planning", "ready")
        for subject in ("peers", "voltages", "joints"):
            self._until_well(subject)

    def attempt(self, number: int, rng: np.random.Generator) -> float:
        """One that does not fit; time until it is reported [s]."""
        kind, name = number % KINDS, f"odd_{int(rng.integers(10**6))}"
        if kind >= len(MISFITS):
            return self._second_calibrator(name, CALIBRATOR if kind == KINDS - 1 else name)
        misfit = self.world.companion(name)
        begin = time.monotonic()
        appear, subject, text = MISFITS[kind]
        appear(misfit)
        self.world.until_reported(CALIBRATOR, subject, text.format(name))
        took = time.monotonic() - begin
        self.world.dismiss(misfit)
        self._until_well(subject)
        return took

    def _second_calibrator(self, process: str, name: str) -> float:
        """A calibrator of this name; time until it is reported [s]."""
        world = self.world
        folders = dict.fromkeys(("state_dir", "sessions_dir"), world.folder / process)
        world.start("calibrator", folders, "-r", f"__node:={name}", name=process)
        world.until(lambda: world.node.count_publishers("shoe/state") > 1)
        begin = time.monotonic()
        who = f"another node named '/{name}'" if name == CALIBRATOR else f"'/{name}'"
        world.until_reported(CALIBRATOR, "peers", f"{who} publishes /shoe/state, too")
        took = time.monotonic() - begin
        if name != CALIBRATOR:
            world.until_reported(name, "peers", f"'/{CALIBRATOR}' publishes /shoe/state, too")
        world.stop(process)
        self._until_well("peers")
        return took

    def _until_well(self, subject: str) -> None:
        self.world.until(lambda: is_well(self.world, CALIBRATOR, subject))


ROW = Row(
    key="misfits",
    fault="QoS that does not match, two sources of one cell or joint, a second calibrator",
    holds="a diagnostic that names the other side, within 5 s",
    tries=80,
    step=20,
    run=partial(live_tries, Scene, worst="{:.1f} s until reported", most=WITHIN_S),
)
