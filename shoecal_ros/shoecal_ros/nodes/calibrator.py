"""Node `calibrator`: calibrated forces and CoP live, and how they become so."""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import dataclass
from datetime import UTC, datetime
from functools import partial
from pathlib import Path
from typing import Any

from rclpy.action import ActionClient, ActionServer, CancelResponse
from rclpy.action.server import ServerGoalHandle
from rclpy.serialization import deserialize_message
from sensor_msgs.msg import JointState
from shoecal_msgs.action import Calibrate, Plan, ReachSupport
from shoecal_msgs.msg import ShoeState
from shoecal_msgs.srv import SelfCalibrate

from shoecal_core.calibration.settings import CalibrationSettings
from shoecal_core.model.double_support import DoubleSupport
from shoecal_core.model.kinematics import Kinematics
from shoecal_core.planning.settings import PlannerSettings
from shoecal_core.recording import schemas
from shoecal_core.settings import Settings, load_settings, setting
from shoecal_core.workspace import config_dir
from shoecal_ros import qos
from shoecal_ros.actions import finish
from shoecal_ros.armed_input import ArmedInput
from shoecal_ros.calibration_desk import CalibrationDesk
from shoecal_ros.calibration_job import (
    PLAN_ACTION,
    REACH_ACTION,
    CalibrationJob,
    JobSettings,
    Request,
)
from shoecal_ros.calibration_store import CalibrationStore
from shoecal_ros.conversions import calibration_to_ros
from shoecal_ros.health import Level
from shoecal_ros.joining import FrameJoiner, Joined
from shoecal_ros.joints import JointInput
from shoecal_ros.live import LiveSensing, LowPass
from shoecal_ros.live_publishers import LivePublishers
from shoecal_ros.load import LoadSwitch
from shoecal_ros.raw_topics import RAW_TOPICS, relative
from shoecal_ros.recorder import Recorder
from shoecal_ros.refusal import RefusedError
from shoecal_ros.robot_files import RobotFiles
from shoecal_ros.runtime import ShoecalNode, run
from shoecal_ros.sensor_frames import frame_reader
from shoecal_ros.stillness import Stillness
from shoecal_ros.voltages import VoltageInput

TOGETHER_S = 0.3
"""Stamps of what came within this wall-clock time can be compared."""


