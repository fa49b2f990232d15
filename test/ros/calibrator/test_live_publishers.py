from __future__ import annotations

from dataclasses import replace

import numpy as np
from geometry_msgs.msg import PointStamped, WrenchStamped

from ros.bodies import nao_shoe
from ros.world import World
from shoecal_core.shoe.sensing import FootInstant
from shoecal_ros.calibrator.live import Live
from shoecal_ros.calibrator.live_publishers import LivePublishers
from shoecal_ros.common import qos
from shoecal_ros.common.conversions import time_from_ros

FOOT = FootInstant(25.0, (0.01, 0.0), extrapolating=False)
BOTH = Live(
    10**9, (FOOT, FOOT), (True, True), 0, (50.0, 1.0, -0.5), (0.01, 0.02), (True, True), np.zeros(8)
)  # fmt: skip


def test_a_foot_is_told_only_what_is_new_of_it(world: World) -> None:
    """Boards that send in turns: what stands beside one's readings is no new sample."""
    heard: dict[str, list[int]] = {}
    topics = [
        (f"shoe/{where}{what}", kind)
        for where in ("", "left/", "right/")
        for what, kind in (("cop", PointStamped), ("grf", WrenchStamped))
    ]
    out = LivePublishers(world.node, nao_shoe(), ("l_sole", "r_sole"))
    for topic, kind in topics:
        stamps = heard[topic] = []

        def receive(message: PointStamped | WrenchStamped, stamps: list[int] = stamps) -> None:
            stamps.append(time_from_ros(message.header.stamp))

        world.node.create_subscription(kind, topic, receive, qos.LIVE)
    world.until(lambda: all(world.node.count_subscribers(topic) for topic, _ in topics))
    lives = [
        replace(BOTH, stamp_ns=stamp_ns, reported=reported)
        for stamp_ns, reported in ((1, (True, False)), (2, (False, True)), (3, (True, True)))
    ]
    out.publish(lives)
    world.until(lambda: all(stamps and stamps[-1] == 3 for stamps in heard.values()))
    assert heard["shoe/cop"] == heard["shoe/grf"] == [1, 2, 3]
    assert heard["shoe/left/cop"] == heard["shoe/left/grf"] == [1, 3]
    assert heard["shoe/right/cop"] == heard["shoe/right/grf"] == [2, 3]
