"""A corrected URDF is the same robot with its zeros, masses and centres of mass moved."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

from shoecal_core.robot.correction import ModelCorrection, corrected_urdf
from shoecal_core.robot.robot import Robot, first_link
from shoecal_core.robot.robot_file import load_robot

CONFIG = Path(__file__).parents[3] / "config" / "robots"


@pytest.fixture(params=["nao", "wren"])
def robot(request: pytest.FixtureRequest) -> Robot:
    return load_robot(CONFIG / f"{request.param}.yaml")


def corrected(robot: Robot, correction: ModelCorrection, folder: Path) -> Robot:
    urdf = folder / "robot.urdf"
    urdf.write_text(corrected_urdf(robot.urdf.read_text(), robot, correction))
    return load_robot(robot.path, urdf=urdf)


def placed(robot: Robot, angles: np.ndarray) -> list[pin.SE3]:
    """Poses of all joints' links in the root's frame."""
    data = robot.model.createData()
    root = np.array([0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0])
    pin.forwardKinematics(robot.model, data, np.concatenate((root, angles)))
    return list(data.oMi)


def test_a_zero_that_moved_is_the_same_pose_at_another_reading(
    robot: Robot, tmp_path: Path
) -> None:
    rng = np.random.default_rng(3)
    shift = rng.normal(0.0, 0.05, len(robot.joint_names))
    zeros = dict(zip(robot.joint_names, shift, strict=True))
    other = corrected(robot, ModelCorrection(zeros, {}, {}), tmp_path)
    read = rng.uniform(-0.5, 0.5, len(shift))
    for one, two in zip(placed(other, read), placed(robot, read - shift), strict=True):
        np.testing.assert_allclose(one.homogeneous, two.homogeneous, atol=1e-9)


def test_masses_and_centres_of_mass_are_of_all_that_is_fixed_together(
    robot: Robot, tmp_path: Path
) -> None:
    rng = np.random.default_rng(4)
    model = robot.model
    heavy = [joint for joint in range(1, model.njoints) if model.inertias[joint].mass > 0.0]
    names = {joint: first_link(model, joint).name for joint in heavy}
    factors = {name: float(rng.uniform(0.9, 1.1)) for name in names.values()}
    shifts = {name: rng.normal(0.0, 3e-3, 3) for name in names.values()}
    other = corrected(robot, ModelCorrection({}, factors, shifts), tmp_path)
    # A robot file has its own weight, to which all links are scaled alike.
    total = sum(factors[names[joint]] * model.inertias[joint].mass for joint in heavy)
    for joint, name in names.items():
        before, after = model.inertias[joint], other.model.inertias[joint]
        expected = before.mass * factors[name] * robot.mass / total
        assert after.mass == pytest.approx(expected, rel=1e-9)
        turned = first_link(model, joint).placement.rotation @ shifts[name]
        np.testing.assert_allclose(after.lever, before.lever + turned, atol=1e-9)


def test_what_was_written_by_hand_stays(robot: Robot) -> None:
    text = "<!-- by hand -->".join(robot.urdf.read_text().rsplit("</robot>", 1)) + "</robot>"
    assert "<!-- by hand -->" in corrected_urdf(text, robot, ModelCorrection({}, {}, {}))
