"""Watches whether the calibration in force is still right, whenever the robot stands still."""

from __future__ import annotations

from shoecal_core.estimation.calibration import Calibration
from shoecal_core.estimation.checks.drift import Drift, UnloadedError, check_drift
from shoecal_ros.calibrator.calibration_store import CalibrationStore
from shoecal_ros.calibrator.calibrator_base import CalibratorBase
from shoecal_ros.calibrator.rezeroing import RezeroServer
from shoecal_ros.common.codes import Code
from shoecal_ros.common.health import Condition, Level
from shoecal_ros.inputs.joining import Joined
from shoecal_ros.inputs.joints import JointBatch
from shoecal_ros.inputs.standstill import UNREST_N, Standstill

CONFIRM = 2
"""So many standstills one after the other must agree, before drift is reported or taken back."""
LEAST_READINGS = 10


class DriftWatch:
    """Collects standstills at the rate of the node's watch, and judges what they show.

    Attributes:
        found: what the last standstill showed, None before there was one.
        drifted: whether the calibration in force has drifted.
        reported: the last standstill that showed it so, None before it is known.
    """

    def __init__(self, duration_s: float) -> None:
        """Nothing seen.

        Args:
            duration_s: that a standstill must last [s].
        """
        self._duration_s = duration_s
        self._standstill = Standstill(duration_s, LEAST_READINGS)
        self.begin()

    def begin(self) -> None:
        """Another calibration is in force: what was reported of the one before counts no more."""
        self.found: Drift | None = None
        self.reported: Drift | None = None
        self.drifted = False
        self._against = 0
        self.interrupt()

    def interrupt(self) -> None:
        """The robot does not stand still, or something is missing."""
        self._standstill.restart()

    def look(self, joined: Joined, joints: JointBatch) -> Standstill | None:
        """Take what there is at this moment; a standstill once it is whole.

        One with readings that are not good is none.
        """
        self._standstill.take_readings([joined])
        self._standstill.take_joints(joints)
        if self._standstill.bad:
            self.interrupt()
        if not self._standstill.done:
            return None
        whole, self._standstill = self._standstill, Standstill(self._duration_s, LEAST_READINGS)
        return whole

    def judge(self, found: Drift) -> None:
        """Take what a standstill showed."""
        self.found = found
        self._against = self._against + 1 if found.beyond != self.drifted else 0
        if self._against >= CONFIRM:
            self.drifted, self._against = found.beyond, 0
        if found.beyond == self.drifted:
            self.reported = found

    @property
    def condition(self) -> Condition:
        """For diagnostics."""
        found, reported = self.found, self.reported
        if found is None or reported is None:
            return Condition(
                Level.OK,
                f"not compared yet: the robot must stand still for {self._duration_s:g} s",
            )
        values = {
            "grf_error_n": f"{found.grf_error:.3f}",
            "grf_limit_n": f"{found.grf_limit:.3f}",
            "cop_error_mm": f"{1e3 * found.cop_error:.2f}",
            "cop_limit_mm": f"{1e3 * found.cop_limit:.2f}",
        }
        if found.hanging:
            values["hanging_foot"] = found.hanging
            values["hanging_error_n"] = f"{found.hanging_error:.3f}"
            values["hanging_limit_n"] = f"{found.hanging_limit:.3f}"
        if self.drifted:
            return Condition(
                Level.WARN,
                f"drifted: {reported.reason}; see that nothing touches the robot, then call "
                "shoe/rezero, or calibrate again",
                values,
                Code.DRIFTED,
            )
        return Condition(Level.OK, f"as calibrated: {reported.reason}", values)


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
        moved = node.job_under_way or self._rezeroing.busy or not node.stillness.still
        if joined is None or joints is None or moved or node.input_problem():
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
