"""Publishes markers while somebody looks at them, and hears forces only then.

The calibrator publishes no force without a subscriber, so looking costs the live path a little and
not looking costs it nothing.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from geometry_msgs.msg import PointStamped, WrenchStamped
from rclpy.subscription import Subscription
from shoecal_msgs.msg import ShoeState
from visualization_msgs.msg import MarkerArray

from shoecal_core.recording.schemas import GOOD
from shoecal_core.robot.robot import Robot
from shoecal_core.shoe.shoe import FEET, Shoe
from shoecal_ros.common import qos
from shoecal_ros.common.conversions import point_from_ros
from shoecal_ros.common.node import ShoecalNode
from shoecal_ros.inputs.joints import JointBatch
from shoecal_ros.model.scene_markers import FootSeen, MeasuredInstant, SceneMarkers

TOPIC = "shoe/markers"
FRESH_S = 0.5
"""Older than this by the wall clock, a measurement is shown no more."""


@dataclass(frozen=True)
class _Heard:
    message: Any
    at: float


class MarkerPublisher:
    """Call `watch` at the rate at which markers shall come."""

    def __init__(
        self,
        node: ShoecalNode,
        robot: Robot,
        shoe: Shoe,
        soles: tuple[str, str],
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._node, self._robot, self._shoe, self._clock = node, robot, shoe, clock
        self._soles = soles
        self._scene: SceneMarkers | None = None
        self._publisher = node.create_publisher(MarkerArray, TOPIC, qos.MARKERS)
        self._subscriptions: list[Subscription] = []
        self._heard: dict[str, _Heard] = {}

    def watch(self, batch: JointBatch | None) -> None:
        """Publish what is to be seen now, where anybody looks and joint angles come."""
        if not self._publisher.get_subscription_count():
            self._listen_no_more()
            return
        if not self._subscriptions:
            self._listen()
        if batch is None:
            return
        if self._scene is None:
            self._scene = SceneMarkers(self._robot, self._shoe, self._soles)
        stamp_ns = int(batch.stamp_ns[-1])
        self._publisher.publish(self._scene.at(stamp_ns, batch.angles[-1], self._seen()))

    def _listen(self) -> None:
        wanted: dict[str, tuple[type[Any], Any]] = {
            "shoe/cop": (PointStamped, qos.LIVE),
            "shoe/state": (ShoeState, qos.LATCHED),
        }
        for foot in FEET:
            wanted[f"shoe/{foot}/cop"] = (PointStamped, qos.LIVE)
            wanted[f"shoe/{foot}/grf"] = (WrenchStamped, qos.LIVE)
        for topic, (kind, profile) in wanted.items():
            receive = self._hearer(topic)
            self._subscriptions.append(self._node.subscribe(kind, topic, receive, profile))

    def _listen_no_more(self) -> None:
        for subscription in self._subscriptions:
            self._node.destroy_subscription(subscription)
        self._subscriptions = []
        self._heard = {}

    def _hearer(self, topic: str) -> Callable[[list[Any]], None]:
        def receive(messages: list[Any]) -> None:
            self._heard[topic] = _Heard(messages[-1], self._clock())

        return receive

    def _fresh(self, topic: str) -> Any | None:
        heard = self._heard.get(topic)
        return heard.message if heard and self._clock() - heard.at < FRESH_S else None

    def _seen(self) -> MeasuredInstant:
        cop, state = self._fresh("shoe/cop"), self._fresh("shoe/state")
        reported = {} if state is None else {one.foot: one for one in state.feet}
        left, right = (self._foot(foot, reported.get(foot)) for foot in FEET)
        if cop is None or cop.header.frame_id not in self._soles:
            return MeasuredInstant((left, right))
        frame = self._soles.index(cop.header.frame_id)
        return MeasuredInstant((left, right), frame, np.array(point_from_ros(cop))[:2])

    def _foot(self, foot: str, state: Any | None) -> FootSeen:
        cop, grf = self._fresh(f"shoe/{foot}/cop"), self._fresh(f"shoe/{foot}/grf")
        if state is None:
            loaded, bad = None, frozenset[str]()
        else:
            loaded = bool(state.loaded)
            pairs = zip(state.cell, state.status, strict=False)
            bad = frozenset(cell for cell, status in pairs if status != GOOD)
        return FootSeen(
            loaded=loaded,
            force=None if grf is None else float(grf.wrench.force.z),
            cop=None if cop is None else np.array(point_from_ros(cop))[:2],
            bad=bad,
        )
