"""Soles that are not level: one cause is named for all runs that it explains."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from core.robot.test_joint_zeros import apart, sway, with_error
from core.screening.recordings import recording
from shoecal_core.arrays import FloatArray
from shoecal_core.robot.joint_laws import Law
from shoecal_core.robot.kinematics import Kinematics
from shoecal_core.robot.robot_file import load_robot
from shoecal_core.screening.faults import Fault
from shoecal_core.screening.pose.soles import Soles, describe_soles, open_soles
from shoecal_core.workspace import config_dir

NAO = Kinematics(load_robot(config_dir() / "robots/nao.yaml"))
ROLLS = [NAO.robot.joint(f"{side}AnkleRoll") for side in "LR"]


def found(angles: Mapping[int, FloatArray]) -> dict[int, Soles]:
    """What is found in runs of a robot on both feet with these angles, by number."""
    whole = recording()
    aligned = {}
    for number, own in angles.items():
        at = np.linspace(0, len(own) - 1, len(whole.aligned[number].time)).astype(np.int64)
        aligned[number] = replace(whole.aligned[number], joint_angles=own[at])
    return open_soles(whole.runs, aligned, whole.shoe, NAO)


def test_nothing_is_said_of_level_soles() -> None:
    angles = sway(NAO.robot)
    assert not found({1: angles, 2: apart(NAO.robot, angles, "")})


def test_runs_in_which_two_causes_look_alike_are_judged_with_the_others() -> None:
    """Feet that stand apart, of a robot that does not lean: exchanged rolls and turned signs of
    both give the same angles.
    """
    swaying = sway(NAO.robot)
    still = swaying.copy()
    for side in "LR":
        for joint in ("HipRoll", "AnkleRoll"):
            still[:, NAO.robot.joint(f"{side}{joint}")] = 0.0
    swaying, still = (apart(NAO.robot, one, "") for one in (swaying, still))
    for angles in (swaying, still):
        angles[:, ROLLS] *= -1.0
    soles = found({1: swaying, 2: still})
    assert [one.loop.law for one in soles.values()] == [Law.SIGNS, Law.SIGNS]
    (finding,) = describe_soles(soles)
    assert (finding.verdict, finding.fault) == ("FAIL", Fault.JOINT_ZERO)
    assert finding.reason.startswith("runs 1 and 2: with ")
    assert "one joint has its sign turned in both legs" in finding.reason


def test_runs_with_causes_of_their_own_keep_them() -> None:
    angles = sway(NAO.robot)
    one = with_error(NAO.robot, angles, "LHipRoll", 0.3)
    other = with_error(NAO.robot, angles, "LKneePitch", 0.4)
    soles = found({1: one, 2: other, 3: angles})
    assert list(soles) == [1, 2]
    assert "LHipRoll" in dict(soles[1].loop.fits)
    assert "LKneePitch" in dict(soles[2].loop.fits)
    assert len(describe_soles(soles)) == 2
