"""CoM, soles and modelled CoP against Pinocchio and against sums by hand."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest

from core.robot import robots
from core.shoe import shoes
from shoecal_core.arrays import FloatArray
from shoecal_core.errors import ShapeError
from shoecal_core.robot.double_support import DoubleSupport
from shoecal_core.robot.kinematics import BodyStates, Kinematics
from shoecal_core.robot.robot import Robot
from shoecal_core.shoe.shoe import Shoe

SAMPLES = 25
EXACT = 1e-12


def configuration(angles: FloatArray, base: pin.SE3 | None = None) -> FloatArray:
    """Pinocchio's configuration: pose of the base, then the joints."""
    pose = pin.SE3.Identity() if base is None else base
    return np.concatenate((pin.SE3ToXYZQUAT(pose), angles))


def soles(model: pin.Model, data: pin.Data, robot: Robot) -> list[pin.SE3]:
    pin.updateFramePlacements(model, data)
    return [data.oMf[foot.frame].copy() for foot in robot.feet]


def assert_pinocchio_s(states: BodyStates, angles: FloatArray, robot: Robot, step: int = 1) -> None:
    """Every `step`-th sample, computed anew."""
    model, data = robot.model, robot.model.createData()
    for index in range(0, len(angles), step):
        com = pin.centerOfMass(model, data, configuration(angles[index]))
        left, right = soles(model, data, robot)
        relative = left.inverse() * right
        np.testing.assert_allclose(states.com[index, 0], left.actInv(com), atol=EXACT)
        np.testing.assert_allclose(states.com[index, 1], right.actInv(com), atol=EXACT)
        np.testing.assert_allclose(states.rotation[index], relative.rotation, atol=EXACT)
        np.testing.assert_allclose(states.translation[index], relative.translation, atol=EXACT)
        np.testing.assert_allclose(states.left_rotation[index], left.rotation, atol=EXACT)
        np.testing.assert_allclose(states.left_translation[index], left.translation, atol=EXACT)
        np.testing.assert_allclose(states.com_in_base[index], com, atol=EXACT)


def test_com_and_soles_are_pinocchio_s(kinematics: Kinematics, robot: Robot) -> None:
    angles = robots.random_angles(robot, SAMPLES)
    assert_pinocchio_s(kinematics.states(angles), angles, robot)


def test_where_the_base_is_does_not_matter(kinematics: Kinematics, robot: Robot) -> None:
    model, data = robot.model, robot.model.createData()
    row = robots.random_angles(robot, 1, seed=4)[0]
    pin.seed(7)
    com = pin.centerOfMass(model, data, configuration(row, pin.SE3.Random()))
    left = soles(model, data, robot)[0]
    np.testing.assert_allclose(kinematics.states(row[None]).com[0, 0], left.actInv(com), atol=EXACT)


@pytest.mark.parametrize("name", robots.NAMES)
@pytest.mark.parametrize("shod", [True, False])
def test_com_is_the_weighed_body_and_its_plates_by_hand(name: str, *, shod: bool) -> None:
    """From the URDF alone: its CoM with the weighed mass, then both plates of each shoe."""
    robot = robots.load(name, shod=shod)
    shoe: Shoe | None = shoes.shoe(robots.SHOES[name]) if shod else None
    model = pin.buildModelFromUrdf(str(robot.urdf), pin.JointModelFreeFlyer())
    data = model.createData()
    row = robots.random_angles(robot, 1, seed=9)[0]
    body = pin.centerOfMass(model, data, configuration(row))
    pin.updateFramePlacements(model, data)
    worn = 0.0 if shoe is None else shoe.mass
    moment = (robot.mass - worn) * body
    placed = []
    drop = np.array([0.0, 0.0, 0.0 if shoe is None else -shoe.height])
    for foot, (link, sole) in zip(robot.feet, _bare_soles(name), strict=True):
        ankle = data.oMf[model.getFrameId(link, pin.FrameType.BODY)]
        placed.append(ankle * sole * pin.SE3(np.eye(3), drop))
        if shoe is not None:
            plates = shoe.plates[len(placed) - 1]
            for mass, com in (
                (plates.mass_above, plates.com_above),
                (plates.mass_below, plates.com_below),
            ):
                moment = moment + mass * placed[-1].act(com)
        assert foot.outline.shape[1] == 2
    expected = moment / robot.mass
    states = robots.kinematics(name, shod=shod).states(row[None])
    np.testing.assert_allclose(states.com_in_base[0], expected, atol=EXACT)
    np.testing.assert_allclose(states.com[0, 1], placed[1].actInv(expected), atol=EXACT)
    np.testing.assert_allclose(states.left_translation[0], placed[0].translation, atol=EXACT)


