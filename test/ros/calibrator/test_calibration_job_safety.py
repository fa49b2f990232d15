from __future__ import annotations

import contextlib
from collections.abc import Callable, Coroutine
from types import SimpleNamespace
from typing import cast

import pytest
from rclpy.action import ActionClient
from shoecal_msgs.action import Calibrate

from shoecal_ros.calibrator import job as jobs
from shoecal_ros.calibrator.calibrator_base import CalibratorBase
from shoecal_ros.calibrator.job import Job
from shoecal_ros.calibrator.job_settings import JobSettings
from shoecal_ros.common.codes import Code, Problem
from shoecal_ros.common.refusal import RefusedError
from shoecal_ros.planner.settings import MovingSettings


def test_the_robot_stays_armed_while_a_person_places_it() -> None:
    job = JobSettings()
    assert MovingSettings().arm_timeout_s > job.reach_timeout_s + job.still_timeout_s


def run(waiting: Coroutine[None, None, None]) -> None:
    """Resume it as often as an executor does."""
    with contextlib.suppress(StopIteration):
        while True:
            waiting.send(None)


def make_site(*, armed: bool) -> SimpleNamespace:
    return SimpleNamespace(
        arming=SimpleNamespace(armed=armed, disarmings=0, lapsed=False),
        recorder=SimpleNamespace(problem=""),
        input_problem=lambda: None,
    )


def test_arming_counts_that_is_heard_after_the_request() -> None:
    site = make_site(armed=False)
    beginning = Job(cast("CalibratorBase", site), Calibrate.Feedback(), lambda: False).begin()
    beginning.send(None)
    site.arming.armed = True
    run(beginning)


@pytest.mark.parametrize(("ended_by", "within_s", "code"), [
    ("nothing", 0.0, Calibrate.Result.NOT_ARMED),
    ("disarming", 60.0, Calibrate.Result.NOT_ARMED),
    ("cancelling", 60.0, Calibrate.Result.CANCELED),
])  # fmt: skip
def test_a_job_that_nobody_arms_or_wants_does_not_begin(
    monkeypatch: pytest.MonkeyPatch, ended_by: str, within_s: float, code: int
) -> None:
    monkeypatch.setattr(jobs, "ARMED_WITHIN_S", within_s)
    site = make_site(armed=False)
    beginning = Job(
        cast("CalibratorBase", site), Calibrate.Feedback(), lambda: ended_by == "cancelling"
    ).begin()
    site.arming.disarmings += ended_by == "disarming"
    with pytest.raises(RefusedError) as refusal:
        run(beginning)
    assert refusal.value.code == code


def test_voltages_that_were_gone_for_a_moment_are_the_reason_though_they_are_back(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    site = make_site(armed=True)

    async def do_action(*_: object, stop: Callable[[], bool], **__: object) -> SimpleNamespace:
        site.input_problem = lambda: Problem(Code.VOLTAGES_STALE, "no voltages for 1 s")
        assert stop()
        site.input_problem = lambda: None
        return SimpleNamespace(success=False, message="cancelled")

    monkeypatch.setattr(jobs, "do_action", do_action)
    job = Job(cast("CalibratorBase", site), Calibrate.Feedback(), lambda: False)
    moving = job.done(
        cast("ActionClient", None), "shoe/plan", None, lambda _: None, 60.0,
        Calibrate.Result.MOTION_FAILED,
    )  # fmt: skip
    with pytest.raises(RefusedError, match="no voltages for 1 s") as refusal:
        run(moving)
    assert refusal.value.code == Calibrate.Result.STALE_INPUT
