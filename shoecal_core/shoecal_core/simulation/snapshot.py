"""One instant of a simulated robot, as MuJoCo knows it, and many of them together."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from shoecal_core.arrays import FloatArray


@dataclass(frozen=True)
class Snapshot:
    """Everything that can be read, at one instant or many (...).

    Attributes:
        time: (...) simulated time [s].
        session_time: (...) simulated time since the session began [s].
        motor_angle: (..., a) of the motors, behind their gears [rad].
        motor_torque: (..., a) [N m].
        motor_heat: (..., a) over the ambient temperature [K].
        felt: (..., n) by the channels, as it reaches their converter [N or N m].
        contact: (..., 2, 9) net wrench on left, right: force, torque, place [N, N m, m].
        sole_position: (..., 2, 3) of the true left, right sole frames over the floor [m].
        sole_rotation: (..., 2, 3, 3) of the same.
        base_position: (..., 3) of the root link over the floor [m].
        base_orientation: (..., 4) of the root link: x, y, z, w.
        base_rate: (..., 3) of its turn, in its own frame [rad/s].
        base_force: (..., 3) specific force at its origin, in its own frame [m/s^2].
    """

    time: FloatArray
    session_time: FloatArray
    motor_angle: FloatArray
    motor_torque: FloatArray
    motor_heat: FloatArray
    felt: FloatArray
    contact: FloatArray
    sole_position: FloatArray
    sole_rotation: FloatArray
    base_position: FloatArray
    base_orientation: FloatArray
    base_rate: FloatArray
    base_force: FloatArray


def stack(snapshots: Sequence[Snapshot]) -> Snapshot:
    """Many instants as one, their number leading every shape."""
    names = [field.name for field in dataclasses.fields(Snapshot)]
    return Snapshot(*(np.array([getattr(one, name) for one in snapshots]) for name in names))
