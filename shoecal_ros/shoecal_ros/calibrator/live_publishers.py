"""The calibrator's live topics."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

import numpy as np
from geometry_msgs.msg import PointStamped, WrenchStamped
from numpy.typing import NDArray
from rclpy.node import Node
from rclpy.publisher import Publisher
from shoecal_msgs.msg import FootState, ShoeForces, ShoeState

from shoecal_core.robot.kinematics import BodyStates
from shoecal_core.shoe.shoe import FEET, Shoe
from shoecal_ros.calibrator.force_samples import ForceSamples, no_forces
from shoecal_ros.calibrator.live import FootFlags, Live, wrench_of
from shoecal_ros.common import qos
from shoecal_ros.common.conversions import header_to_ros, point_to_ros, wrench_to_ros

FloatArray = NDArray[np.float64]


class LivePublishers:
    """Publishes forces, places and the state; what has no subscriber costs nothing."""

    def __init__(self, node: Node, shoe: Shoe, soles: tuple[str, str]) -> None:
        """Publishers of a node, in the frames of the soles."""
        self._soles = soles
        self._cop, self._grf = _pair(node, "shoe")
        self._feet = [_pair(node, f"shoe/{foot}") for foot in FEET]
        self._forces = node.create_publisher(ShoeForces, "shoe/forces", qos.LIVE)
        self._state = node.create_publisher(ShoeState, "shoe/state", qos.LATCHED)
        self._cells = [
            [shoe.names[index] for index in shoe.of_foot(foot)] for foot in range(len(FEET))
        ]

    @property
    def topics(self) -> set[str]:
        """Resolved names of all that is published here."""
        pairs = [(self._cop, self._grf), *self._feet]
        singles = (self._state, self._forces)
        return {one.topic_name for one in (*singles, *(each for pair in pairs for each in pair))}

    def publish(self, lives: Sequence[Live]) -> None:
        """Publish instants in order."""
        makers: list[tuple[Publisher, Callable[[Live], Any]]] = [
            (self._cop, self._combined_cop),
            (self._grf, self._combined_grf),
        ]
        for foot, (cop, grf) in enumerate(self._feet):
            makers += [(cop, partial(self._foot_cop, foot)), (grf, partial(self._foot_grf, foot))]
        for publisher, each in makers:
            if publisher.get_subscription_count():
                for live in lives:
                    message = each(live)
                    if message is not None:
                        publisher.publish(message)

    def publish_state(
        self,
        stamp_ns: int,
        state: int,
        calibration_id: str,
        flags: Sequence[FootFlags],
        *,
        joints_stale: bool,
    ) -> None:
        """Publish the state, changed or not: who hears it knows that this node lives."""
        self._state.publish(
            ShoeState(
                header=header_to_ros(stamp_ns),
                state=state,
                calibration_id=calibration_id,
                joints_stale=joints_stale,
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
        self, stamp_ns: int, calibration_id: str, flags: Sequence[FootFlags]
    ) -> None:
        """Publish `shoe/forces` without numbers: while uncalibrated, or without readings.

        Args:
            stamp_ns: of the last readings, or now [ns].
            calibration_id: in force; empty while uncalibrated.
            flags: of both feet now.
        """
        if self._forces.get_subscription_count():
            self._forces.publish(no_forces(stamp_ns, calibration_id, self._soles, flags))

    def _combined_cop(self, live: Live) -> Any:
        if live.cop is None:
            return None
        return point_to_ros(live.stamp_ns, self._soles[live.frame], live.cop)

    def _combined_grf(self, live: Live) -> Any:
        if live.wrench is None:
            return None
        return wrench_to_ros(live.stamp_ns, self._soles[live.frame], live.wrench)

    def _foot_cop(self, foot: int, live: Live) -> Any:
        cop = live.feet[foot].cop
        if cop is None or not live.reported[foot]:
            return None
        return point_to_ros(live.stamp_ns, self._soles[foot], cop)

    def _foot_grf(self, foot: int, live: Live) -> Any:
        wrench = wrench_of(live.feet[foot])
        # A force that is not known is nothing for a controller, nor is one that it has got.
        if math.isnan(wrench[0]) or not live.reported[foot]:
            return None
        return wrench_to_ros(live.stamp_ns, self._soles[foot], wrench)

    def publish_forces(
        self,
        samples: ForceSamples,
        lives: Sequence[Live],
        flags: Sequence[FootFlags],
        states: BodyStates | None,
        noise: FloatArray,
    ) -> None:
        """Publish whole samples in order, where anybody listens.

        Args:
            samples: makes the messages.
            lives: instants.
            flags: of both feet now.
            states: of the body; None where joint angles are stale.
            noise: (n,) standard deviations of the readings.
        """
        if self._forces.get_subscription_count():
            for live in lives:
                self._forces.publish(samples.message(live, flags, states, noise))


def _pair(node: Node, prefix: str) -> tuple[Publisher, Publisher]:
    return (
        node.create_publisher(PointStamped, f"{prefix}/cop", qos.LIVE),
        node.create_publisher(WrenchStamped, f"{prefix}/grf", qos.LIVE),
    )
