"""A recorded run done again by the simulated robot: the same commands from the same posture."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from shoecal_core.arrays import FloatArray
from shoecal_core.recording.errors import RecordingError
from shoecal_core.recording.run import Run
from shoecal_core.robot.joint_trajectory import JointTrajectory
from shoecal_core.robot.robot import Robot
from shoecal_core.shoe.shoe import Shoe
from shoecal_core.shoe.wrench import ChannelParameters
from shoecal_core.simulation.effects.effect import Effect
from shoecal_core.simulation.reality_file import load_reality
from shoecal_core.simulation.robot import SimulatedRobot
from shoecal_core.simulation.sampled_robot import SampledRobot, draw
from shoecal_core.simulation.snapshot import stack
from shoecal_core.workspace import config_dir

RATE_HZ = 25.0


@dataclass(frozen=True)
class Replayed:
    """Readings of the simulated robot at T instants of the recorded run.

    Attributes:
        run: its number.
        time: (T,) since the recorded run's start [s].
        readings: (T, n) in the shoe's unit.
    """

    run: int
    time: FloatArray
    readings: FloatArray


def like_the_model(
    robot: Robot, shoe: Shoe, parameters: ChannelParameters, effects: Sequence[Effect]
) -> SampledRobot:
    """A world as the model says, with cells of this law, and with effects.

    Args:
        parameters: gains and offsets: simulated readings are then like the recorded ones.
    """
    realities = config_dir() / "realities"
    rules = load_reality(realities / "default.yaml", realities / "perfect.yaml")
    drawn = draw(replace(rules, effects=tuple(effects)), robot, shoe, 0)
    return replace(drawn, shoes=replace(drawn.shoes, parameters=parameters))


def replay(run: Run, robot: Robot, shoe: Shoe, drawn: SampledRobot, begun: float) -> Replayed:
    """Put the simulated robot where the recorded one stood, and command it what that one was.

    Args:
        run: recorded, with its commands.
        robot, shoe: of the recording.
        drawn: the world it is put in.
        begun: when the run began, since the session's first sample [s].

    Raises:
        RecordingError: when the recording holds no commands.
        ShoecalError: for a robot that cannot be simulated, does not come to rest, or falls.
    """
    if not run.commanded:
        raise RecordingError(run.path, "holds no /joint_trajectory, so no motion can be replayed")
    sim = SimulatedRobot(robot, shoe, drawn, np.random.default_rng(0), made_at=begun)
    known = [name for name in run.joints.names if name in robot.joint_names]
    first = [run.joints.names.index(name) for name in known]
    place_showing(sim, robot.from_measured(known, run.joints.position[:1, first])[0])
    start = sim.time
    sim.begin_run(number=run.info.run)
    pending = sorted(run.commanded, key=lambda one: one.start)
    time = np.arange(run.readings.time[0], run.readings.time[-1], 1.0 / RATE_HZ)
    snapshots = []
    for instant in time:
        while pending and pending[0].start <= instant:
            command = pending.pop(0)
            sim.step_to(start + command.start)
            sim.command(
                JointTrajectory(command.names, command.time, command.position, command.velocity)
            )
        sim.step_to(start + instant)
        sim.check_upright()
        snapshots.append(sim.snapshot())
    return Replayed(run.info.run, time, sim.readings(stack(snapshots)).voltages)


def place_showing(sim: SimulatedRobot, joint_angles: FloatArray) -> None:
    """Put the robot down so that, at rest, its encoders show these angles.

    Servos give under load, so a robot that is commanded what another one showed stands lower than
    that one, and its feet push each other otherwise. What it misses is added to its command.

    Args:
        sim: to put down.
        joint_angles: (m,) as a recorded robot's encoders showed them [rad].

    Raises:
        SupportNotReachedError: when the soles are not level or it does not come to rest.
        RobotFellError: when it falls.
    """
    sim.place(joint_angles)
    commanded = 2.0 * joint_angles - sim.joints().angles
    for motor in sim.robot.shared:
        commanded[motor.joint] = motor.ratio * commanded[motor.leader]
    sim.place(np.clip(commanded, sim.robot.lower, sim.robot.upper))
