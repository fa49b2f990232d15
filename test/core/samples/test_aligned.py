"""What of a run is refused before it is aligned."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from shoecal_core.arrays import FloatArray
from shoecal_core.recording.errors import RecordingError
from shoecal_core.recording.session import Session
from shoecal_core.robot.kinematics import Kinematics
from shoecal_core.robot.robot_file import load_robot
from shoecal_core.samples.aligned import align


def received(time: FloatArray, apart: float = 0.4) -> FloatArray:
    """Stamps of packets so far apart [s]."""
    packet = np.floor(time / apart + 1e-6)
    place = np.arange(len(time)) - np.searchsorted(packet, packet)
    return np.asarray((packet + 1.0) * apart + 2e-4 * place)


def test_stamps_of_receipt_in_packets_are_refused(standard_session: Session) -> None:
    shoe = standard_session.shoe
    kinematics = Kinematics(load_robot(standard_session.robot_yaml, shoe))
    run = standard_session.read(1)
    readings = replace(run.readings, time=received(run.readings.time))
    with pytest.raises(RecordingError, match=r"readings come in packets of 20 every 0\.40 s"):
        align(replace(run, readings=readings), shoe, kinematics)
    joints = replace(run.joints, time=received(run.joints.time))
    with pytest.raises(RecordingError, match=r"joint angles come in packets"):
        align(replace(run, joints=joints), shoe, kinematics)


def test_angles_that_come_too_seldom_are_refused_by_their_rate(standard_session: Session) -> None:
    shoe = standard_session.shoe
    kinematics = Kinematics(load_robot(standard_session.robot_yaml, shoe))
    run = standard_session.read(1)
    every = round(0.2 / float(np.median(np.diff(run.joints.time))))
    seldom = replace(
        run.joints,
        time=run.joints.time[::every],
        position=run.joints.position[::every],
        effort=None,
    )
    with pytest.raises(RecordingError, match=r"come 5 times a second; .* 10 times"):
        align(replace(run, joints=seldom), shoe, kinematics)
