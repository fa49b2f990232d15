"""Joint angles that were held."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from core.screening.recordings import SETTINGS, WEIGHT, recording
from shoecal_core.arrays import FloatArray
from shoecal_core.recording.run import JointSamples, Run
from shoecal_core.screening.faults import Fault
from shoecal_core.screening.joints.dropouts import Dropouts, describe_dropouts, find_dropouts
from shoecal_core.screening.joints.legs import Legs
from shoecal_core.screening.screen import screen

RATE = 50.0
KNEES = ("left_knee", "right_knee")


def knees(seed: int, step_rad: float = 1e-4) -> FloatArray:
    """(T, 2) of knees that bend for 20 s, read in steps [rad]."""
    time = np.arange(1000) / RATE
    noise = step_rad * np.random.default_rng(seed).standard_normal((1000, 2))
    angles = 0.5 + 0.4 * np.sin(0.8 * time + seed)[:, None] * [1.0, -0.7] + noise
    return np.asarray(step_rad * np.rint(angles / step_rad))


def run(angles: FloatArray) -> Run:
    """At 50 Hz, of both knees (T, 2) [rad]."""
    time = np.arange(len(angles)) / RATE
    one = recording(1, count=1).runs[1]
    return replace(one, path=Path("none"), joints=JointSamples(time, KNEES, angles, None))


def found(*angles: FloatArray) -> list[Dropouts]:
    """In runs of these angles."""
    return find_dropouts({number: run(one) for number, one in enumerate(angles, 1)}, KNEES)


@pytest.mark.parametrize("step_rad", [1e-5, 1e-3, 5e-3], ids=["fine", "servo", "coarse"])
def test_sound_angles_were_read(step_rad: float) -> None:
    still = knees(3, step_rad)
    still[300:500] = still[300]  # a motion that waits goes on smoothly
    still[500:] += still[300] - still[500]
    missing = knees(4, step_rad)
    missing[200:210, 0] = np.nan
    assert found(knees(1, step_rad), knees(2, step_rad), still, missing) == []
    assert found(np.zeros((1000, 2))) == []


def test_a_held_angle_is_named_with_its_time() -> None:
    angles = knees(2)
    angles[200:500, 1] = angles[200, 1]
    (one,) = found(knees(1), angles)
    assert (one.joint, dict(one.held)) == ("right_knee", {2: [(4.0, 9.98)]})
    assert one.step == pytest.approx(abs(angles[500, 1] - angles[499, 1]))
    (finding,) = describe_dropouts([one])
    assert (finding.verdict, finding.fault) == ("FAIL", Fault.HELD)
    assert "right_knee keeps one angle" in finding.reason
    assert "(run 2 at 4.0 to 10.0 s)" in finding.reason


def test_they_are_named_before_what_they_look_like() -> None:
    whole = recording(2)
    missed = Legs(dropouts=[Dropouts("left_knee", {1: [(2.0, 5.0)]}, 0.2)])
    assert missed.wrong
    said = screen(whole.runs, whole.aligned, whole.shoe, WEIGHT, SETTINGS, legs=missed).findings
    assert [one.fault for one in said] == [Fault.HELD]
