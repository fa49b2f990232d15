from __future__ import annotations

from shoecal_ros.calibrator.job_settings import JobSettings
from shoecal_ros.planner.settings import MovingSettings


def test_the_robot_stays_armed_while_a_person_places_it() -> None:
    job = JobSettings()
    assert MovingSettings().arm_timeout_s > job.reach_timeout_s + job.still_timeout_s
