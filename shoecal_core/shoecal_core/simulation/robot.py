"""The simulated robot: takes commands, gives what its sensors read, and knows the truth."""

from __future__ import annotations

import math
from collections.abc import Sequence

import mujoco
import numpy as np

from shoecal_core.arrays import FloatArray
from shoecal_core.errors import ShapeError
from shoecal_core.robot.joint_trajectory import JointTrajectory
from shoecal_core.robot.robot import Robot
from shoecal_core.shoe.shoe import Shoe
from shoecal_core.simulation import robot_physics
from shoecal_core.simulation.converter import AdConverter, ConvertedReadings
from shoecal_core.simulation.disturbances import Disturbance
from shoecal_core.simulation.faults import RobotFellError, SupportNotReachedError
from shoecal_core.simulation.floor import FloorTruth, floor_truth, sideways_forces
from shoecal_core.simulation.imu import Imu, ImuReadings, base_motion
from shoecal_core.simulation.joint_friction import BristleFriction
from shoecal_core.simulation.joint_sensors import Encoders, JointReadings, JointSensors
from shoecal_core.simulation.posing import Posing
from shoecal_core.simulation.sampled_robot import SampledRobot
from shoecal_core.simulation.sensor_chain import NO_SIDEWAYS, SensorChain
from shoecal_core.simulation.set_points import SERVO_PERIOD, SetPoints
from shoecal_core.simulation.shoe_physics import ChannelOutputs, SoleReader, floor_rotation
from shoecal_core.simulation.snapshot import Snapshot
from shoecal_core.simulation.stepping import advance

__all__ = ["RobotFellError", "SimulatedRobot", "SupportNotReachedError"]

_FALLEN_TILT, _FALLEN_HEIGHT = 0.5, 0.5
"""rad of the flatter sole, and the CoM's part of its standing height: beyond either, the robot has
fallen. A torso may lean as planned, and a base frame may be anywhere, at the floor too."""
_REST_SPEED, _REST_TIME = 2e-3, 0.5
"""m/s, rad/s: slower than this, for that long [s], is at rest."""


