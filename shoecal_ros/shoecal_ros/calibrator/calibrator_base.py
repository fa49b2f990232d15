"""What all parts of the calibrator share: its settings, inputs, live forces and recorder."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from pathlib import Path

from rclpy.action import ActionClient
from rclpy.subscription import Subscription
from shoecal_msgs.action import Calibrate, Plan, ReachSupport

from shoecal_core.diagnosis.settings import DiagnosisSettings
from shoecal_core.error_sources.tolerances import Tolerances
from shoecal_core.errors import FieldError
from shoecal_core.estimation.calibration import Calibration, WrongShoeError, load_calibration
from shoecal_core.estimation.checks.drift import FALSE_ALARM
from shoecal_core.estimation.checks.standstill import ModelTolerance
from shoecal_core.parameter_file import load_settings
from shoecal_core.planning.settings import PlannerSettings
from shoecal_core.recording import schemas
from shoecal_core.robot.kinematics import Kinematics
from shoecal_core.screening.settings import CalibrationSettings, require_prior_counts
from shoecal_core.settings import setting
from shoecal_core.shoe.shoe import FEET
from shoecal_core.workspace import config_dir
from shoecal_ros.calibrator.force_samples import STANCE, SUM_FRAMES, ForceSamples
from shoecal_ros.calibrator.job_settings import JobSettings
from shoecal_ros.calibrator.live import LiveSensing, OutputFilter
from shoecal_ros.calibrator.load import LoadSwitch
from shoecal_ros.calibrator.raw_topics import RAW_TOPICS, relative
from shoecal_ros.calibrator.recorder import Recorder
from shoecal_ros.common import qos
from shoecal_ros.common.codes import Problem
from shoecal_ros.common.frames import FrameSettings
from shoecal_ros.common.node import ShoecalNode
from shoecal_ros.common.origin import Origin
from shoecal_ros.common.refusal import RefusedError
from shoecal_ros.common.robot_files import RobotFiles
from shoecal_ros.inputs.armed_input import ArmedInput
from shoecal_ros.inputs.arrival_monitor import SILENT_PERIODS, SILENT_S
from shoecal_ros.inputs.cell_watch import CellWatch
from shoecal_ros.inputs.joining import FrameJoiner, JoinSettings
from shoecal_ros.inputs.joints import JointInput
from shoecal_ros.inputs.one_clock import OneClock
from shoecal_ros.inputs.sensor_frames import frame_reader
from shoecal_ros.inputs.stillness import Stillness
from shoecal_ros.inputs.voltages import VoltageInput

REACH_ACTION, PLAN_ACTION = "robot/reach_support", "shoe/plan"


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


class CalibratorBase(ShoecalNode):
    """The calibrator without its services, which are built on it.

    Attributes:
        robot, shoe, kinematics: of the files.
        manual: prior of the fit; None: none.
        planning: settings of the planner node.
        joints, voltages, cells: inputs.
        arming, stillness: whether the robot may move, and whether it stands still.
        recorder: of runs.
        live, force_samples: from readings to forces; without a calibration they give none.
        tolerance: within which model and measurement agree.
        job_under_way: what may move the robot, for a sentence; empty: nothing.
    """

    def __init__(self, name: str) -> None:
        super().__init__(name)
        self.files = self.settings(RobotFiles)
        self.job_settings = job = self.settings(JobSettings)
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
        self.joints = JointInput(
            self.robot, settings.stale_s, self.awake, silent_s=silent_s, senders=senders
        )
        self.cells = CellWatch(self.shoe)
        of_foot = [self.shoe.of_foot(foot) for foot in range(len(FEET))]
        self.voltages = VoltageInput(
            FrameJoiner(self.shoe.names, settings.hold_s),
            settings.stale_s,
            silent_s=silent_s,
            watch=self.cells,
            of_foot=of_foot,
        )
        self.one_clock = OneClock(self.joints, self.voltages, settings.clock_gap)
        self.arming = ArmedInput(self)
        self.stillness = Stillness(job.still_speed, job.still_time, job.still_resolution)
        self.recorder = Recorder(lambda: self.now_ns, job.lead_s)
        self.low_pass = OutputFilter(settings.low_pass_hz)
        self.live = LiveSensing(
            of_foot, LoadSwitch(settings.load_on_n, settings.load_off_n), self.low_pass
        )
        self.frames = self.settings(FrameSettings).frames(self.robot)
        self.force_samples: ForceSamples | None = None
        self.tolerance = ModelTolerance.of(self.robot, self.fit_settings)
        self.reach_client = ActionClient(self, ReachSupport, REACH_ACTION)
        self.plan_client = ActionClient(self, Plan, PLAN_ACTION)
        self.job_under_way = ""
        self.moving_run_id = ""
        self._recorded: list[Subscription] = []

    @property
    def origin(self) -> Origin:
        """Of what is calibrated here and now."""
        return Origin.here(simulated=self.simulated, devices=self.voltages.sources)

    def refuse_second_job(self) -> None:
        """Only one job at a time; RefusedError where there is one."""
        if reported := self.job_under_way:
            raise RefusedError(
                Calibrate.Result.BUSY, f"{reported} is under way; wait for it or cancel it"
            )

    def begin_job(self, what: str, run_id: str, *, moves: bool) -> None:
        """A job is under way from now on, in which the robot is moved or not."""
        self.job_under_way, self._run_id = what, run_id
        self.moving_run_id = run_id if moves else ""

    def end_job(self) -> None:
        """It is no more: only what the live side needs is heard."""
        self.job_under_way = self._run_id = self.moving_run_id = ""
        self._listen_live()

    def input_problem(self) -> Problem | None:
        """What is wrong with joint angles or voltages, and its cure; None when all is well."""
        return self.joints.problem or self.voltages.problem or self.one_clock.problem

    def listen_for_recording(self) -> None:
        """Hear also what only a recording needs."""
        self._recorded = [
            self.subscribe(
                kind, relative(topic), partial(self.recorder.take, topic), qos.RAW, raw=True
            )
            for topic, kind in RAW_TOPICS.items()
            if topic != schemas.JOINT_STATES and frame_reader(topic, self.shoe) is None
        ]

    def _listen_live(self) -> None:
        """Hear only what the live side needs: every message that comes wakes the node."""
        for subscription in self._recorded:
            self.destroy_subscription(subscription)
        self._recorded = []

    def _load_planning(self) -> PlannerSettings:
        file = self.job_settings.planner_file or config_dir() / "nodes" / "planner.yaml"
        planner = f"{self.get_namespace().rstrip('/')}/planner"
        return load_settings(PlannerSettings, Path(file), planner, "planning")

    def _load_manual(self) -> Calibration | None:
        """The prior of the fit; FieldError where its file is none of these shoes."""
        if not self.job_settings.manual_file:
            return None
        require_prior_counts(self.fit_settings)
        path = Path(self.job_settings.manual_file).expanduser()
        manual = load_calibration(path)
        try:
            manual.sensing(self.shoe)
        except WrongShoeError as error:
            raise FieldError(path, f"{error}; name another manual_file") from error
        return manual
