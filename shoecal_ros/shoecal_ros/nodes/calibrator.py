"""Node `calibrator`: calibrated forces and CoP live, and how they become so."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from rclpy.action import ActionClient
from rclpy.serialization import deserialize_message
from rclpy.subscription import Subscription
from sensor_msgs.msg import JointState
from shoecal_msgs.action import Plan, ReachSupport
from shoecal_msgs.msg import ShoeState

from shoecal_core.diagnosis.settings import DiagnosisSettings
from shoecal_core.error_sources.tolerances import Tolerances
from shoecal_core.errors import FieldError
from shoecal_core.estimation.calibration import Calibration, WrongShoeError, load_calibration
from shoecal_core.estimation.drift import FALSE_ALARM
from shoecal_core.estimation.standstill import ModelTolerance
from shoecal_core.planning.settings import PlannerSettings
from shoecal_core.recording import schemas
from shoecal_core.robot.double_support import DoubleSupport
from shoecal_core.robot.kinematics import BodyStates, Kinematics
from shoecal_core.screening.settings import CalibrationSettings
from shoecal_core.settings import load_settings, setting
from shoecal_core.shoe.shoe import FEET
from shoecal_core.workspace import config_dir
from shoecal_ros.calibrator.active_calibration import UNCALIBRATED
from shoecal_ros.calibrator.calibration_server import CalibrationServer
from shoecal_ros.calibrator.calibration_store import CalibrationStore
from shoecal_ros.calibrator.diagnosis_server import DiagnosisServer
from shoecal_ros.calibrator.drift_monitor import DriftMonitor
from shoecal_ros.calibrator.force_samples import STANCE, SUM_FRAMES, ForceSamples
from shoecal_ros.calibrator.halt import Halt
from shoecal_ros.calibrator.job import Codes
from shoecal_ros.calibrator.job_settings import JobSettings
from shoecal_ros.calibrator.live import FootFlags, LiveSensing, OutputFilter
from shoecal_ros.calibrator.live_publishers import LivePublishers
from shoecal_ros.calibrator.load import LoadSwitch
from shoecal_ros.calibrator.raw_topics import RAW_TOPICS, relative
from shoecal_ros.calibrator.recorder import Recorder
from shoecal_ros.calibrator.rezeroing import RezeroServer
from shoecal_ros.calibrator.run_series import PLAN_ACTION, REACH_ACTION
from shoecal_ros.calibrator.self_calibration import SelfCalibrationServer
from shoecal_ros.common import qos
from shoecal_ros.common.codes import Code, Problem
from shoecal_ros.common.frames import FrameSettings
from shoecal_ros.common.health import Condition, Level
from shoecal_ros.common.node import ShoecalNode
from shoecal_ros.common.origin import Origin
from shoecal_ros.common.process import run
from shoecal_ros.common.refusal import RefusedError
from shoecal_ros.common.robot_files import RobotFiles
from shoecal_ros.inputs.armed_input import ArmedInput
from shoecal_ros.inputs.arrival_monitor import SILENT_PERIODS, SILENT_S
from shoecal_ros.inputs.cell_watch import CellWatch
from shoecal_ros.inputs.input_timeout import InputTimeout
from shoecal_ros.inputs.joining import FrameJoiner, JoinSettings
from shoecal_ros.inputs.joints import JointInput
from shoecal_ros.inputs.one_clock import OneClock
from shoecal_ros.inputs.sensor_frames import frame_reader
from shoecal_ros.inputs.serialised import understood
from shoecal_ros.inputs.stillness import Stillness
from shoecal_ros.inputs.voltages import VoltageInput
from shoecal_ros.inputs.voltages_told import voltages_told


@dataclass(frozen=True)
class CalibratorSettings(JoinSettings):
    """Of the live side; wall-clock times."""

    state_dir: str = setting(
        "~/.ros/shoecal", "", "folder that keeps the calibration in force and the one before"
    )
    stale_s: float = setting(
        0.5, "s", "joint angles or voltages that did not come for so long end a job", minimum=0.01
    )
    live_stale_s: float = setting(
        SILENT_S,
        "s",
        f"when they did not come for so long, or for {SILENT_PERIODS:g} of their periods if that "
        "is longer, they are stale: what depends on them stops, and shoe/state says so",
        minimum=0.01,
    )
    clock_gap: float = setting(
        2.0, "s", "stamps of joints and voltages farther apart are of two clocks", minimum=0.01
    )
    load_on_n: float = setting(6.0, "N", "a foot with more force on it becomes loaded", minimum=2.0)
    load_off_n: float = setting(
        3.0, "N", "a foot with less force on it is no longer loaded", minimum=2.0
    )
    low_pass_hz: float = setting(
        0.0, "Hz", "cut-off frequency of a low-pass of all readings; 0: none", minimum=0.0
    )
    sum_frame: str = setting(
        STANCE,
        "",
        "frame of both feet's sum in shoe/forces: the sole's of the foot that carries (stance, as "
        "shoe/cop), or always the left or the right one",
        choices=SUM_FRAMES,
    )
    rezero_time: float = setting(
        2.0, "s", "of standing still, from which offsets are corrected", minimum=0.1
    )
    rezero_limit: float = setting(
        5.0, "N", "largest change of an offset that is still a drift", minimum=0.0
    )
    drift_time: float = setting(
        5.0,
        "s",
        "of standing still, from which GRF and CoP are compared with the model",
        minimum=0.1,
    )
    drift_false_alarm: float = setting(
        FALSE_ALARM,
        "",
        "chance that such a standstill without drift looks like one",
        minimum=1e-9,
        maximum=0.5,
    )
    temperature_gap: float = setting(
        5.0,
        "degC",
        "by which the shoes may be warmer or colder than they were calibrated at",
        minimum=0.0,
    )


class CalibratorNode(ShoecalNode):
    """Never silent about what its numbers are worth; one self-calibration at a time."""

    def __init__(self) -> None:
        super().__init__("calibrator")
        self.files = self.settings(RobotFiles)
        self.job_settings = self.settings(JobSettings)
        self.fit_settings = self.settings(CalibrationSettings, "calibration.")
        self.tolerances = self.settings(Tolerances, "tolerances.")
        self.diagnosis_settings = self.settings(DiagnosisSettings, "diagnosis.")
        self.node_settings = settings = self.settings(CalibratorSettings)
        self.planning = self._load_planning()
        self.robot, self.shoe = self.files.load_robot(), self.files.load_shoe()
        self.manual = self._load_manual()
        self.kinematics = Kinematics(self.robot)
        silent_s = settings.live_stale_s
        senders = self.peers.expect_one_sender(relative(schemas.JOINT_STATES))
        self.joints = JointInput(self.robot, settings.stale_s, silent_s=silent_s, senders=senders)
        self.cells = CellWatch(self.shoe)
        of_foot = [self.shoe.of_foot(foot) for foot in range(len(FEET))]
        self.voltages = VoltageInput(
            FrameJoiner(self.shoe.names, settings.hold_s),
            settings.stale_s,
            silent_s=silent_s,
            watch=self.cells,
            of_foot=of_foot,
        )
        self._one_clock = OneClock(self.joints, self.voltages, settings.clock_gap)
        self._overdue = [
            InputTimeout(self, heard, self._publish_state)
            for heard in (self.joints.heard, *self.voltages.feet)
        ]
        job = self.job_settings
        self.stillness = Stillness(job.still_speed, job.still_time, job.still_resolution)
        self.recorder = Recorder(lambda: self.now_ns, job.lead_s)
        self._low_pass = OutputFilter(settings.low_pass_hz)
        self.live = LiveSensing(
            of_foot, LoadSwitch(settings.load_on_n, settings.load_off_n), self._low_pass
        )
        self.frames = self.settings(FrameSettings).frames(self.robot)
        self.force_samples: ForceSamples | None = None
        self._out = LivePublishers(self, self.shoe, self.frames.soles)
        self.peers.alone |= self._out.topics
        self.tolerance = ModelTolerance.of(self.robot, self.fit_settings)
        self.drift = DriftMonitor(self)
        state_dir = Path(settings.state_dir).expanduser()
        store = CalibrationStore(state_dir, self.robot, self.shoe, simulated=self.simulated)
        self.calibration_server = CalibrationServer(self, store)
        self.rezeroing = RezeroServer(self)
        self._recorded: list[Subscription] = []
        self._support: DoubleSupport | None = None
        self._states: BodyStates | None = None
        self._subscribe()
        self.reach_client = ActionClient(self, ReachSupport, REACH_ACTION)
        self.plan_client = ActionClient(self, Plan, PLAN_ACTION)
        self._self_calibration = SelfCalibrationServer(self)
        self._diagnoses = DiagnosisServer(self)
        self._halt = Halt(self, self._arming)

    @property
    def armed(self) -> bool:
        """Whether the robot may be moved."""
        return self._arming.armed

    @property
    def disarmings(self) -> int:
        """How often that was taken back."""
        return self._arming.disarmings

    @property
    def lapsed(self) -> bool:
        """Whether who armed the robot is gone."""
        return self._arming.lapsed

    @property
    def calibrating(self) -> bool:
        """Whether a self-calibration is under way."""
        return self._self_calibration.busy

    @property
    def job_under_way(self) -> str:
        """What is under way that may move the robot, for a sentence; empty: nothing."""
        if self.calibrating:
            return "a self-calibration"
        return "a diagnosis" if self._diagnoses.busy else ""

    @property
    def origin(self) -> Origin:
        """Of what is calibrated here and now."""
        return Origin.here(simulated=self.simulated, devices=self.voltages.sources)

    @property
    def run_id(self) -> str:
        """Of the job under way."""
        return self._self_calibration.run_id or self._diagnoses.run_id

    def refuse_second_job(self) -> None:
        """Only one job at a time; RefusedError where there is one."""
        if reported := self.job_under_way:
            raise RefusedError(Codes.BUSY, f"{reported} is under way; wait for it or cancel it")

    def input_problem(self) -> Problem | None:
        """What is wrong with joint angles or voltages, and its cure; None when all is well."""
        return self.joints.problem or self.voltages.problem or self._one_clock.problem

    def watch(self) -> None:
        """Tell how everything fares."""
        problem = self.joints.problem or self._one_clock.problem
        figures = self.joints.heard.figures()
        self.health.note("joints", Condition.of(problem, "joints come", figures))
        self.health.note("voltages", voltages_told(self.voltages))
        self.health.note("cells", self.cells.condition)
        self._report_calibration()
        self.health.note("diagnosis", self._diagnoses.condition)
        self.drift.watch()
        self._publish_state()
        self._halt.watch()
        super().watch()

    def close(self) -> None:
        """Keep what is being recorded, and look for no more causes."""
        self.recorder.abandon()
        self._diagnoses.close()

    # Input

    def _load_planning(self) -> PlannerSettings:
        file = self.job_settings.planner_file or config_dir() / "nodes" / "planner.yaml"
        planner = f"{self.get_namespace().rstrip('/')}/planner"
        return load_settings(PlannerSettings, Path(file), planner, "planning")

    def _load_manual(self) -> Calibration | None:
        """The prior of the fit; FieldError where its file is none of these shoes."""
        if not self.job_settings.manual_file:
            return None
        path = Path(self.job_settings.manual_file).expanduser()
        manual = load_calibration(path)
        try:
            manual.sensing(self.shoe)
        except WrongShoeError as error:
            raise FieldError(path, f"{error}; name another manual_file") from error
        return manual

    def _subscribe(self) -> None:
        """Everything a run may hold comes serialised: it is recorded as it was sent."""
        self._arming = ArmedInput(self)
        for topic, kind in RAW_TOPICS.items():
            if (read := frame_reader(topic, self.shoe)) is not None:
                receive = partial(self._hear_readings, topic, kind, read)
                self.realtime.subscribe(kind, relative(topic), receive, qos.RAW, raw=True)
        joints = relative(schemas.JOINT_STATES)
        self.realtime.subscribe(JointState, joints, self._hear_joints, qos.RAW, raw=True)

    def listen_for_recording(self) -> None:
        """Hear also what only a recording needs."""
        self._recorded = [
            self.subscribe(
                kind, relative(topic), partial(self.recorder.take, topic), qos.RAW, raw=True
            )
            for topic, kind in RAW_TOPICS.items()
            if topic != schemas.JOINT_STATES and frame_reader(topic, self.shoe) is None
        ]

    def listen_live(self) -> None:
        """Hear only what the live side needs: every message that comes wakes the node."""
        for subscription in self._recorded:
            self.destroy_subscription(subscription)
        self._recorded = []

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
        self.rezeroing.take_joints(batch)
        self._halt.receive(batch)
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
        lives = self.live.take(joined, support)
        self._out.publish(lives)
        if self.force_samples is not None:
            states = None if self.joints.silent else self._states
            self._out.publish_forces(
                self.force_samples, lives, self._flags(), states, self.cells.noise
            )
        self.cells.learn()
        self.recorder.take(topic, serialised)
        self.rezeroing.take_readings(joined)

    # Telling

    def _flags(self) -> tuple[FootFlags, FootFlags]:
        left, right = self.voltages.feet
        return self.live.flags((left.silent, right.silent))

    def _publish_state(self) -> None:
        current = self.calibration_server.store.current
        state = ShoeState.UNCALIBRATED if current is None else ShoeState.CALIBRATED
        stamp_ns, flags = self.voltages.latest_ns or self.now_ns, self._flags()
        calibration_id = "" if current is None else current.id
        self._out.publish_state(
            stamp_ns,
            ShoeState.CALIBRATING if self.calibrating else state,
            calibration_id,
            flags,
            joints_stale=self.joints.silent,
        )
        if current is None or all(foot.stale for foot in flags):
            self._out.publish_no_forces(stamp_ns, calibration_id, flags)

    def _report_calibration(self) -> None:
        found, job = self.calibration_server.in_force, self._self_calibration.condition
        if job is not None:
            self.health.note("calibration", job)
            return
        condition = Condition(Level.WARN, UNCALIBRATED, code=Code.UNCALIBRATED)
        if found is not None:
            condition = found.condition(
                self.node_settings.temperature_gap, delay_s=f"{self._low_pass.delay_s:.4f}"
            )
        if self.calibration_server.problem is not None:
            condition = Condition.of(self.calibration_server.problem, "", condition.values)
        self.health.note("calibration", condition)


def main() -> None:
    """Run the node."""
    run(CalibratorNode)


if __name__ == "__main__":
    main()
