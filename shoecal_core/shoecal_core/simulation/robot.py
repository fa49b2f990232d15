"""The simulated robot: takes commands, gives what its sensors read, and knows the truth."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass

import mujoco
import numpy as np
from numpy.typing import NDArray

from shoecal_core.errors import ShapeError, ShoecalError
from shoecal_core.model.robot import Robot
from shoecal_core.sensing.shoe import Shoe
from shoecal_core.simulation import robot_physics
from shoecal_core.simulation.converter import Converter, Readings
from shoecal_core.simulation.drawn import DrawnReality
from shoecal_core.simulation.floor import FloorTruth, floor_truth
from shoecal_core.simulation.shoe_physics import ChannelOutputs, SoleReader
from shoecal_core.simulation.snapshot import Snapshot
from shoecal_core.simulation.trajectory import JointTrajectory

FloatArray = NDArray[np.float64]

SERVO_PERIOD = 0.01
"""s; a servo takes a new command that often and moves evenly in between."""

_DROP = 5e-4
"""m; from how high the soles are put down."""
_UNEVEN_HEIGHT, _UNEVEN_TILT = 0.01, 0.05
"""m, rad; soles farther from one level plane than this do not stand flat."""
_FALLEN_TILT, _FALLEN_HEIGHT = 1.0, 0.7
"""rad, and part of the standing height: a torso beyond either has fallen."""
_REST_SPEED, _REST_TIME = 2e-3, 0.5
"""m/s, rad/s: slower than this, for that long [s], is at rest."""


class RobotFellError(ShoecalError):
    """The robot fell.

    Attributes:
        time: simulated time [s].
    """

    def __init__(self, robot: str, time: float, tilt: float, height: float) -> None:
        self.time = time
        super().__init__(
            f"simulated robot '{robot}' fell at {time:.2f} s (torso tilted by {tilt:.2f} rad, at "
            f"{height:.0%} of its standing height); plan a slower motion or a wider stance"
        )


class SupportNotReachedError(ShoecalError):
    """The robot could not be brought to stand still in a double support."""


@dataclass(frozen=True)
class JointReadings:
    """What the robot tells of its joints, m of them.

    Attributes:
        angles: as encoders show them [rad].
        efforts: torque of each joint's motor [N m].
        temperatures: of each joint's motor [degC].
    """

    angles: FloatArray
    efforts: FloatArray
    temperatures: FloatArray


class SimulatedRobot:
    """A robot on simulated shoes, in simulated time.

    The forces that MuJoCo knows belong to the start of its last step. So the physics is kept
    one step ahead, and everything read here belongs to one instant: `time`.

    Attributes:
        robot, shoe, drawn: what is simulated.
        physics: as MuJoCo runs it.
        data: MuJoCo's state.
    """

    def __init__(
        self, robot: Robot, shoe: Shoe, drawn: DrawnReality, noise: np.random.Generator
    ) -> None:
        """Stands in the robot's own posture.

        Args:
            robot: with the shoes on (`load_robot(path, shoe)`).
            shoe: what it wears.
            drawn: as both truly are.
            noise: draws the noise of readings.

        Raises:
            ShoecalError: for a robot or shoe that cannot be simulated.
        """
        self.robot, self.shoe, self.drawn = robot, shoe, drawn
        self.physics = robot_physics.build(robot, shoe, drawn)
        self._model = self.physics.model
        self.data = mujoco.MjData(self._model)
        self._outputs = ChannelOutputs(self._model, shoe)
        self._soles = SoleReader(self._model)
        self._converter = Converter(shoe, drawn.rules, drawn.shoes, noise)
        self._latency = drawn.shoes.latency
        self._base = self._model.body(drawn.body.links[0]).id
        self._steps_per_command = max(1, round(SERVO_PERIOD / drawn.rules.step_s))
        self._leaders = np.array(
            [robot.joint(self._model.actuator(i).name) for i in range(self._model.nu)]
        )
        self.reset(robot.posture)

    @property
    def time(self) -> float:
        """Simulated time [s]."""
        return self._steps * self.drawn.rules.step_s

    @property
    def weight(self) -> float:
        """True weight of robot and shoes [N]."""
        return float(self._model.body_mass.sum() * np.linalg.norm(self._model.opt.gravity))

    # Commands

    def reset(self, joint_angles: FloatArray) -> None:
        """Put the robot just above the floor, motionless, time 0, both soles as flat as can be.

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
        told = still.positions[0]
        self._check_soles(told)
        self._pose(told - self.drawn.body.encoder_error)
        self._lower_to_floor()
        self._steps = 0
        self._follow(still)
        self.data.act[:] = self._set_points[0]
        self._heat = np.zeros(self._model.nu)
        self._standing_height = float(self.data.xpos[self._base, 2])
        self._felt: deque[tuple[float, FloatArray]] = deque()
        mujoco.mj_step(self._model, self.data)
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

    def command(self, trajectory: JointTrajectory) -> None:
        """Follow a trajectory from now on, and hold its last point.

        Raises:
            NameNotFoundError: for a joint that the robot does not have.
            ShoecalError: for positions beyond a joint's limits, or two for one motor.
        """
        now = self._command.at(np.array(self.time - self._command_start))
        self._follow(trajectory.full(self.robot, now))

    def step_to(self, time: float) -> None:
        """Run the physics up to the last step that is not after a time [s].

        The motion does not depend on when it is looked at.
        """
        step = self.drawn.rules.step_s
        last = math.floor(time / step + 1e-6)
        while self._steps < last:
            period, done = divmod(self._steps, self._steps_per_command)
            if done == 0:
                row = min(period + 1 - self._first_period, len(self._set_points) - 1)
                way = self._set_points[row] - self.data.act
                self.data.ctrl[:] = way / (self._steps_per_command * step)
            count = min(last - self._steps, self._steps_per_command - done)
            mujoco.mj_step(self._model, self.data, nstep=count)
            self._steps += count
            self._warm(count * step)
            self._remember()

    # Readings

    def snapshot(self) -> Snapshot:
        """Everything that can be read, now."""
        data = self.data
        position, rotation = self._soles.pose(data)
        w, x, y, z = data.xquat[self._base].tolist()
        return Snapshot(
            time=np.array(self.time),
            motor_angle=data.actuator_length.copy(),
            motor_torque=data.actuator_force.copy(),
            motor_heat=self._heat,
            felt=self._late(self._outputs(data)),
            contact=self._soles.contact(data),
            sole_position=position,
            sole_rotation=rotation,
            base_position=data.xpos[self._base].copy(),
            base_orientation=np.array([x, y, z, w]),
        )

    def joints(self, at: Snapshot | None = None) -> JointReadings:
        """What the robot tells of its joints, now or at other instants."""
        snap = self.snapshot() if at is None else at
        physics, servo = self.physics, self.drawn.rules.servo
        angles = physics.ratio * snap.motor_angle[..., physics.motor]
        angles = angles + self.drawn.body.encoder_error
        resolution = self.drawn.rules.joints.encoder_resolution_rad
        if resolution > 0.0:
            angles = np.rint(angles / resolution) * resolution
        return JointReadings(
            angles=angles,
            efforts=snap.motor_torque[..., physics.motor],
            temperatures=servo.ambient_degc + snap.motor_heat[..., physics.motor],
        )

    def readings(self, at: Snapshot | None = None) -> Readings:
        """What the channels' converter gives, now or for other instants in their order."""
        snap = self.snapshot() if at is None else at
        return self._converter(snap.felt)

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

    def _follow(self, command: JointTrajectory) -> None:
        """Take a command for all joints from now on."""
        period = self._steps_per_command * self.drawn.rules.step_s
        self._command, self._command_start = command, self.time
        self._first_period = self._steps // self._steps_per_command
        count = math.ceil(command.duration / period) + 2
        ends = np.arange(self._first_period, self._first_period + count, dtype=np.float64) * period
        angles = command.at(ends - self._command_start) - self.drawn.body.encoder_error
        # What the servos aim at, given what their encoders show, at the end of each period.
        self._set_points = angles[:, self._leaders]

    def _pose(self, motor_angles: FloatArray) -> None:
        """Joints at these angles, everything else at zero, the root at the origin."""
        mujoco.mj_resetData(self._model, self.data)
        self.data.qpos[self.physics.positions] = motor_angles
        mujoco.mj_kinematics(self._model, self.data)

    def _check_soles(self, angles: FloatArray) -> None:
        self._pose(angles)
        (left, right), (to_left, to_right) = self._soles.pose(self.data)
        height = abs(float((to_left.T @ (right - left))[2]))
        tilt = math.acos(min(1.0, float(to_left[:, 2] @ to_right[:, 2])))
        if height > _UNEVEN_HEIGHT or tilt > _UNEVEN_TILT:
            raise SupportNotReachedError(
                f"robot '{self.robot.name}' cannot stand with these joint angles: its soles are "
                f"{height * 1e3:.0f} mm apart in height and {tilt:.2f} rad in tilt; give angles "
                "that put both soles flat"
            )

    def _lower_to_floor(self) -> None:
        """Left sole on the world's origin, its outline and the right one's just above the floor."""
        (left, _), (to_left, _) = self._soles.pose(self.data)
        base, turn = np.zeros(3), np.zeros(4)
        mujoco.mju_mat2Quat(turn, to_left.T.ravel())
        base[:] = -to_left.T @ left
        self.data.qpos[3:7] = turn
        self.data.qpos[:3] = base
        mujoco.mj_kinematics(self._model, self.data)
        positions, rotations = self._soles.pose(self.data)
        lowest = min(
            float((position + rotation[:, :2] @ corner)[2])
            for position, rotation, foot in zip(positions, rotations, self.robot.feet, strict=True)
            for corner in foot.outline
        )
        self.data.qpos[2] += _DROP - lowest
        mujoco.mj_kinematics(self._model, self.data)

    def _posture(self) -> tuple[float, float]:
        """Tilt of the torso [rad], and its height over the standing one."""
        up = float(self.data.xmat[self._base, 8])
        height = float(self.data.xpos[self._base, 2]) / self._standing_height
        return math.acos(max(-1.0, min(1.0, up))), height

    def _warm(self, span: float) -> None:
        """Motors warm up with the square of their torque, and cool to what is around them."""
        servo = self.drawn.rules.servo
        load = self.data.actuator_force / self.physics.torque_limit
        kept = math.exp(-span / servo.temperature_time_s)
        self._heat = kept * self._heat + (1.0 - kept) * servo.temperature_rise_degc * load**2

    def _remember(self) -> None:
        """Keep what channels felt for as long as a late reading may ask for it."""
        if not self._latency.any():
            return
        self._felt.append((self.time, self._outputs(self.data)))
        while len(self._felt) > 2 and self._felt[1][0] < self.time - self._latency.max():
            self._felt.popleft()

    def _late(self, felt: FloatArray) -> FloatArray:
        """What channels felt when the readings that come now were taken."""
        late = np.flatnonzero(self._latency)
        if late.size:
            times, past = (np.array(column) for column in zip(*self._felt, strict=True))
            for channel in late:
                then = self.time - self._latency[channel]
                felt[channel] = np.interp(then, times, past[:, channel])
        return felt
