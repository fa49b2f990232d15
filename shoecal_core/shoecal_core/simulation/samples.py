"""A whole motion of the simulated robot as arrays, without ROS."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from shoecal_core.arrays import FloatArray
from shoecal_core.errors import ShoecalError
from shoecal_core.robot.joint_trajectory import JointTrajectory
from shoecal_core.simulation.converter import ConvertedReadings
from shoecal_core.simulation.disturbances import Disturbance
from shoecal_core.simulation.floor import FloorTruth
from shoecal_core.simulation.imu import ImuReadings
from shoecal_core.simulation.joint_sensors import JointReadings
from shoecal_core.simulation.robot import SimulatedRobot
from shoecal_core.simulation.snapshot import stack

HOLD_S = 0.5
"""A run stands still for so long before and after its motion, as the calibrator's `lead_s`."""


@dataclass(frozen=True)
class SimulatedSamples:
    """T samples of everything, all taken at the same instants.

    Attributes:
        time: (T,) simulated time [s].
        joints: arrays (T, m).
        readings: arrays (T, n).
        imu: arrays (T, ...); None where there is no such sensor.
        truth: arrays (T, ...).
        sole_position: (T, 2, 3) of the true left, right sole over the floor [m].
        base_position: (T, 3) of the root link over the floor [m].
        base_orientation: (T, 4) x, y, z, w.
    """

    time: FloatArray
    joints: JointReadings
    readings: ConvertedReadings
    imu: ImuReadings | None
    truth: FloorTruth
    sole_position: FloatArray
    base_position: FloatArray
    base_orientation: FloatArray


def run(
    sim: SimulatedRobot,
    trajectory: JointTrajectory,
    rate: float,
    *,
    hold: float = HOLD_S,
    disturbances: Sequence[Disturbance] = (),
) -> SimulatedSamples:
    """Let the robot follow a trajectory, standing still before and after it: one run.

    Args:
        sim: a robot at rest (`place`).
        trajectory: to follow.
        rate: samples a second.
        hold: how long it stands before and after [s].
        disturbances: what acts on it meanwhile.

    Raises:
        RobotFellError: when it falls.
        ShoecalError: for a trajectory it cannot follow, or a rate of nothing.
    """
    if not rate > 0.0:
        raise ShoecalError(f"a rate of {rate:g} Hz gives no samples; it must be above 0")
    start = sim.time
    sim.begin_run(disturbances)
    begin, count = round(hold * rate), round((2.0 * hold + trajectory.duration) * rate) + 1
    snapshots = []
    for index in range(count):
        sim.step_to(start + index / rate)
        if index == begin:
            sim.command(trajectory)
        sim.check_upright()
        snapshots.append(sim.snapshot())
    all_ = stack(snapshots)
    return SimulatedSamples(
        time=all_.time,
        joints=sim.joints(all_),
        readings=sim.readings(all_),
        imu=sim.imu(all_),
        truth=sim.truth(all_),
        sole_position=all_.sole_position,
        base_position=all_.base_position,
        base_orientation=all_.base_orientation,
    )