@dataclass(frozen=True)
class CalibratorSettings(Settings):
    """Of the live side; wall-clock times."""

    state_dir: str = setting(
        "~/.ros/shoecal", "", "folder that keeps the calibration in force and the one before"
    )
    stale_s: float = setting(
        0.5, "s", "joint angles or voltages that did not come for so long are stale", minimum=0.01
    )
    hold_s: float = setting(
        0.03, "s", "for how long a cell's reading counts beside those of other boards", minimum=1e-3
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
    rezero_time: float = setting(
        2.0, "s", "of standing still, from which offsets are corrected", minimum=0.1
    )
    rezero_limit: float = setting(
        5.0, "N", "largest change of an offset that is still a drift", minimum=0.0
    )


class Calibrator(ShoecalNode):
    """Never silent about what its numbers are worth; one self-calibration at a time."""

    def __init__(self) -> None:
        super().__init__("calibrator")
        self.files = self.settings(RobotFiles)
        self.job_settings = self.settings(JobSettings)
        self.fit_settings = self.settings(CalibrationSettings, "calibration.")
        self.node_settings = settings = self.settings(CalibratorSettings)
        self.planning = self._load_planning()
        self.robot, self.shoe = self.files.load_robot(), self.files.load_shoe()
        self.kinematics = Kinematics(self.robot)
        self.joints = JointInput(self.robot, settings.stale_s)
        self.voltages = VoltageInput(
            FrameJoiner(self.shoe.names, settings.hold_s), settings.stale_s
        )
        job = self.job_settings
        self.stillness = Stillness(job.still_speed, job.still_time, job.still_resolution)
        self.recorder = Recorder(lambda: self.now_ns, job.lead_s)
        self._low_pass = LowPass(settings.low_pass_hz)
        self.live = LiveSensing(
            self.shoe.foot, LoadSwitch(settings.load_on_n, settings.load_off_n), self._low_pass
        )
        self._out = LivePublishers(self, self.shoe)
        self._job: CalibrationJob | None = None
        self._failure = ""
        store = CalibrationStore(Path(settings.state_dir).expanduser(), self.robot, self.shoe)
        self.desk = CalibrationDesk(self, store)
        self._subscribe()
        self.reach_client = ActionClient(self, ReachSupport, REACH_ACTION)
        self.plan_client = ActionClient(self, Plan, PLAN_ACTION)
        self.create_service(SelfCalibrate, "shoe/self_calibrate", self._self_calibrate)
        self._server = ActionServer(
            self, Calibrate, "shoe/calibrate", self._execute,
            cancel_callback=lambda _: CancelResponse.ACCEPT,
        )  # fmt: skip

    @property
    def armed(self) -> bool:
        """Whether the robot may be moved."""
        return self._arming.armed

    @property
    def calibrating(self) -> bool:
        """Whether a self-calibration is under way."""
        return self._job is not None

    def input_problem(self) -> str:
        """What is wrong with joint angles or voltages, and its cure; empty when all is well."""
        problem = self.joints.problem or self.voltages.problem
        latest, stamp_ns = self.joints.latest, self.voltages.latest_ns
        if problem or latest is None or stamp_ns is None:
            return problem
        if max(self.joints.age_s, self.voltages.age_s) > TOGETHER_S:
            return ""
        gap_s = abs(int(latest.stamp_ns[0]) - stamp_ns) / 1e9
        if gap_s > self.node_settings.clock_gap:
            return (
                f"stamps of joint angles and voltages are {gap_s:.1f} s apart; let both senders "
                "use one clock"
            )
        return ""

    def watch(self) -> None:
        """Tell how everything fares."""
        for subject, problem in (
            ("joints", self.joints.problem),
            ("voltages", self.voltages.problem),
        ):
            self.health.tell(
                subject, Level.ERROR if problem else Level.OK, problem or f"{subject} come"
            )
        self._tell_calibration()
        self._publish_state()
        super().watch()

    def close(self) -> None:
        """Keep what is being recorded."""
        self.recorder.abandon()

    # Input

    def _load_planning(self) -> PlannerSettings:
        file = self.job_settings.planner_file or config_dir() / "nodes" / "planner.yaml"
        return load_settings(PlannerSettings, Path(file), "planner", "planning")

    def _subscribe(self) -> None:
        """Everything a run may hold comes serialised: it is recorded as it was sent."""
        self._arming = ArmedInput(self)
        for topic, kind in RAW_TOPICS.items():
            if topic == schemas.JOINT_STATES:
                callback: Callable[[list[Any]], None] = self._hear_joints
            elif (read := frame_reader(topic, self.shoe)) is not None:
                callback = partial(self._hear_readings, topic, kind, read)
            else:
                callback = partial(self.recorder.take, topic)
            self.subscribe(kind, relative(topic), callback, qos.RAW, raw=True)

    def _hear_joints(self, serialised: list[bytes]) -> None:
        self.recorder.take(schemas.JOINT_STATES, serialised)
        batch = self.joints.take([deserialize_message(one, JointState) for one in serialised])
        if batch is None:
            return
        for stamp_ns, angles in zip(batch.stamp_ns.tolist(), batch.angles, strict=True):
            self.stillness.add(stamp_ns, angles)
        self.desk.take_joints(batch)

    def _hear_readings(
        self, topic: str, kind: type[Any], read: Callable[[Any], Any], serialised: list[bytes]
    ) -> None:
        self.recorder.take(topic, serialised)
        joined = self.voltages.take([read(deserialize_message(one, kind)) for one in serialised])
        self._out.publish(self.live.take(joined, self._support(joined)))
        self.desk.take_readings(joined)

    def _support(self, joined: list[Joined]) -> DoubleSupport | None:
        """Where the right foot stands, None where nobody knows or needs to."""
        latest = self.joints.latest
        if not joined or latest is None or self.live.sensing is None or not self.joints.fresh:
            return None
        return self.kinematics.states(latest.angles).support()

    # Telling

    def _publish_state(self) -> None:
        current = self.desk.store.current
        state = ShoeState.UNCALIBRATED if current is None else ShoeState.CALIBRATED
        self._out.publish_state(
            self.voltages.latest_ns or self.now_ns,
            ShoeState.CALIBRATING if self.calibrating else state,
            "" if current is None else current.id,
            self.live.flags(stale=not self.voltages.fresh),
            joints_stale=not self.joints.fresh,
        )

    def _tell_calibration(self) -> None:
        current, problem = self.desk.store.current, self.desk.problem or self._failure
        if self._job is not None:
            state = self._job.state
            self.health.tell(
                "calibration", Level.OK, "self-calibration under way",
                run_id=state.run_id, stage=state.stage,
                support=f"{state.support} of {state.supports}",
                progress=f"{state.progress:.2f}",
            )  # fmt: skip
        elif problem:
            self.health.tell("calibration", Level.ERROR, problem)
        elif current is None:
            self.health.tell(
                "calibration", Level.WARN,
                "uncalibrated: no forces are published; call shoe/self_calibrate",
            )  # fmt: skip
        else:
            self.health.tell(
                "calibration", Level.OK, f"'{current.id}' in force ({current.verdict})",
                delay_s=f"{self._low_pass.delay_s:.4f}",
            )  # fmt: skip

    # Self-calibration

    def _begin(
        self,
        goal: Any,
        feedback: Callable[[Calibrate.Feedback], None],
        canceled: Callable[[], bool],
    ) -> CalibrationJob:
        if self.calibrating:
            raise RefusedError(
                Calibrate.Result.BUSY, "a self-calibration is under way; wait for it or cancel it"
            )
        defaults = self.job_settings
        supports, train = goal.supports or defaults.supports, goal.train or defaults.train
        if not 2 <= train <= supports:
            raise RefusedError(
                Calibrate.Result.BAD_GOAL,
                f"{train} of {supports} double supports to train with; take at least 2, and at "
                "most all of them",
            )
        seed = goal.seed if goal.seed >= 0 else defaults.seed
        run_id = datetime.now(UTC).strftime("%Y%m%dT%H%M%S%f")[:-3]
        self._failure = ""
        self._job = CalibrationJob(self, Request(run_id, supports, train, seed), feedback, canceled)
        return self._job

    async def _do(self, job: CalibrationJob, result: Calibrate.Result) -> None:
        """Run a job to its end, and apply what it found where that may be applied."""
        try:
            calibration = await job.run()
            result.calibration = calibration_to_ros(calibration)
            job.tell_applying()
            self.desk.apply_found(calibration, warned=self.job_settings.apply_warned)
            result.success = True
            result.message = f"'{calibration.id}' in force: {'; '.join(calibration.reasons)}"
        finally:
            result.session = str(job.session or "")
            self._job = None

    async def _execute(self, goal: ServerGoalHandle) -> Calibrate.Result:
        result = Calibrate.Result()
        try:
            job = self._begin(goal.request, goal.publish_feedback, lambda: goal.is_cancel_requested)
            result.run_id = job.request.run_id
            await self._do(job, result)
        except RefusedError as refusal:
            result.error_code, result.message = refusal.code, str(refusal)
        finish(goal, result, canceled=Calibrate.Result.CANCELED)
        return result

    def _self_calibrate(
        self, request: SelfCalibrate.Request, response: SelfCalibrate.Response
    ) -> SelfCalibrate.Response:
        try:
            job = self._begin(request, lambda _: None, lambda: False)
        except RefusedError as refusal:
            response.message = str(refusal)
            return response
        self.start(partial(self._do_alone, job))
        response.accepted, response.run_id = True, job.request.run_id
        response.message = (
            "started; diagnostics tell how far it is; disarm (shoe/arm false) to stop"
        )
        return response

    async def _do_alone(self, job: CalibrationJob) -> None:
        result = Calibrate.Result()
        try:
            await self._do(job, result)
        except RefusedError as refusal:
            self._failure = f"self-calibration {job.request.run_id} ended: {refusal}"
        except Exception as error:  # noqa: BLE001 (live forces go on whatever happens here)
            self._failure = f"self-calibration ended by an internal error: {error!r}"


def main() -> None:
    """Run the node."""
    sys.exit(run(Calibrator))


if __name__ == "__main__":
    main()
