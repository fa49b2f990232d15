"""What the robot stamps is late or not as a whole: angles, efforts and IMU."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from shoecal_core.diagnosis.settings import DiagnosisSettings
from shoecal_core.recording.run import ImuSamples, JointSamples
from shoecal_core.recording.session import Session
from shoecal_core.robot.kinematics import Kinematics
from shoecal_core.robot.robot_file import load_robot
from shoecal_core.samples.aligned import align
from shoecal_core.samples.samples import Samples
from shoecal_core.samples.sampling import make_samples

LATE_S = 0.08


def test_late_angles_efforts_and_imu_come_back_together(standard_session: Session) -> None:
    shoe = standard_session.shoe
    robot = load_robot(standard_session.robot_yaml, shoe)
    kinematics, run = Kinematics(robot), standard_session.read(1)
    tipping = 0.2 * np.sin(run.joints.time)
    level = np.zeros_like(tipping)
    turns = np.stack((np.sin(tipping / 2), level, level, np.cos(tipping / 2)), axis=1)
    on_time = replace(
        run,
        joints=replace(run.joints, effort=np.cos(run.joints.position)),
        imu=ImuSamples(run.joints.time, "base", turns, turns[:, :3], turns[:, :3]),
    )

    def samples(late_s: float) -> Samples:
        joints: JointSamples = on_time.joints
        assert on_time.imu is not None
        late = replace(
            on_time,
            joints=replace(joints, time=joints.time + late_s),
            imu=replace(on_time.imu, time=on_time.imu.time + late_s),
        )
        read = [(late, align(late, shoe, kinematics, late_s=late_s))]
        found = make_samples(read, shoe, kinematics, DiagnosisSettings())
        assert found is not None
        return found

    wanted, found = samples(0.0), samples(LATE_S)
    assert wanted.efforts is not None
    assert found.efforts is not None
    np.testing.assert_allclose(found.angles, wanted.angles, atol=1e-6)
    np.testing.assert_allclose(found.efforts, wanted.efforts, atol=1e-6)
    np.testing.assert_allclose(found.up, wanted.up, atol=1e-6)
