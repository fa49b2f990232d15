"""Others on the same topics who do not fit.

Beside a real calibrator and a real planner appears a node of a drawn name: it publishes joint
angles or voltages best effort or as another type, listens to CoP with a quality of service that
is not offered, sends a cell that another source sends already, the robot's joints in another
posture, a CoP of its own or messages that do not hold together, or is a second calibrator, a
process of its own, under another name or, launched twice, under the same. Within 5 s the
calibrator's diagnostics must name it, by node or by source, or say what is wrong with its messages,
and say so no more when it is gone; of those who fit (the planner, the robot) they must say nothing.
Where both calibrators have one name, so have their diagnostics, and one of the two must tell.
Simulated: the robot, of which only messages exist.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from geometry_msgs.msg import PointStamped
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import JointState
from shoecal_msgs.msg import ShoeVoltages
from std_msgs.msg import String

from reliability.live_robots import WaitedForRobot, put_in_force, start_calibrator
from reliability.live_world import COMPILE_S, World, live_world
from reliability.row import Progress, Result, Row
from ros.bodies import nao, nao_shoe
from shoecal_ros.common import qos
from shoecal_ros.common.conversions import JointSample, joints_to_ros

BEST_EFFORT = QoSProfile(depth=10, reliability=ReliabilityPolicy.BEST_EFFORT)
LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
TELL_S = 0.05
WITHIN_S = 5.0
CALIBRATOR = "calibrator"


def best_effort_joints(node: Node, source: str) -> tuple[str, str]:
    """Joint angles that a recorder cannot hear."""
    del source
    node.create_publisher(JointState, "joint_states", BEST_EFFORT)
    return "peers", node.get_name()


def best_effort_voltages(node: Node, source: str) -> tuple[str, str]:
    """Voltages likewise."""
    del source
    node.create_publisher(ShoeVoltages, "shoe/voltages", BEST_EFFORT)
    return "peers", node.get_name()


def other_type(node: Node, source: str) -> tuple[str, str]:
    """Text where voltages belong."""
    del source
    node.create_publisher(String, "shoe/voltages", 10)
    return "peers", node.get_name()


def latched_listener(node: Node, source: str) -> tuple[str, str]:
    """A controller that asks for more than is offered."""
    del source
    node.create_subscription(PointStamped, "shoe/cop", lambda _: None, LATCHED)
    return "peers", node.get_name()


def second_source(node: Node, source: str) -> tuple[str, str]:
    """One cell comes from two places."""
    _keep_telling(node, source, ShoeVoltages(cell=[nao_shoe().names[3]], voltage=[1.0], status=[0]))
    return "voltages", source


def second_joints(node: Node, source: str) -> tuple[str, str]:
    """Another program tells the same joints otherwise, as one that replays a recording does."""
    del source
    publisher = node.create_publisher(JointState, "joint_states", qos.RAW)
    robot = nao()
    other = np.clip(np.zeros_like(robot.posture), robot.lower, robot.upper)
    message = joints_to_ros(JointSample(10**9, robot.joint_names, other))
    _repeat(node, publisher, message)
    return "joints", node.get_name()


def other_cop(node: Node, source: str) -> tuple[str, str]:
    """Another program's CoP where controllers hear the calibrator's."""
    del source
    node.create_publisher(PointStamped, "shoe/cop", qos.LIVE)
    return "peers", f"'/{node.get_name()}' publishes /shoe/cop, too"


def malformed(node: Node, source: str) -> tuple[str, str]:
    """A cell without a voltage."""
    _keep_telling(node, source, ShoeVoltages(cell=[nao_shoe().names[3]]))
    return "voltages", "0 voltages and 0 statuses for 1 cells"


def _keep_telling(node: Node, source: str, message: ShoeVoltages) -> None:
    publisher = node.create_publisher(ShoeVoltages, "shoe/voltages", qos.RAW)
    message.header.frame_id = source
    _repeat(node, publisher, message)


def _repeat(node: Node, publisher: Publisher, message: Any) -> None:
    def tell() -> None:
        message.header.stamp.sec += 1
        publisher.publish(message)

    node.create_timer(TELL_S, tell)


RIVALS: tuple[Callable[[Node, str], tuple[str, str]], ...] = (
    best_effort_joints, best_effort_voltages, other_type, latched_listener, second_source,
    malformed, second_joints, other_cop,
)  # fmt: skip
"""What each does; the diagnostic's subject that must tell it, and the name that it must hold."""

TWIN = "calibrator launched twice"
NAMES = (*(one.__name__.replace("_", " ") for one in RIVALS), "second calibrator", TWIN)
"""Of all that is tried, in turn."""


@dataclass(frozen=True)
class Try:
    """What came of one: in words what was tried, and after what time it was told [s]."""

    what: str
    took: float


class Scene:
    """A calibrator, and others that come and go."""

    def __init__(self, world: World) -> None:
        self.world = world
        self.robot = WaitedForRobot(world)
        start_calibrator(world)
        put_in_force(world)
        world.start("planner", {"stale_s": 5.0})
        world.until_reported("planner", "planning", "ready", COMPILE_S)
        for subject in ("peers", "voltages", "joints"):
            self._well(subject)

    def try_one(self, index: int, rng: np.random.Generator) -> Try:
        """One that does not fit."""
        kind, name = index % len(NAMES), f"odd_{int(rng.integers(10**6))}"
        if kind >= len(RIVALS):
            own = CALIBRATOR if NAMES[kind] == TWIN else name
            return Try(NAMES[kind], self._second_calibrator(name, own))
        rival = self.world.companion(name)
        begin = time.monotonic()
        subject, wanted = RIVALS[kind](rival, f"{name}_source")
        self.world.until_reported(CALIBRATOR, subject, wanted)
        took = time.monotonic() - begin
        self.world.dismiss(rival)
        self._well(subject)
        return Try(NAMES[kind], took)

    def _second_calibrator(self, process: str, name: str) -> float:
        """One of this name; after what time it was told [s]."""
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
        self._well("peers")
        return took

    def _well(self, subject: str) -> None:
        def well() -> Any:
            found = self.world.diagnosis(CALIBRATOR, subject)
            return found is not None and found.level == b"\x00"

        self.world.until(well)


def tried(first: int, count: int, seed: int, progress: Progress) -> list[Try]:
    """Tries first to first + count - 1; raises where one is not told, or told for ever."""
    found = []
    with live_world() as world:
        scene = Scene(world)
        for index in range(first, first + count):
            found.append(scene.try_one(index, np.random.default_rng([seed, index])))
            progress(len(found))
    return found


def run(first: int, count: int, seed: int, progress: Progress) -> Result:
    """One that is not told at all ends the tries, and is the last of them."""
    done = 0

    def note(number: int) -> None:
        nonlocal done
        done = number
        progress(number)

    try:
        found = tried(first, count, seed, note)
    except AssertionError as error:
        why = f"{NAMES[(first + done) % len(NAMES)]}: {' '.join(str(error).split())[:150]}"
        return Result(min(done + 1, count), 1, why, 60.0)
    return judged(found)


def judged(found: Sequence[Try]) -> Result:
    """What tries came to that were all told."""
    worst = max(found, key=lambda one: one.took)
    late = sum(one.took > WITHIN_S for one in found)
    return Result(len(found), late, f"{worst.took:.1f} s until told ({worst.what})", worst.took)


ROW = Row(
    key="misfits",
    fault="QoS that does not match, two sources of one cell or joint, a second calibrator",
    holds="a diagnostic that names the other side, within 5 s",
    tries=80,
    step=20,
    run=run,
)
