"""Markers of a real node: only while somebody looks, with what is measured while it is fresh."""

from __future__ import annotations

from itertools import count

from geometry_msgs.msg import PointStamped, WrenchStamped
from sensor_msgs.msg import JointState
from shoecal_msgs.msg import FootState, ShoeState
from visualization_msgs.msg import MarkerArray

from ros.bodies import nao
from ros.world import World
from shoecal_ros.common import qos
from shoecal_ros.common.conversions import JointSample, joints_to_ros, point_to_ros, wrench_to_ros
from shoecal_ros.model.marker_publisher import TOPIC


def spaces(message: MarkerArray) -> set[str]:
    return {marker.ns for marker in message.markers}


def test_markers_come_while_somebody_looks(world: World) -> None:
    robot, stamps = nao(), count(10**9, 10**7)
    world.start("model")
    joints = world.publisher(JointState, "joint_states")
    cop = world.node.create_publisher(PointStamped, "shoe/left/cop", qos.LIVE)
    grf = world.node.create_publisher(WrenchStamped, "shoe/left/grf", qos.LIVE)
    state = world.node.create_publisher(ShoeState, "shoe/state", qos.LATCHED)
    world.until(lambda: world.node.count_publishers(TOPIC))
    # Nobody looks, so no node subscribes to forces.
    assert cop.get_subscription_count() == 0

    seen = world.receive(MarkerArray, TOPIC, qos.MARKERS)

    def shown(space: str, *, there: bool) -> bool:
        stamp_ns = next(stamps)
        joints.publish(joints_to_ros(JointSample(stamp_ns, robot.joint_names, robot.posture)))
        return bool(len(seen)) and (space in spaces(seen.last)) is there

    world.until(lambda: shown("body", there=True))
    assert "force" not in spaces(seen.last)

    def measured() -> bool:
        cop.publish(point_to_ros(10**9, "l_sole", (0.02, 0.01)))
        grf.publish(wrench_to_ros(10**9, "l_sole", (30.0, 0.3, -0.6)))
        bad = FootState(foot="left", loaded=True, cell=["left/front_left"], status=[1])
        state.publish(ShoeState(feet=[bad]))
        return shown("force", there=True)

    world.until(measured)
    (arrow,) = (marker for marker in seen.last.markers if marker.ns == "force")
    assert arrow.header.frame_id == "l_sole"
    # What is measured no more is shown no more.
    world.until(lambda: shown("force", there=False))


def test_forces_are_heard_no_more_when_nobody_looks(world: World) -> None:
    world.start("model")
    grf = world.node.create_publisher(WrenchStamped, "shoe/right/grf", qos.LIVE)
    viewer = world.companion("viewer")
    viewer.create_subscription(MarkerArray, TOPIC, lambda _: None, qos.MARKERS)
    world.until(grf.get_subscription_count)
    world.dismiss(viewer)
    world.until(lambda: not grf.get_subscription_count())
