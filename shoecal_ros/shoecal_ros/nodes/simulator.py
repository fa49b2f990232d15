"""Node `simulator`: the simulated robot and its shoes' device, in place of the real ones."""

from __future__ import annotations

import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from rclpy.action import ActionServer, CancelResponse
from rclpy.action.server import ServerGoalHandle
from rosgraph_msgs.msg import Clock
from shoecal_msgs.action import ReachSupport
from trajectory_msgs.msg import JointTrajectory as JointTrajectoryMsg

from shoecal_core.errors import ShoecalError
from shoecal_core.files import write_yaml
from shoecal_core.planning.legs import Legs
from shoecal_core.planning.posture import StanceSolver
from shoecal_core.planning.settings import PlannerSettings
from shoecal_core.recording.info import RunInfo
from shoecal_core.recording.truth import TruthWriter
from shoecal_core.robot.joint_trajectory import JointTrajectory
from shoecal_core.settings import Settings, setting
from shoecal_core.simulation.reality_file import load_reality
from shoecal_core.simulation.robot import RobotFellError, SimulatedRobot
from shoecal_core.simulation.sampled_robot import draw
from shoecal_core.workspace import config_dir
from shoecal_ros.common import qos
from shoecal_ros.common.actions import FEEDBACK_S, answered
from shoecal_ros.common.codes import Code
from shoecal_ros.common.conversions import (
    support_from_ros,
    time_from_ros,
    time_to_ros,
    trajectory_from_ros,
)
from shoecal_ros.common.health import Condition, Level
from shoecal_ros.common.hold import STOP_TIME_S, hold, is_hold
from shoecal_ros.common.node import ShoecalNode
from shoecal_ros.common.process import run
from shoecal_ros.common.refusal import RefusedError, faults_refused
from shoecal_ros.common.robot_files import RobotFiles
from shoecal_ros.common.waiting import until
from shoecal_ros.inputs.armed_input import ArmedInput
from shoecal_ros.inputs.arrival_monitor import ArrivalMonitor
from shoecal_ros.serial.device import SimulatedDevice
from shoecal_ros.serial.frame import Info
from shoecal_ros.simulator.body_publishers import BodyPublishers
from shoecal_ros.simulator.patient_publisher import PATIENCE_S
from shoecal_ros.simulator.simulated_body import BodySamples, Pacer, SimulatedBody

REAL_TIME = 1.0
"""Speed up to which it waits for no listener, as a real robot."""
TICK_S = 0.02
BATCH_S = 0.2
"""Most simulated time in one go: bounds how late commands are heard."""


@dataclass(frozen=True)
class SimulatorSettings(Settings):
    """What is simulated, and how fast."""

    reality_file: str = setting("", "", "changes to the default reality; empty: none")
    seed: int = setting(1, "", "draws robot, cells and noise", minimum=0)
    speed: float = setting(1.0, "", "simulated over wall-clock time", minimum=0.01, maximum=100.0)
    rate: float = setting(
        100.0, "Hz", "samples of joints and cells a simulated second", minimum=1.0, maximum=1000.0
    )
    port: str = setting("/tmp/shoecal_shoes", "", "link to the simulated device's serial port")  # noqa: S108
    truth_file: str = setting("", "", "file that takes the truth of CoP and GRF; empty: none")
    reach_timeout: float = setting(
        10.0, "s", "simulated time in which a placed robot must come to rest", minimum=1.0
    )
    needs_arming: bool = setting(True, "", "the robot moves only while armed")
    offer_reach_support: bool = setting(
        True, "", "it places itself in supports; false: the planner's own steps do (steps)"
    )