class SimulatedRobot:
    """A robot on simulated shoes, in simulated time.

    The forces that MuJoCo knows belong to the start of its last step. So the physics is kept
    one step ahead, and everything read here belongs to one instant: `time`.

    Attributes:
        robot, shoe, drawn: what is simulated.
        physics: as MuJoCo runs it.
        data: MuJoCo's state.
        run: number of the session's run that was begun last, from 1; 0 before the first.
        strain: (a,) what servos aim at in this period less their commands [rad].
    """

    def __init__(
        self,
        robot: Robot,
        shoe: Shoe,
        drawn: SampledRobot,
        noise: np.random.Generator,
        *,
        made_at: float = 0.0,
    ) -> None:
        """Stands in the robot's own posture.

        Args:
            robot: with the shoes on (`load_robot(path, shoe)`).
            shoe: what it wears.
            drawn: as both truly are.
            noise: draws the noise of readings.
            made_at: the session's time at which it is put on the floor [s].

        Raises:
            ShoecalError: for a robot or shoe that cannot be simulated.
        """
        self.robot, self.shoe, self.drawn = robot, shoe, drawn
        self.physics = robot_physics.build(robot, shoe, drawn)
        self._model = self.physics.model
        self.data = mujoco.MjData(self._model)
        self.strain = np.zeros(self._model.nu)
        self._posing = Posing(robot, self.physics)
        self._encoders = Encoders(drawn.body)
        self._joints = JointSensors(self.physics, drawn)
        self._friction = BristleFriction(
            self._model,
            drawn.body.joints,
            drawn.body.friction,
            drawn.rules.joints.stribeck_speed_rad_per_s,
        )
        self._outputs = ChannelOutputs(self._model, shoe)
        self._soles = SoleReader(self._model)
        self._converter = AdConverter(shoe, drawn.rules, drawn.shoes, noise)
        # A stream of its own: whether the sensor is read does not change the cells' noise.
        self._imu = Imu(
            drawn.rules.imu,
            drawn.body.imu_mounting,
            floor_rotation(drawn.shoes),
            noise.spawn(1)[0],
        )
        self._chain = SensorChain(drawn.shoes, made_at)
        self._before = made_at
        self._steps = 0
        self._base = self._model.body(drawn.body.links[0]).id
        self._leaders = np.array(
            [robot.joint(self._model.actuator(i).name) for i in range(self._model.nu)]
        )
        self._heat = np.zeros(self._model.nu)
        self._always = [one for effect in drawn.rules.effects for one in effect.disturbances()]
        self._acting = self._always
        self._run_begin: float | None = None
        self.run = 0
        self.reset(robot.posture)

    @property
    def time(self) -> float:
        """Simulated time [s]."""
        return self._steps * self.drawn.rules.step_s

    @property
    def session_time(self) -> float:
        """Simulated time of the session, wherever the robot was put in between [s]."""
        return self._before + self.time

    @property
    def run_time(self) -> float:
        """Simulated time since the run began [s]; minus infinity before it begins."""
        return -math.inf if self._run_begin is None else self.time - self._run_begin

    @property
    def weight(self) -> float:
        """True weight of robot and shoes [N]."""
        return float(self._model.body_mass.sum() * np.linalg.norm(self._model.opt.gravity))

    # Commands

    def reset(self, joint_angles: FloatArray) -> None:
        """Put the robot just above the floor, motionless, both soles as flat as can be.

        Time starts at 0 again; motors stay as warm as they are, and the session's time goes on.

        Args:
            joint_angles: (m,) as encoders shall show them [rad].

        Raises:
            SupportNotReachedError: when these angles do not put both soles on one plane.
        """
        count = len(self.robot.joint_names)
        if joint_angles.shape != (count,):
            raise ShapeError("joint angles", f"({count},)", joint_angles.shape)
        still = JointTrajectory(self.robot.joint_names, np.zeros(1), joint_angles[None])
        still = still.full(self.robot, joint_angles)
        angles = still.positions[0]
        self._posing.check(angles)
        self._posing.put(self.data, self._encoders.angles(angles))
        self._before, self._steps = self.session_time, 0
        self._run_begin, self._acting = None, self._always
        self._set_points = SetPoints(still, self._steps, self.drawn.rules.step_s)
        self.data.act[:] = self._motor_angles(angles)
        mujoco.mj_comPos(self._model, self.data)
        self._standing_height = self._com_height()
        self._chain.lift()
        self._friction.release(self.data)
        advance(self._model, self.data)
        self._remember()

    def place(self, joint_angles: FloatArray, *, patience: float = 10.0) -> None:
        """Put the robot down and wait until it stands still; time starts at 0 again.

        Args:
            joint_angles: (m,) as encoders shall show them [rad].
            patience: longest simulated time to wait [s].

        Raises:
            SupportNotReachedError: when the soles are not level or it does not come to rest.
            RobotFellError: when it falls.
        """
        self.reset(joint_angles)
        still_since = 0.0
        while self.time < still_since + _REST_TIME:
            self.step_to(self.time + SERVO_PERIOD)
            self.check_upright()
            speed = float(np.abs(self.data.qvel).max())
            if speed > _REST_SPEED:
                still_since = self.time
            if self.time > patience:
                raise SupportNotReachedError(
                    f"simulated robot '{self.robot.name}' does not come to rest within "
                    f"{patience:g} s (still {speed:.3g} m/s or rad/s); choose another stance or "
                    "raise servo.damping_time_s of the reality"
                )

    def begin_run(
        self, disturbances: Sequence[Disturbance] = (), *, number: int | None = None
    ) -> None:
        """Begin a run of the session: what an effect does at a time in a run counts from now.

        Args:
            disturbances: what acts on the robot in this run, in addition to its effects.
            number: of the run; None for the next.
        """
        self.run = self.run + 1 if number is None else number
        self._run_begin = self.time
        self._chain.run = self.run
        # Its first reading already has what cells show in this run.
        self._remember()
        self._acting = [*self._always, *disturbances]
        self._disturb()

    def command(self, trajectory: JointTrajectory, begun_s: float = 0.0) -> None:
        """Follow a trajectory from now on, and hold its last point.

        Args:
            trajectory: of some joints.
            begun_s: since when it should have been followed [s].

        Raises:
            NameNotFoundError: for a joint that the robot does not have.
            ShoecalError: for positions beyond a joint's limits, or two for one motor.
        """
        command = trajectory.full(self.robot, self._set_points.at_step(self._steps))
        step_s = self.drawn.rules.step_s
        self._set_points = SetPoints(command, self._steps - round(begun_s / step_s), step_s)

    def step_to(self, time: float) -> None:
        """Run the physics up to the last step that is not after a time [s].

        The motion does not depend on when it is looked at.
        """
        step, length = self.drawn.rules.step_s, self._set_points.steps_per_period
        last = math.floor(time / step + 1e-6)
        while self._steps < last:
            period, done = divmod(self._steps, length)
            if done == 0:
                self._disturb()
                end = self._motor_angles(self._set_points.at_period(period + 1)) + self.strain
                self.data.ctrl[:] = (end - self.data.act) / (length * step)
            count = min(last - self._steps, length - done)
            self._step(count)
            self._steps += count
            self._warm(count * step)
            if done + count == length:
                self._remember()

    # Readings

    def snapshot(self) -> Snapshot:
        """Everything that can be read, now."""
        data = self.data
        position, rotation = self._soles.pose(data)
        w, x, y, z = data.xquat[self._base].tolist()
        rate, force = base_motion(self._model, data, self._base)
        return Snapshot(
            time=np.array(self.time),
            session_time=np.array(self.session_time),
            motor_angle=data.actuator_length.copy(),
            motor_torque=data.actuator_force.copy(),
            motor_heat=self._heat,
            felt=self._reaching(),
            contact=self._soles.contact(data),
            sole_position=position,
            sole_rotation=rotation,
            base_position=data.xpos[self._base].copy(),
            base_orientation=np.array([x, y, z, w]),
            base_rate=rate,
            base_force=force,
        )

    def joints(self, at: Snapshot | None = None) -> JointReadings:
        """What the robot reports of its joints, now or at other instants."""
        snap = self.snapshot() if at is None else at
        return self._joints(snap)

    def readings(self, at: Snapshot | None = None) -> ConvertedReadings:
        """What the channels' converter gives, now or for other instants in their order."""
        snap = self.snapshot() if at is None else at
        return self._converter(snap.felt, snap.session_time)

    def imu(self, at: Snapshot | None = None) -> ImuReadings | None:
        """What the inertial sensor measures, now or at other instants; None where there is none."""
        if not self.drawn.rules.imu.present:
            return None
        return self._imu(self.snapshot() if at is None else at)

    def truth(self, at: Snapshot | None = None) -> FloorTruth:
        """What the floor does to the feet, now or at other instants."""
        snap = self.snapshot() if at is None else at
        return floor_truth(snap.contact, snap.sole_position, snap.sole_rotation)

    @property
    def upright(self) -> bool:
        """Whether the robot still stands."""
        tilt, height = self._posture()
        return tilt < _FALLEN_TILT and height > _FALLEN_HEIGHT

    def check_upright(self) -> None:
        """Raise RobotFellError when it no longer stands."""
        if not self.upright:
            raise RobotFellError(self.robot.name, self.time, *self._posture())

    # Inside

    def _step(self, count: int) -> None:
        """Let the physics run for some steps; friction slips before each."""
        if not self._friction.acts:
            advance(self._model, self.data, count)
            return
        for _ in range(count):
            self._friction.slip(self.data)
            advance(self._model, self.data)

    def _motor_angles(self, shown: FloatArray) -> FloatArray:
        """(a,) what the servos aim at so that their encoders show joint angles (m,)."""
        angles: FloatArray = self._encoders.angles(shown)[self._leaders]
        return angles

    def _posture(self) -> tuple[float, float]:
        """Tilt of the flatter sole [rad], and the CoM's height over its standing one."""
        up = float(self._soles.pose(self.data)[1][:, 2, 2].max())
        height = self._com_height() / self._standing_height
        return math.acos(max(-1.0, min(1.0, up))), height

    def _com_height(self) -> float:
        """Of robot and shoes above the floor [m]."""
        return float(self.data.subtree_com[self._base, 2])

    def _warm(self, span: float) -> None:
        """Motors warm up with the square of their torque, and cool to what is around them."""
        servo = self.drawn.rules.servo
        load = self.data.actuator_force / self.physics.torque_limit
        kept = math.exp(-span / servo.temperature_time_s)
        self._heat = kept * self._heat + (1.0 - kept) * servo.temperature_rise_degc * load**2

    def _disturb(self) -> None:
        """Let whatever acts on the robot do what is due; forces of the moment before are gone."""
        self.data.xfrc_applied[:] = 0.0
        self.data.qfrc_applied[:] = 0.0
        self.strain[:] = 0.0
        for disturbance in self._acting:
            disturbance.act(self, self.run_time)

    def _remember(self) -> None:
        """Move the sensors' signals on."""
        if self._chain.active:
            self._chain.take(self._outputs(self.data), self.session_time, self._sideways())

    def _reaching(self) -> FloatArray:
        """(n,) what reaches the channels' converter now [N or N m]."""
        chain, now = self._chain, self.session_time
        if chain.active and chain.time == now:
            return chain.latest()
        felt = self._outputs(self.data)
        return chain.at(felt, now, self._sideways()) if chain.active else felt

    def _sideways(self) -> FloatArray:
        """(2, 2) the floor's sideways forces on the feet, where a sensor feels them [N]."""
        if not self._chain.feels_sideways:
            return NO_SIDEWAYS
        _, rotation = self._soles.pose(self.data)
        return sideways_forces(self._soles.contact(self.data)[:, :3], rotation)
