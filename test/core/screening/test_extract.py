"""From a recorded run in double support to its stance."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from core.robot import robots
from core.shoe import shoes
from shoecal_core.arrays import FloatArray
from shoecal_core.errors import FileError
from shoecal_core.recording.info import RunInfo
from shoecal_core.recording.joint_series import in_degrees
from shoecal_core.recording.run import JointSamples, PoseSamples, Readings, Run
from shoecal_core.robot.kinematics import Kinematics
from shoecal_core.robot.robot import JointsMissingError
from shoecal_core.samples.aligned import MIN_SAMPLES, align
from shoecal_core.samples.stance import Stance
from shoecal_core.screening.extract import MAX_FOOT_DRIFT_M, stances_of

SHOE = shoes.shoe("odd_shoe")
KINEMATICS = robots.kinematics("odd_biped")
ROBOT = KINEMATICS.robot
SECONDS = 4.0


def angles_at(time: FloatArray) -> FloatArray:
    """(T, m) the trunk bows and an arm swings; the legs stand still."""
    angles = np.tile(ROBOT.posture, (len(time), 1))
    angles[:, ROBOT.joint("waist_pitch")] += 0.2 * np.sin(time)
    angles[:, ROBOT.joint("left_shoulder")] += 0.5 * np.cos(1.3 * time)
    return angles


@pytest.fixture
def run() -> Run:
    """Joints 100 times a second, readings 80 times, not at the same instants."""
    told = np.arange(0.0, SECONDS, 0.01)
    read = np.arange(0.003, SECONDS - 0.02, 1.0 / 80.0)
    shape = (len(read), len(SHOE.names))
    digest = "0" * 64
    return Run(
        path=Path("run_003.mcap"),
        info=RunInfo(
            3, "landmarks", KINEMATICS.states(ROBOT.posture[None]).support(),
            ROBOT.name, SHOE.name, digest, digest, digest,
        ),
        start_ns=0,
        joints=JointSamples(told, ROBOT.joint_names, angles_at(told), None),
        readings=Readings(
            read, SHOE.names, np.random.default_rng(0).normal(size=shape),
            np.zeros(shape, dtype=np.uint8), np.zeros(shape, dtype=np.int64), np.full(shape, 20.0),
        ),
    )  # fmt: skip


def found_in(run: Run) -> list[Stance]:
    return stances_of(run, align(run, SHOE, KINEMATICS), SHOE, KINEMATICS)


def with_readings(run: Run, **changes: NDArray[np.generic]) -> Run:
    return replace(run, readings=replace(run.readings, **changes))  # type: ignore[arg-type]


def with_joints(run: Run, **changes: object) -> Run:
    return replace(run, joints=replace(run.joints, **changes))  # type: ignore[arg-type]


def test_the_stance_is_the_model_at_the_times_of_the_readings(run: Run) -> None:
    (stance,) = found_in(run)
    np.testing.assert_array_equal(stance.time, run.readings.time)
    np.testing.assert_array_equal(stance.readings, run.readings.value)
    expected = KINEMATICS.states(angles_at(stance.time))
    np.testing.assert_allclose(stance.cop, expected.cop[:, 0], atol=1e-6)
    np.testing.assert_array_equal(stance.force, np.full(len(stance.time), ROBOT.weight))
    assert stance.run == 3
    assert stance.loaded == (True, True)
    assert run.info.support is not None
    for name in ("dx", "dy", "dtheta"):
        found = getattr(stance.support, name)
        assert found == pytest.approx(getattr(run.info.support, name), abs=1e-9)


def test_readings_that_are_missing_or_bad_are_left_out(run: Run) -> None:
    value, status = run.readings.value.copy(), run.readings.status.copy()
    value[10:20, 4] = np.nan
    status[30:35, 0] = 2
    (stance,) = found_in(with_readings(run, value=value, status=status))
    left = np.setdiff1d(np.arange(len(run.readings.time)), [*range(10, 20), *range(30, 35)])
    np.testing.assert_array_equal(stance.time, run.readings.time[left])


def test_readings_without_joint_angles_near_are_left_out(run: Run) -> None:
    told = run.joints.time
    kept = (told < 1.0) | (told > 1.5)
    cut = with_joints(run, time=told[kept], position=run.joints.position[kept])
    (stance,) = found_in(cut)
    assert not ((stance.time > 1.0) & (stance.time < 1.5)).any()
    assert len(stance.time) > 0.8 * len(run.readings.time)


def test_joints_in_another_order_beside_strangers(run: Run) -> None:
    names = ("Wheel", *reversed(ROBOT.joint_names))
    position = np.column_stack((np.full(len(run.joints.time), 7.0), run.joints.position[:, ::-1]))
    (stance,) = found_in(with_joints(run, names=names, position=position))
    (expected,) = found_in(run)
    np.testing.assert_array_equal(stance.cop, expected.cop)


def test_optional_joints_that_are_never_told_stand_in_their_posture(run: Run) -> None:
    robot = replace(ROBOT, optional=frozenset({"left_shoulder"}))
    kinematics = Kinematics(robot)
    position = run.joints.position.copy()
    position[:, ROBOT.joint("left_shoulder")] = np.nan
    silent = with_joints(run, position=position)
    aligned = align(silent, SHOE, kinematics)
    still = angles_at(aligned.time)
    still[:, ROBOT.joint("left_shoulder")] = ROBOT.posture[ROBOT.joint("left_shoulder")]
    np.testing.assert_allclose(aligned.joint_angles, still, atol=1e-4)
    # A joint that is needed is not made up.
    expected = "only 0 samples .*; there is no angle of left_shoulder: record it, or list it under"
    with pytest.raises(FileError, match=expected):
        align(silent, SHOE, KINEMATICS)


def test_angles_in_degrees_are_refused(run: Run) -> None:
    degrees = with_joints(run, position=np.degrees(run.joints.position))
    with pytest.raises(FileError, match=r"joint '.*' is at .* rad, .*, but within them in degrees"):
        align(degrees, SHOE, KINEMATICS)


def test_a_turned_sign_is_not_taken_for_degrees() -> None:
    """A knee of -0.1 to 2.2 rad that is recorded from -1.6 to -0.8 rad."""
    turned = -np.linspace(0.8, 1.6, 20)
    assert not in_degrees(turned, -0.1, 2.2)
    assert in_degrees(np.degrees(-turned), -0.1, 2.2)
    # Without an end it may have turned round, but in degrees it seems to turn many times.
    assert not in_degrees(turned - 7.0, -3.2, 3.2)
    assert in_degrees(np.degrees(turned), -3.2, 3.2)


def test_two_senders_that_take_turns_are_refused(run: Run) -> None:
    """In the same order of names; an encoder that fails now and then is left to the screening."""
    position = run.joints.position.copy()
    position[::40, ROBOT.joint("left_shoulder")] += 2.0
    found_in(with_joints(run, position=position))
    position = run.joints.position.copy()
    position[1::3] = 0.0
    with pytest.raises(FileError, match=r"/joint_states: '.*' jumps to and fro by .* within 10 ms"):
        found_in(with_joints(run, position=position))


def test_joints_of_another_robot(run: Run) -> None:
    names = tuple(f"other_{name}" for name in ROBOT.joint_names)
    with pytest.raises(JointsMissingError, match="check the robot file's joint names"):
        found_in(with_joints(run, names=names))


def test_channels_that_were_not_recorded(run: Run) -> None:
    value = run.readings.value.copy()
    value[:, 1] = np.nan
    problem = f"there is no reading of {run.readings.names[1]}: record the topic that has them"
    with pytest.raises(FileError, match=problem):
        found_in(replace(run, readings=replace(run.readings, value=value)))


def test_too_little_that_fits_together(run: Run) -> None:
    value = run.readings.value.copy()
    value[MIN_SAMPLES - 1 :] = np.nan
    with pytest.raises(FileError, match=f"only {MIN_SAMPLES - 1} samples") as caught:
        found_in(with_readings(run, value=value))
    assert caught.value.path == run.path
    apart = with_joints(run, time=run.joints.time + 100.0)
    with pytest.raises(FileError, match="stamps of one clock"):
        found_in(apart)


def test_a_foot_that_slips_is_told(run: Run) -> None:
    position = run.joints.position.copy()
    position[-20:, ROBOT.joint("left_hip_roll")] += 0.2
    with pytest.raises(FileError, match=r"the feet moved [0-9.]+ mm") as caught:
        found_in(with_joints(run, position=position))
    assert caught.value.path == run.path
    # Play in the joints is no slip.
    position = run.joints.position.copy()
    position[-20:, ROBOT.joint("left_hip_roll")] += 0.1 * MAX_FOOT_DRIFT_M / 0.3
    assert found_in(with_joints(run, position=position))


def test_a_run_that_does_not_say_where_its_feet_are(run: Run) -> None:
    walked = replace(run, info=replace(run.info, support=None))
    once = PoseSamples(np.zeros(1), np.zeros((1, 3)), np.array([[0.0, 0.0, 0.0, 1.0]]))
    for pose in (None, once):
        with pytest.raises(FileError, match="names no double support and has no /base_pose"):
            found_in(replace(walked, base_pose=pose))


def test_with_the_pose_of_the_base_a_standing_robot_is_found_standing(run: Run) -> None:
    """Both feet swap some load, nothing else moves: the quasi-static model."""
    told = np.arange(0.0, SECONDS, 0.01)
    still = np.tile(ROBOT.posture, (len(told), 1))
    states = KINEMATICS.states(ROBOT.posture[None])
    base = PoseSamples(
        np.array([0.0, SECONDS]),
        np.tile([1.0, 2.0, -states.left_translation[0, 2]], (2, 1)),
        np.tile([0.0, 0.0, np.sin(0.3), np.cos(0.3)], (2, 1)),
    )
    phase = np.sin(2.0 * run.readings.time)[:, None]
    load = np.where(SHOE.foot == 0, 1.0 + 0.8 * phase, 1.0 - 0.8 * phase) * SHOE.polarity
    walked = replace(
        with_readings(with_joints(run, time=told, position=still), value=load),
        info=replace(run.info, support=None),
        base_pose=base,
    )
    both = [stance for stance in found_in(walked) if all(stance.loaded)]
    assert both
    for stance in both:
        np.testing.assert_allclose(stance.force, ROBOT.weight, rtol=1e-9)
        np.testing.assert_allclose(
            stance.cop, np.tile(states.cop[0, 0], (len(stance.time), 1)), atol=1e-9
        )
        assert stance.support.dy == pytest.approx(states.support().dy, abs=1e-9)
        assert stance.support.dtheta == pytest.approx(states.support().dtheta, abs=1e-9)