class SimulatorNode(ShoecalNode):
    """Owns simulated time; everything it sends carries the time of sampling."""

    def __init__(self) -> None:
        super().__init__("simulator")
        files = self.settings(RobotFiles)
        self._settings = settings = self.settings(SimulatorSettings)
        self._robot, shoe = files.load_robot(), files.load_shoe()
        override = Path(settings.reality_file) if settings.reality_file else None
        reality = load_reality(config_dir() / "realities" / "default.yaml", override)
        drawn = draw(reality, self._robot, shoe, settings.seed)
        noise = np.random.default_rng([settings.seed, 1])
        simulated = SimulatedRobot(self._robot, shoe, drawn, noise)
        self._body = SimulatedBody(simulated, settings.rate)
        self._stance = StanceSolver(Legs(self._robot), PlannerSettings())
        self._truth: TruthWriter | None = None
        if settings.truth_file:
            path = Path(settings.truth_file)
            info = RunInfo(
                1, "simulation", None, self._robot.name, shoe.name,
                self._robot.digest, shoe.digest, self._robot.urdf_digest,
            )  # fmt: skip
            self._truth = TruthWriter(path, info)
            write_yaml(path.with_suffix(".yaml"), drawn.record())
        channels = len(shoe.channels)
        self._device = SimulatedDevice(
            Path(settings.port),
            Info("shoecal simulator", 1, channels, settings.rate),
            patience_s=PATIENCE_S,
        )
        self._sampled = ArrivalMonitor(time.monotonic)
        self._sequence = 0
        self._arming = ArmedInput(self)
        self._reaching = self._moves = False
        self._refused = ""
        self._clock_publisher = self.create_publisher(Clock, "/clock", qos.CLOCK)
        self._body_publishers = BodyPublishers(
            self, self._robot, reality, waits=settings.speed > REAL_TIME
        )
        self.subscribe(JointTrajectoryMsg, "joint_trajectory", self._follow, qos.COMMAND)
        self._server: ActionServer | None = None
        if settings.offer_reach_support:
            self._server = ActionServer(
                self, ReachSupport, "robot/reach_support", self._execute,
                cancel_callback=lambda _: CancelResponse.ACCEPT,
            )  # fmt: skip
        most = max(1, round(BATCH_S * settings.rate))
        self._pacer = Pacer(settings.speed, settings.rate, most, time.monotonic())
        self.wall_timer(TICK_S, self._tick)

    def watch(self) -> None:
        """Report the condition of the simulation."""
        self.health.note("robot", self._condition)
        self.health.note("listeners", self._body_publishers.condition)
        super().watch()

    def close(self) -> None:
        """Unplug the device and finish the truth."""
        self._device.close()
        if self._truth is not None:
            self._truth.close()

    @property
    def _condition(self) -> Condition:
        """Of the simulated robot; figures are those of its samples."""
        figures = self._sampled.figures()
        figures |= {
            "real_time_factor": f"{float(figures['rate_hz']) / self._settings.rate:.3f}",
            "time_s": f"{self._body.now_ns / 1e9:.1f}",
            "frames_sent": str(self._device.sent),
            "frames_dropped": str(self._device.dropped),
        }
        if not self._body.robot.upright:
            reported = "the simulated robot has fallen; let it reach a support"
            return Condition(Level.ERROR, reported, figures, Code.ROBOT_FALLEN)
        if self._refused:
            return Condition(Level.WARN, self._refused, figures, Code.TRAJECTORY_REFUSED)
        return Condition(Level.OK, "stands", figures)

    # Time

    def _tick(self) -> None:
        count = self._pacer.due(time.monotonic())
        if not count:
            return
        # Nothing is stamped later than the clock shows.
        self._clock_publisher.publish(Clock(clock=time_to_ros(self._body.after(count))))
        samples = self._body.advance(count)
        self._sampled.note(count)
        self._body_publishers.publish(samples)
        self._send_frames(samples)
        if self._truth is not None:
            truth = samples.truth
            for index, stamp_ns in enumerate(samples.stamp_ns.tolist()):
                self._truth.write(
                    stamp_ns, truth.cop[index], truth.foot_cop[index], truth.foot_grf[index]
                )

    def _send_frames(self, samples: BodySamples) -> None:
        readings = samples.readings
        for stamp_ns, counts, status, temperature in zip(
            samples.stamp_ns.tolist(),
            readings.counts.tolist(),
            readings.status.tolist(),
            readings.temperature.tolist(),
            strict=True,
        ):
            self._device.send(
                self._sequence, stamp_ns // 1000, counts, status, temperature=temperature
            )
            self._sequence = (self._sequence + 1) % 2**32

    # Commands

    @property
    def _is_armed(self) -> bool:
        return self._arming.armed or not self._settings.needs_arming

    def _follow(self, messages: list[Any]) -> None:
        for message in messages:
            try:
                if self._reaching:
                    raise ShoecalError("the robot is being placed; send the trajectory afterwards")
                trajectory = trajectory_from_ros(message)
                if self._is_armed:
                    stamp_ns = time_from_ros(message.header.stamp)
                    # One without a point at its begin is for where the robot is by now.
                    placed = stamp_ns and trajectory.times[0] == 0.0
                    begun_s = (self._body.now_ns - stamp_ns) / 1e9 if placed else 0.0
                    self._body.robot.command(trajectory, max(0.0, begun_s))
                    self._moves = True
                else:
                    self._stop(trajectory)
                self._refused = ""
            except ShoecalError as error:
                self._refused = f"trajectory refused: {error}"

    def _stop(self, trajectory: JointTrajectory) -> None:
        """Come to rest once, where the robot is: what disarms a moving robot asks for it then.

        The positions of such a command do not count. Nor does the robot stop without it, though
        it is armed no more: some robots do not.
        """
        measured = self._body.robot.joints().angles
        if not is_hold(trajectory, self._robot, measured):
            raise ShoecalError("not armed: call the service shoe/arm first")
        if self._moves:
            self._body.robot.command(hold(self._robot, measured, STOP_TIME_S))
            self._moves = False

    async def _execute(self, goal: ServerGoalHandle) -> ReachSupport.Result:
        result = ReachSupport.Result()

        async def do() -> str:
            if self._reaching:
                raise RefusedError(result.FAILED, "another support is being reached; wait for it")
            self._reaching = True
            try:
                with (
                    self.working("placing the robot", goal.request.run_id),
                    faults_refused(self.log, result.FAILED),
                ):
                    await self._reach(goal)
            finally:
                self._reaching = False
            return "standing still"

        return await answered(goal, result, do)

    async def _reach(self, goal: ServerGoalHandle) -> None:
        """Place the robot in the support and let it settle."""
        codes = ReachSupport.Result
        if not self._is_armed:
            raise RefusedError(codes.NOT_ARMED, "not armed: call the service shoe/arm first")
        try:
            legs = self._stance.solve(support_from_ros(goal.request.support))
            self._body.place(self._robot.from_legs(legs))
        except ShoecalError as error:
            raise RefusedError(codes.UNREACHABLE, str(error)) from error
        while self._body.rested < 1.0:
            if goal.is_cancel_requested:
                raise RefusedError(
                    codes.CANCELED, "cancelled; the robot stands where it was placed"
                )
            try:
                self._body.robot.check_upright()
            except RobotFellError as error:
                raise RefusedError(codes.FELL, str(error)) from error
            if self._body.since_placed > self._settings.reach_timeout:
                raise RefusedError(
                    codes.FAILED,
                    f"the robot does not come to rest within {self._settings.reach_timeout:g} s; "
                    "choose another double support",
                )
            goal.publish_feedback(ReachSupport.Feedback(progress=self._body.rested))
            await until(lambda: self._body.rested >= 1.0 or goal.is_cancel_requested, FEEDBACK_S)


def main() -> None:
    """Run the node."""
    run(SimulatorNode)


if __name__ == "__main__":
    main()
