"""Compares calibrated forces with weight and model whenever the robot stands still."""

from __future__ import annotations

from shoecal_core.estimation.calibration import Calibration
from shoecal_core.estimation.drift import UnloadedError, check_drift
from shoecal_ros.calibrator.calibration_store import CalibrationStore
from shoecal_ros.calibrator.calibrator_base import CalibratorBase
from shoecal_ros.calibrator.drift_watch import DriftWatch
from shoecal_ros.calibrator.rezeroing import RezeroServer
from shoecal_ros.common.health import Level
from shoecal_ros.inputs.standstill import UNREST_N, Standstill


class DriftMonitor:
    """Reports the node's `drift` at the rate of the watch; the live forces do not wait."""

    def __init__(
        self, node: CalibratorBase, store: CalibrationStore, rezeroing: RezeroServer
    ) -> None:
        self._node, self._store, self._rezeroing = node, store, rezeroing
        self._compared: Calibration | None = None
        self._watch = DriftWatch(node.node_settings.drift_time)

    def watch(self) -> None:
        """Look, and report."""
        node, current = self._node, self._store.current
        if current is not self._compared:
            self._compared = current
            self._watch.begin()
        if current is None:
            node.health.report("drift", Level.OK, "no calibration to compare with weight and model")
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
            or node.job_under_way
            or self._rezeroing.busy
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
