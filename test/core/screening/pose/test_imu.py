"""An IMU that is mounted otherwise than its frame says, or whose orientation is frozen."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from core.screening.recordings import SETTINGS, WEIGHT, recording
from shoecal_core.arrays import FloatArray
from shoecal_core.recording.run import ImuSamples, Run
from shoecal_core.samples.aligned import Aligned
from shoecal_core.screening.faults import Fault
from shoecal_core.screening.pose.imu import FrozenImu, WrongMount, wrong_imu
from shoecal_core.screening.screen import screen

LEAN_RAD = 0.08
"""Of the base of a robot that shifts its weight."""


def leaning(
    turn: Rotation, lean: float = LEAN_RAD, world: Rotation | None = None
) -> tuple[dict[int, Run], dict[int, Aligned]]:
    """Runs of a base that leans to all sides over level soles, by an IMU turned by `turn`, in a
    world turned by `world`.
    """
    seen = world or Rotation.identity()
    whole = recording()
    runs, aligned = dict(whole.runs), dict(whole.aligned)
    for number, one in whole.aligned.items():
        angle = lean * np.array([np.sin(one.time), np.cos(0.7 * one.time), 0.0 * one.time]).T
        base = Rotation.from_rotvec(angle)
        states = replace(one.states, left_rotation=base.inv().as_matrix())
        aligned[number] = replace(one, states=states)
        nothing: FloatArray = np.zeros((len(one.time), 3))
        imu = ImuSamples(one.time, "base", (seen * base * turn).as_quat(), nothing, nothing)
        runs[number] = replace(runs[number], imu=imu)
    return runs, aligned


def found(turn: Rotation, lean: float = LEAN_RAD) -> WrongMount | None:
    wrong = wrong_imu(*leaning(turn, lean))
    assert not isinstance(wrong, FrozenImu)
    return wrong


@pytest.mark.parametrize("degrees", [0.0, 1.0])
def test_an_imu_mounted_as_it_says(degrees: float) -> None:
    assert found(Rotation.from_euler("x", degrees, degrees=True)) is None


def test_no_imu() -> None:
    whole = recording()
    assert wrong_imu(whole.runs, whole.aligned) is None


@pytest.mark.parametrize("axis", ["x", "y", "z", "-z"])
@pytest.mark.parametrize("degrees", [90.0, 180.0])
def test_a_turn_by_right_angles_is_named(axis: str, degrees: float) -> None:
    sign = -1.0 if axis.startswith("-") else 1.0
    turn = Rotation.from_euler(axis[-1], sign * degrees, degrees=True)
    wrong = found(turn)
    assert wrong is not None
    assert wrong.turn is not None
    np.testing.assert_allclose(
        Rotation.from_rotvec(wrong.turn).as_matrix(), turn.as_matrix(), atol=1e-9
    )
    assert f"a turn by {degrees:.0f} degrees about its axis" in wrong.text


@pytest.mark.parametrize(
    ("axis", "degrees", "said"),
    [
        ("x", 180.0, "that of axes forward, right, down in a world likewise (NED)"),
        ("x", 0.0, "given in a world with its z axis down (NED)"),
        ("z", 90.0, "its z axis down (NED), and a turn by"),
    ],
)
@pytest.mark.parametrize("heading", [0.0, 120.0])
def test_a_world_whose_z_axis_is_down(axis: str, degrees: float, said: str, heading: float) -> None:
    down = Rotation.from_euler("zx", [heading, 180.0], degrees=True)
    turn = Rotation.from_euler(axis, degrees, degrees=True)
    wrong = wrong_imu(*leaning(turn, world=down))
    assert isinstance(wrong, WrongMount)
    assert wrong.down
    assert said in wrong.text
    assert "have its driver give x forward, y left and z up (REP-103)" in wrong.text


def test_a_robot_that_does_not_lean_shows_no_turn_about_the_vertical() -> None:
    assert found(Rotation.from_euler("z", 90.0, degrees=True), lean=0.01) is None


def test_any_other_mount_is_no_turn_by_right_angles() -> None:
    wrong = found(Rotation.from_euler("y", 30.0, degrees=True))
    assert wrong is not None
    assert wrong.turn is None
    assert "tilted by 30 degrees against what the legs say: see how it is mounted" in wrong.text


@pytest.mark.parametrize("stuck_runs", [(2,), (1, 2, 3)])
def test_a_frozen_orientation_is_named(stuck_runs: tuple[int, ...]) -> None:
    runs, aligned = leaning(Rotation.identity())
    for number in stuck_runs:
        imu = runs[number].imu
        assert imu is not None
        still = np.tile(imu.quaternion[0], (len(imu.time), 1))
        runs[number] = replace(runs[number], imu=replace(imu, quaternion=still))
    wrong = wrong_imu(runs, aligned)
    assert isinstance(wrong, FrozenImu)
    assert wrong.runs == stuck_runs
    assert wrong.lean == pytest.approx(LEAN_RAD, rel=0.1)
    assert "its orientation is frozen" in wrong.text


def test_it_is_in_the_way_of_a_fit() -> None:
    runs, aligned = leaning(Rotation.from_euler("x", 180.0, degrees=True))
    (finding,) = screen(runs, aligned, recording().shoe, WEIGHT, SETTINGS).findings
    assert (finding.verdict, finding.fault) == ("FAIL", Fault.IMU)
