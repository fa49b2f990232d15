"""Compares calibrated forces with weight and model whenever the robot stands still."""

from __future__ import annotations

from typing import TYPE_CHECKING

from shoecal_core.estimation.calibration import Calibration
from shoecal_core.estimation.drift import UnloadedError, check_drift
from shoecal_ros.calibrator.drift_watch import DriftWatch
from shoecal_ros.common.health import Level
from shoecal_ros.inputs.standstill import UNREST_N, Standstill

if TYPE_CHECKING:
    from shoecal_ros.nodes.calibrator import CalibratorNode


class DriftMonitor:
    """Tells the node's `drift`; it looks at the rate of the watch, the live forces do not wait."""

    def __init__(self, node: CalibratorNode) -> None:
        self._node = node
        self._watch = DriftWatch(node.node_settings.drift_time)

    def begin(self) -> None:
        """Another calibration is in force."""
        self._watch.begin()

    def watch(self) -> None:
        """Look, and tell."""
        node, current = self._node, self._node.calibration_server.store.current
        if current is None:
            node.health.tell("drift", Level.OK, "no calibration to compare with weight and model")
            return
        standstill = self._standstill()
        if standstill is not None:
            self._compare(current, standstill)
        node.health.note("drift", self._watch.condition)

    def _standstill(self) -> Standstill | None:
        """A whole standstill, when one has just come."""
        node = self._node
        joined, joints = node.voltages.latest, node.joints.latest
        if (
            joined is None
            or joints is None
            or node.calibrating
            or node.rezeroing.busy
            or not node.stillness.still
            or node.input_problem()
        ):
            self._watch.interrupt()
            return None
        return self._watch.look(joined, joints)

    def _compare(self, current: Calibration, standstill: Standstill) -> None:
        node = self._node
        if standstill.unrest(current.sensing(node.shoe)) > UNREST_N:
            return
        body = node.kinematics.states(standstill.angles[None])
        try:
            found = check_drift(
                current, node.shoe, standstill.readings, body, node.tolerance,
                false_alarm=node.node_settings.drift_false_alarm,
            )  # fmt: skip
        except UnloadedError:
            return
        self._watch.judge(found)