def _bare_soles(name: str) -> list[tuple[str, pin.SE3]]:
    """Link of each foot and the sole's frame in it."""
    upright, downwards = np.eye(3), np.array([[0.0, 0.0, -1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]])
    links, rotation, place = {
        "nao": (("l_ankle_link", "r_ankle_link"), upright, [0.0, 0.0, -0.04519]),
        "wren": (("left_sole", "right_sole"), downwards, [0.036, 0.0, 0.0]),
        "odd_biped": (
            ("left_ankle_roll_body", "right_ankle_roll_body"), upright, [0.0, 0.0, -0.05]
        ),
    }[name]  # fmt: skip
    return [(link, pin.SE3(rotation, np.array(place))) for link in links]


def test_modelled_cop_is_the_ground_projection_of_the_com(
    kinematics: Kinematics, robot: Robot
) -> None:
    states = kinematics.states(robots.random_angles(robot, 5))
    np.testing.assert_array_equal(states.cop, states.com[:, :, :2])
    # With flat soles both feet mean one place on the floor.
    standing = kinematics.states(robot.posture[None])
    support = standing.support()
    np.testing.assert_allclose(
        support.right_to_left(standing.cop[0, 1]), standing.cop[0, 0], atol=1e-9
    )


def test_standing_straight_the_robot_is_symmetric() -> None:
    states = robots.kinematics("nao", shod=False).states(np.zeros((1, 26)))
    assert states.support().dtheta == pytest.approx(0.0, abs=1e-9)
    assert states.support().dx == pytest.approx(0.0, abs=1e-9)
    assert states.support().dy == pytest.approx(-0.1, abs=1e-9)
    assert 0.15 < states.com[0, 0, 2] < 0.35


def test_batches_equal_single_samples(kinematics: Kinematics, robot: Robot) -> None:
    angles = robots.random_angles(robot, 7)
    whole = kinematics.states(angles)
    for index in range(7):
        one = kinematics.states(angles[index : index + 1])
        for name in ("com", "rotation", "translation", "left_rotation", "left_translation"):
            np.testing.assert_array_equal(getattr(one, name)[0], getattr(whole, name)[index])


def test_no_samples_and_wrong_shapes(kinematics: Kinematics, robot: Robot) -> None:
    count = len(robot.joint_names)
    empty = kinematics.states(np.zeros((0, count)))
    assert empty.com.shape == (0, 2, 3)
    assert empty.rotation.shape == empty.left_rotation.shape == (0, 3, 3)
    for shape in ((count,), (3, count + 1), (1, 3, count)):
        with pytest.raises(ShapeError, match=rf"expected shape \(T, {count}\)"):
            kinematics.states(np.zeros(shape))


def test_a_nan_angle_stays_in_its_sample(kinematics: Kinematics, robot: Robot) -> None:
    angles = np.tile(robot.posture, (3, 1))
    angles[1, robot.legs[0]] = np.nan
    com = kinematics.states(angles).com
    assert np.isnan(com[1]).any()
    assert np.isfinite(com[[0, 2]]).all()


def test_the_support_is_the_median_over_a_run() -> None:
    true = DoubleSupport(0.03, -0.11, 0.35)
    rng = np.random.default_rng(0)
    count = 401
    turn = np.tile(np.eye(3), (count, 1, 1))
    turn[:, :2, :2] = true.rotation
    place = np.tile([true.dx, true.dy, 0.0], (count, 1)) + 1e-4 * rng.normal(size=(count, 3))
    place[::20] += 0.5  # a glitch now and then
    nothing = np.zeros((count, 2, 3))
    found = BodyStates(nothing, turn, place, turn, place).support()
    assert found.dx == pytest.approx(true.dx, abs=5e-5)
    assert found.dy == pytest.approx(true.dy, abs=5e-5)
    assert found.dtheta == pytest.approx(true.dtheta, abs=1e-12)
