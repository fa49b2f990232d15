"""What a simulated robot did, written down as a run of a session and its truth."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from shoecal_core.arrays import FloatArray, IntArray
from shoecal_core.planning.motion_sets import PlannedRun
from shoecal_core.recording import messages, schemas
from shoecal_core.recording.info import RunInfo
from shoecal_core.recording.messages import series
from shoecal_core.recording.session import Session
from shoecal_core.robot.joint_trajectory import JointTrajectory
from shoecal_core.simulation.robot import SimulatedRobot
from shoecal_core.simulation.samples import SimulatedSamples

Stamps = IntArray
Message = tuple[int, str, bytes]
"""Stamp [ns], topic, CDR bytes."""

_TEMPERATURE_PERIOD = 1.0
"""s; motors and shoes report their temperature that often."""


def record_run(
    session: Session,
    sim: SimulatedRobot,
    planned: PlannedRun,
    commanded: JointTrajectory,
    samples: SimulatedSamples,
    *,
    start_ns: int,
    hold: float,
) -> int:
    """Write one run, and with it the truth.

    Args:
        session: to add it to.
        sim: that did it.
        planned: what it is.
        commanded: the trajectory it followed.
        samples: of the whole run.
        start_ns: stamp of the first sample [ns].
        hold: how long it stood still before the trajectory [s].

    Returns:
        The run's number.
    """
    stamps = start_ns + np.rint(1e9 * (samples.time - samples.time[0])).astype(np.int64)
    command_ns = start_ns + round(1e9 * hold)
    command = messages.joint_trajectory(
        command_ns, commanded.names, commanded.times, commanded.positions
    )
    sources = [
        [(command_ns, schemas.JOINT_TRAJECTORY, command)],
        _joints(sim, samples, stamps),
        _voltages(sim, samples, stamps),
        _imu(sim, samples, stamps),
        _motor_temperatures(sim, samples, stamps),
        _shoe_temperature(samples, stamps),
    ]
    written = [message for source in sources for message in source]
    written.sort(key=lambda message: message[0])
    with session.new_run(planned.motion, planned.support, hint=planned.hint, live=False) as writer:
        for stamp, topic, message in written:
            writer.write(topic, message, stamp)
    _record_truth(session, writer.info, samples, stamps)
    return writer.info.run


def _joints(sim: SimulatedRobot, samples: SimulatedSamples, stamps: Stamps) -> Iterator[Message]:
    names, joints = sim.robot.joint_names, samples.joints
    count = len(names)

    def one(stamp: int, numbers: FloatArray) -> bytes:
        return messages.joint_state(stamp, names, numbers[:count], numbers[count:])

    made = series(one, stamps, np.hstack((joints.angles, joints.efforts)))
    for stamp, message in zip(stamps.tolist(), made, strict=True):
        yield stamp, schemas.JOINT_STATES, message


def _voltages(sim: SimulatedRobot, samples: SimulatedSamples, stamps: Stamps) -> Iterator[Message]:
    readings = samples.readings
    for index, stamp in enumerate(stamps.tolist()):
        message = messages.shoe_voltages(
            stamp, index, sim.shoe.names, readings.voltages[index], readings.status[index],
            temperature=float(readings.temperature[index]),
        )  # fmt: skip
        yield stamp, schemas.VOLTAGES, message


def _imu(sim: SimulatedRobot, samples: SimulatedSamples, stamps: Stamps) -> Iterator[Message]:
    imu, frame = samples.imu, sim.drawn.body.links[0]
    if imu is None:
        return

    def one(stamp: int, numbers: FloatArray) -> bytes:
        return messages.imu(stamp, frame, numbers[:4], numbers[4:7], numbers[7:])

    numbers = np.hstack((imu.orientation, imu.angular_velocity, imu.linear_acceleration))
    for stamp, message in zip(stamps.tolist(), series(one, stamps, numbers), strict=True):
        yield stamp, schemas.IMU, message


def _motor_temperatures(
    sim: SimulatedRobot, samples: SimulatedSamples, stamps: Stamps
) -> Iterator[Message]:
    if not sim.drawn.rules.servo.temperatures_told:
        return
    moved = [sim.robot.joint_names[index] for index in sim.robot.moved]
    for index in _sparse(samples):
        stamp = int(stamps[index])
        temperatures = samples.joints.temperatures[index, sim.robot.moved]
        for name, value in zip(moved, temperatures, strict=True):
            yield stamp, schemas.JOINT_TEMPERATURES, messages.temperature(stamp, name, value)


def _shoe_temperature(samples: SimulatedSamples, stamps: Stamps) -> Iterator[Message]:
    temperature = samples.readings.temperature
    for index in _sparse(samples):
        if np.isfinite(temperature[index]):
            stamp = int(stamps[index])
            message = messages.temperature(stamp, "", temperature[index])
            yield stamp, schemas.SHOE_TEMPERATURE, message


def _sparse(samples: SimulatedSamples) -> list[int]:
    """Samples that are a temperature's period apart."""
    periods = np.floor((samples.time - samples.time[0]) / _TEMPERATURE_PERIOD + 1e-6)
    return [int(index) for index in np.unique(periods, return_index=True)[1]]


def _record_truth(
    session: Session, info: RunInfo, samples: SimulatedSamples, stamps: Stamps
) -> None:
    true = samples.truth
    with session.new_truth(info) as truth:
        truth.write_all(stamps, true.cop, true.foot_cop, true.foot_grf)
