"""Samples of a walk: what the whole body's dynamics say of the CoP, and which feet stand."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from core.robot import robots
from shoecal_core.arrays import FloatArray
from shoecal_core.recording.run import PoseSamples
from shoecal_core.robot.gravity import GRAVITY
from shoecal_core.samples.aligned import Aligned
from shoecal_core.samples.walking import in_world
from shoecal_core.samples.walking_samples import pieces, spin

TIME = np.arange(0.0, 2.0, 0.01)


def swinging(name: str = "nao") -> tuple[Aligned, PoseSamples]:
    """A body that waves its arms and legs, and sways and turns as it does."""
    kinematics = robots.kinematics(name)
    robot = kinematics.robot
    rng = np.random.default_rng(5)
    phase = rng.uniform(0.0, 6.0, len(robot.joint_names))
    angles = robot.posture + 0.3 * np.sin(3.0 * TIME[:, None] + phase)
    position = np.stack((0.02 * np.sin(2.0 * TIME), 0.01 * np.cos(3.0 * TIME), 0.3 + 0.0 * TIME), 1)
    quaternion = np.array(
        [
            pin.Quaternion(pin.rpy.rpyToMatrix(0.2 * np.sin(3.0 * t), 0.05, 0.2 * t)).coeffs()
            for t in TIME
        ]
    )
    aligned = Aligned(TIME, np.zeros((len(TIME), 8)), angles, kinematics.states(angles))
    return aligned, PoseSamples(TIME, position, quaternion)


def zero_moment_point(aligned: Aligned, base: PoseSamples, index: int) -> FloatArray:
    """(2,) where the floor's force must act by the whole body's equations of motion."""
    model = robots.kinematics("nao").robot.model
    data = model.createData()

    def pose(at: int) -> FloatArray:
        return np.concatenate((base.position[at], base.quaternion[at], aligned.joint_angles[at]))

    step = TIME[1] - TIME[0]
    before, after = (
        pin.difference(model, pose(at), pose(at + 1)) / step for at in (index - 1, index)
    )
    middle = pose(index)
    torque = pin.rnea(model, data, middle, 0.5 * (before + after), (after - before) / step)
    placed = pin.SE3(pin.Quaternion(base.quaternion[index]).matrix(), base.position[index])
    wrench = placed.act(pin.Force(torque[:6]))
    return np.asarray(np.array([-wrench.angular[1], wrench.angular[0]]) / wrench.linear[2])


def test_mass_and_spin_together_are_the_whole_body_s_dynamics() -> None:
    aligned, base = swinging()
    robot = robots.kinematics("nao").robot
    world = in_world(aligned, base, robot)
    shift = spin(aligned, base, world, robot)
    lift = GRAVITY + world.acceleration[:, 2]
    point = world.com[:, :2] - (world.com[:, 2] / lift)[:, None] * world.acceleration[:, :2]
    inside = range(40, 160, 10)
    wanted = np.array([zero_moment_point(aligned, base, index) for index in inside])
    found = (point + shift)[list(inside)]
    assert np.abs(shift[list(inside)]).max() > 5e-3
    np.testing.assert_allclose(found, wanted, atol=6e-4)


def test_stances_are_cut_into_pieces_alike() -> None:
    time = np.arange(0.0, 10.0, 0.01)
    stance = np.full(len(time), -1)
    for number, (begin, end) in enumerate(((0.0, 3.05), (4.0, 4.3), (5.0, 10.0))):
        stance[(time >= begin) & (time < end)] = number
    found = pieces(time, stance, rate=1.0)
    for number, count in enumerate((3, 1, 5)):
        sizes = np.bincount(found[stance == number].astype(int))
        assert len(sizes) == count
        assert np.ptp(sizes) <= 2
