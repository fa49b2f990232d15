"""Who else is on a node's topics, over DDS."""

from __future__ import annotations

import pytest
from geometry_msgs.msg import PointStamped
from std_msgs.msg import String

from ros.cures import names_a_cure
from ros.world import World
from shoecal_ros.common import qos
from shoecal_ros.common.codes import Code
from shoecal_ros.common.graph_monitor import GraphMonitor
from shoecal_ros.common.health import Level

TOPIC = "shoe/cop"
OWN = "tester"


@pytest.fixture
def peers(world: World) -> GraphMonitor:
    """Of the client, which alone should publish the CoP."""
    peers = GraphMonitor(world.node)
    peers.alone.add(world.node.create_publisher(PointStamped, TOPIC, qos.LIVE).topic_name)
    return peers


def until_reported(world: World, peers: GraphMonitor, code: Code, text: str) -> None:
    """Wait for what is said of somebody; a name is known a little later than what bears it."""

    def reported() -> bool:
        peers.watch()
        return peers.condition.code == code and peers.condition.message.startswith(text)

    world.until(reported)
    assert peers.condition.level is (Level.OK if code is Code.OK else Level.ERROR)
    assert code is Code.OK or names_a_cure(peers.condition.message)


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("rival", "'/rival' publishes /shoe/cop, too; stop one of them"),
        (
            OWN,  # launched twice
            (
                f"another node named '/{OWN}' publishes /shoe/cop, too; stop one of them, or wait "
                "if it was killed just now"
            ),
        ),
    ],
)
def test_a_second_sender_is_told_until_it_is_gone(
    world: World, peers: GraphMonitor, name: str, text: str
) -> None:
    rival = world.companion(name)
    rival.create_publisher(PointStamped, TOPIC, qos.LIVE)
    until_reported(world, peers, Code.SECOND_SENDER, text)
    world.dismiss(rival)
    until_reported(world, peers, Code.OK, "no conflict")


def test_another_type_is_told_with_both(world: World, peers: GraphMonitor) -> None:
    world.companion("reader").create_subscription(String, TOPIC, lambda _: None, 1)
    text = "'/reader' listens to /shoe/cop as std_msgs/msg/String; it is geometry_msgs/msg/Point"
    until_reported(world, peers, Code.TYPE_MISFIT, text)


def test_another_quality_of_service_is_told_with_the_reason(
    world: World, peers: GraphMonitor
) -> None:
    reader = world.companion("reader")
    reader.create_subscription(PointStamped, TOPIC, lambda _: None, qos.LATCHED)
    text = "'/reader' listens to /shoe/cop with another quality of service ("
    until_reported(world, peers, Code.QOS_MISFIT, text)
