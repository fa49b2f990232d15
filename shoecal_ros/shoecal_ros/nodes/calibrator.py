"""Node `calibrator`: calibrated forces and CoP live, and how they become so."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

from rclpy.serialization import deserialize_message
from sensor_msgs.msg import JointState
from shoecal_msgs.msg import ShoeState

from shoecal_core.recording import schemas
from shoecal_core.robot.double_support import DoubleSupport
from shoecal_core.robot.kinematics import BodyStates
from shoecal_ros.calibrator.active_calibration import UNCALIBRATED
from shoecal_ros.calibrator.calibration_server import CalibrationServer
from shoecal_ros.calibrator.calibrator_base import CalibratorBase
from shoecal_ros.calibrator.diagnosis_server import DiagnosisServer
from shoecal_ros.calibrator.drift_watch import DriftMonitor
from shoecal_ros.calibrator.live import FootFlags
from shoecal_ros.calibrator.live_publishers import LivePublishers
from shoecal_ros.calibrator.raw_topics import RAW_TOPICS, relative
from shoecal_ros.calibrator.rezeroing import RezeroServer
from shoecal_ros.calibrator.self_calibration import SelfCalibrationServer
from shoecal_ros.common import qos
from shoecal_ros.common.codes import Code
from shoecal_ros.common.health import Condition, Level
from shoecal_ros.common.process import run
from shoecal_ros.inputs.input_timeout import InputTimeout
from shoecal_ros.inputs.sensor_frames import frame_reader
from shoecal_ros.inputs.serialised import understood


class CalibratorNode(CalibratorBase):
    """Never silent about what its numbers are worth; one self-calibration at a time."""

    def __init__(self) -> None:
        super().__init__("calibrator")
        self._overdue = [
            InputTimeout(self, heard, self._publish_state)
            for heard in (self.joints.heard, *self.voltages.feet)
        ]
        self._out = LivePublishers(self, self.shoe, self.frames.soles)
        self.peers.alone |= self._out.topics
        self._calibrations = CalibrationServer(self)
        self._agreement = self._calibrations.agreement
        self._rezeroing = RezeroServer(self, self._calibrations)
        self._drift = DriftMonitor(self, self._calibrations.store, self._rezeroing)
        self._support: DoubleSupport | None = None
        self._states: BodyStates | None = None
        self._subscribe()
        self._self_calibration = SelfCalibrationServer(self, self._calibrations)
        self._diagnoses = DiagnosisServer(self)

    def watch(self) -> None:
        """Report the condition of everything."""
        problem = self.joints.problem or self.one_clock.problem
        figures = self.joints.heard.figures()
        self.health.note("joints", Condition.of(problem, "joints come", figures))
        self.health.note("voltages", self.voltages.condition)
        self.health.note("cells", self.cells.condition)
        self._report_calibration()
        self.health.note("diagnosis", self._diagnoses.condition)
        self._drift.watch()
        self.health.note("agreement", self._agreement.condition)
        self._publish_state()
        super().watch()

    def close(self) -> None:
        """Keep what is being recorded, and look for no more causes."""
        self.recorder.abandon()
        self._diagnoses.close()

    # Input

    def _subscribe(self) -> None:
        """Everything a run may hold comes serialised: it is recorded as it was sent."""
        for topic, kind in RAW_TOPICS.items():
            if (read := frame_reader(topic, self.shoe)) is not None:
                receive = partial(self._hear_readings, topic, kind, read)
                self.realtime.subscribe(kind, relative(topic), receive, qos.RAW, raw=True)
        joints = relative(schemas.JOINT_STATES)
        self.realtime.subscribe(JointState, joints, self._hear_joints, qos.RAW, raw=True)

    def _hear_joints(self, serialised: list[bytes]) -> None:
        serialised, messages = understood(
            serialised, lambda one: deserialize_message(one, JointState), self.joints.refuse
        )
        self.recorder.take(schemas.JOINT_STATES, serialised)
        batch = self.joints.take(messages)
        if batch is None:
            return
        for stamp_ns, angles in zip(batch.stamp_ns.tolist(), batch.angles, strict=True):
            self.stillness.add(stamp_ns, angles)
        self._rezeroing.take_joints(batch)
        # Here, so that readings need not wait for it.
        self._states = self.kinematics.states(batch.angles[-1:])
        self._support = self._states.support()

    def _hear_readings(
        self, topic: str, kind: type[Any], read: Callable[[Any], Any], serialised: list[bytes]
    ) -> None:
        serialised, frames = understood(
            serialised, lambda one: read(deserialize_message(one, kind)), self.voltages.refuse
        )
        joined = self.voltages.take(frames)
        # Where the right foot stands is known while angles come.
        support = None if self.joints.silent else self._support
        states = None if self.joints.silent else self._states
        lives = self.live.take(joined, support)
        self._out.publish(lives)
        self._agreement.take(joined, states)
        if self.force_samples is not None:
            self._out.publish_forces(
                self.force_samples,
                lives,
                self._flags(),
                self._agreement.doubts,
                states,
                self.cells.noise,
            )
        self.cells.learn()
        self.recorder.take(topic, serialised)
        self._rezeroing.take_readings(joined)

    # Reporting

    def _flags(self) -> tuple[FootFlags, FootFlags]:
        left, right = self.voltages.feet
        return self.live.flags((left.silent, right.silent), usable=self._agreement.usable)

    def _publish_state(self) -> None:
        current = self._calibrations.store.current
        state = ShoeState.UNCALIBRATED if current is None else ShoeState.CALIBRATED
        stamp_ns, flags = self.voltages.latest_ns or self.now_ns, self._flags()
        calibration_id = "" if current is None else current.id
        self._out.publish_state(
            stamp_ns,
            ShoeState.CALIBRATING if self._self_calibration.busy else state,
            calibration_id,
            flags,
            self._agreement.doubts,
            joints_stale=self.joints.silent,
            run_id=self.moving_run_id,
        )
        if current is None or all(foot.stale for foot in flags):
            self._out.publish_no_forces(stamp_ns, calibration_id, flags, self._agreement.doubts)

    def _report_calibration(self) -> None:
        found, job = self._calibrations.in_force, self._self_calibration.condition
        if job is not None:
            self.health.note("calibration", job)
            return
        condition = Condition(Level.WARN, UNCALIBRATED, code=Code.UNCALIBRATED)
        if found is not None:
            condition = found.condition(
                self.node_settings.temperature_gap, delay_s=f"{self.low_pass.delay_s:.4f}"
            )
        if self._calibrations.problem is not None:
            condition = Condition.of(self._calibrations.problem, "", condition.values)
        self.health.note("calibration", condition)


def main() -> None:
    """Run the node."""
    run(CalibratorNode)


if __name__ == "__main__":
    main()
