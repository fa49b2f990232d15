"""The calibrator's live topics."""

from __future__ import annotations

import math
from collections.abc import Sequence

from geometry_msgs.msg import PointStamped, WrenchStamped
from rclpy.node import Node
from rclpy.publisher import Publisher
from shoecal_msgs.msg import FootState, ShoeForces, ShoeState

from shoecal_core.arrays import FloatArray
from shoecal_core.robot.kinematics import BodyStates
from shoecal_core.shoe.sensing import Place
from shoecal_core.shoe.shoe import FEET, Shoe
from shoecal_ros.calibrator.force_samples import ForceSamples, no_forces
from shoecal_ros.calibrator.live import Doubts, FootFlags, Live, Wrench, wrench_of
from shoecal_ros.common import qos
from shoecal_ros.common.conversions import header_to_ros, point_to_ros, wrench_to_ros

BOTH = -1
"""In place of a foot: both together."""


class LivePublishers:
    """Publishes forces, places and the state; what has no subscriber costs nothing."""

    def __init__(self, node: Node, shoe: Shoe, soles: tuple[str, str]) -> None:
        """Publishers of a node, in the frames of the soles."""
        self._soles = soles
        self._pairs = {BOTH: _pair(node, "shoe")}
        self._pairs |= {index: _pair(node, f"shoe/{foot}") for index, foot in enumerate(FEET)}
        self._forces = node.create_publisher(ShoeForces, "shoe/forces", qos.LIVE)
        self._state = node.create_publisher(ShoeState, "shoe/state", qos.LATCHED)
        self._cells = [
            [shoe.names[index] for index in shoe.of_foot(foot)] for foot in range(len(FEET))
        ]

    @property
    def topics(self) -> set[str]:
        """Resolved names of all that is published here."""
        pairs = [each for pair in self._pairs.values() for each in pair]
        return {one.topic_name for one in (self._state, self._forces, *pairs)}

    def publish(self, lives: Sequence[Live]) -> None:
        """Publish instants in order."""
        for whose, (cop, grf) in self._pairs.items():
            places, wrenches = cop.get_subscription_count(), grf.get_subscription_count()
            for live in lives if places or wrenches else ():
                foot, place, wrench = _seen(live, whose)
                if places and place is not None:
                    cop.publish(point_to_ros(live.stamp_ns, self._soles[foot], place))
                if wrenches and wrench is not None:
                    grf.publish(wrench_to_ros(live.stamp_ns, self._soles[foot], wrench))

    def publish_state(
        self,
        stamp_ns: int,
        state: int,
        calibration_id: str,
        flags: Sequence[FootFlags],
        doubts: Doubts,
        *,
        joints_stale: bool,
        run_id: str,
    ) -> None:
        """Publish the state, changed or not: who hears it knows that this node lives."""
        self._state.publish(
            ShoeState(
                header=header_to_ros(stamp_ns),
                state=state,
                calibration_id=calibration_id,
                joints_stale=joints_stale,
                run_id=run_id,
                unconfirmed=doubts.unconfirmed,
                disagrees=doubts.disagrees,
                feet=[
                    FootState(
                        foot=foot,
                        loaded=flag.loaded,
                        valid=flag.valid,
                        stale=flag.stale,
                        extrapolating=flag.extrapolating,
                        cell=cells,
                        status=list(flag.status),
                    )
                    for foot, flag, cells in zip(FEET, flags, self._cells, strict=True)
                ],
            )
        )

    def publish_no_forces(
        self, stamp_ns: int, calibration_id: str, flags: Sequence[FootFlags], doubts: Doubts
    ) -> None:
        """Publish `shoe/forces` without numbers: while uncalibrated, or without readings.

        Args:
            stamp_ns: of the last readings, or now [ns].
            calibration_id: in force; empty while uncalibrated.
            flags: of both feet now.
            doubts: about the calibration.
        """
        if self._forces.get_subscription_count():
            self._publish_sample(no_forces(stamp_ns, calibration_id, self._soles, flags), doubts)

    def publish_forces(
        self,
        samples: ForceSamples,
        lives: Sequence[Live],
        flags: Sequence[FootFlags],
        doubts: Doubts,
        states: BodyStates | None,
        noise: FloatArray,
    ) -> None:
        """Publish whole samples in order, where anybody listens.

        Args:
            samples: makes the messages.
            lives: instants.
            flags: of both feet now.
            doubts: about the calibration.
            states: of the body; None where joint angles are stale.
            noise: (n,) standard deviations of the readings.
        """
        if self._forces.get_subscription_count():
            for live in lives:
                self._publish_sample(samples.message(live, flags, states, noise), doubts)

    def _publish_sample(self, message: ShoeForces, doubts: Doubts) -> None:
        message.unconfirmed, message.disagrees = doubts.unconfirmed, doubts.disagrees
        self._forces.publish(message)


def _seen(live: Live, whose: int) -> tuple[int, Place | None, Wrench | None]:
    """Foot in whose sole frame they are, CoP and wrench; None where there is nothing new to say."""
    if whose == BOTH:
        return live.frame, live.cop, live.wrench
    if not live.reported[whose]:
        return whose, None, None
    own = live.feet[whose]
    # A force that is not known is nothing for a controller.
    return whose, own.cop, None if math.isnan(own.force) else wrench_of(own)


def _pair(node: Node, prefix: str) -> tuple[Publisher, Publisher]:
    return (
        node.create_publisher(PointStamped, f"{prefix}/cop", qos.LIVE),
        node.create_publisher(WrenchStamped, f"{prefix}/grf", qos.LIVE),
    )
