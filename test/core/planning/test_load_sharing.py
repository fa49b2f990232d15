from __future__ import annotations

import dataclasses

import casadi as ca
import numpy as np
import pytest

from core.planning.bodies import NAMES, load_body
from core.planning.motions import motion_of
from shoecal_core.arrays import FloatArray
from shoecal_core.errors import ShapeError
from shoecal_core.planning.checking.body_track import track
from shoecal_core.planning.legs import LegExpressions
from shoecal_core.planning.load_sharing import SharingSpread
from shoecal_core.planning.support_phase import SupportPhase
from shoecal_core.robot.robot import JointDeflection, Robot


class Written:
    """The expressions of one robot as a function of leg angles, in the pose of a motion."""

    def __init__(self, name: str) -> None:
        self.robot, self.motion = load_body(name).robot, motion_of(name)
        terms = LegExpressions(self.robot)
        self._function = ca.Function(
            "sharing",
            [terms.angles, terms.foot_pose, terms.others, terms.share],
            [terms.balance, terms.torques, terms.relative_jacobian],
        )

    def __call__(
        self, angles: FloatArray, phase: SupportPhase = SupportPhase.BOTH
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Balance (13,), torques (k,), relative Jacobian (6, k)."""
        pose, others = self.motion.foot_pose.parameters, self.motion.positions[0]
        found = self._function(angles, pose, others, phase.share)
        balance, torques, jacobian = (np.array(one) for one in found)
        return balance.ravel(), torques.ravel(), jacobian


@pytest.fixture(scope="module", params=NAMES)
def written(request: pytest.FixtureRequest) -> Written:
    return Written(request.param)


def states(written: Written) -> FloatArray:
    found: FloatArray = written.motion.path.states[::9]
    return found


@pytest.mark.parametrize("phase", SupportPhase)
def test_the_check_finds_the_same_by_another_way(written: Written, phase: SupportPhase) -> None:
    robot, legs = written.robot, states(written)
    body = track(robot, robot.from_legs(legs, written.motion.positions[0]), phase.share)
    for index, angles in enumerate(legs):
        balance, torques, _ = written(angles, phase)
        shares = body.loads[index] / robot.weight
        np.testing.assert_allclose(balance[:2], shares, atol=1e-4)
        assert balance[-1] == pytest.approx(body.up[index, 2])
        for side, foot in enumerate(robot.feet):
            if phase.feet[side]:
                cop, edges = body.foot_cop[index, side], balance[4 + 4 * side : 8 + 4 * side]
                ways = [np.min(offsets - normals @ cop) for normals, offsets in foot.sides]
                lever = shares[side] * np.array(ways)
                np.testing.assert_allclose(edges, lever, atol=1e-4)
        np.testing.assert_allclose(torques, body.torques[index], atol=1e-3)


def test_the_check_finds_the_same_spread_by_another_way(written: Written) -> None:
    robot, angles = written.robot, states(written)[2]
    _, _, jacobian = written(angles)
    expected = SharingSpread.of(robot, jacobian[None])
    body = track(robot, robot.from_legs(angles[None], written.motion.positions[0]))
    np.testing.assert_allclose(body.spread.load, expected.load, rtol=1e-3)
    np.testing.assert_allclose(body.spread.torque, expected.torque, rtol=1e-3)
    np.testing.assert_allclose(body.spread.sideways, expected.sideways, rtol=1e-3)
    alone = track(robot, robot.from_legs(angles[None]), SupportPhase.LEFT.share)
    assert alone.spread.load[0] == 0.0


def test_loads_add_up_to_the_weight(written: Written) -> None:
    for angles in states(written):
        for phase in SupportPhase:
            balance, _, _ = written(angles, phase)
            assert balance[:2].sum() == pytest.approx(1.0)
        assert written(angles, SupportPhase.LEFT)[0][1] == pytest.approx(0.0, abs=1e-9)
        assert written(angles, SupportPhase.RIGHT)[0][0] == pytest.approx(0.0, abs=1e-9)


def energy(robot: Robot, torques: FloatArray) -> float:
    return float(np.sum(torques**2 / robot.effort_limit[robot.legs]))


def test_no_internal_wrench_takes_less_energy(written: Written) -> None:
    generator = np.random.default_rng(1)
    for angles in states(written)[:3]:
        _, torques, jacobian = written(angles)
        least = energy(written.robot, torques)
        for wrench in generator.normal(size=(20, 6)):
            assert energy(written.robot, torques + jacobian.T @ wrench) > least


def test_grip_is_friction_times_load_less_the_sideways_force(written: Written) -> None:
    robot, angles = written.robot, states(written)[2]
    balance, _, _ = written(angles)
    body = track(robot, robot.from_legs(angles[None], written.motion.positions[0]))
    expected = (0.9 * robot.friction * body.loads[0] - body.sideways[0]) / robot.weight
    # Rounding off the sideways force takes some grip, never gives any.
    assert np.all(balance[2:4] <= expected + 1e-6)
    np.testing.assert_allclose(balance[2:4], expected, atol=0.021)


def test_the_spread_is_that_of_joints_off_their_angles(written: Written) -> None:
    """Springs whose ends are moved: the internal wrench changes by the legs' stiffness."""
    robot = written.robot
    _, _, jacobian = written(states(written)[1])
    spread = SharingSpread.of(robot, jacobian[None])
    compliance = np.diag(robot.deflection.sag / robot.effort_limit[robot.legs])
    stiffness = np.linalg.inv(jacobian @ compliance @ jacobian.T)
    changes = stiffness @ jacobian * robot.deflection.play
    assert spread.load[0] == pytest.approx(np.sqrt(np.sum(changes[2] ** 2)))
    turns = np.linspace(0.0, np.pi, 50)
    along = np.column_stack([np.cos(turns), np.sin(turns)]) @ changes[:2]
    assert spread.sideways[0] == pytest.approx(np.linalg.norm(along, axis=1).max(), rel=1e-2)
    # No single joint that is off can do more than all of them together.
    assert np.all(np.abs(changes[2]) <= spread.load[0])
    assert np.all(np.abs(jacobian.T @ changes) <= spread.torque[0][:, None] + 1e-12)
    play, sag = robot.deflection.play, robot.deflection.sag
    for deflection, factor in (
        (JointDeflection(sag, 2.0 * play), 2.0),
        (JointDeflection(2.0 * sag, play), 0.5),
    ):
        other = dataclasses.replace(robot, deflection=deflection)
        found = SharingSpread.of(other, jacobian[None])
        np.testing.assert_allclose(found.load, factor * spread.load)
        np.testing.assert_allclose(found.torque, factor * spread.torque)


def test_a_jacobian_of_another_robot_is_refused() -> None:
    with pytest.raises(ShapeError, match=r"\(n, 6, 11\)"):
        SharingSpread.of(load_body("nao").robot, np.zeros((1, 6, 10)))
