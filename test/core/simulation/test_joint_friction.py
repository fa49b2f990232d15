"""Against statics: what it takes to turn a joint, at which speed, and what it does to a gear."""

from __future__ import annotations

import dataclasses
import itertools

import mujoco
import numpy as np
import pytest

from core.simulation.worlds import PERFECT, World, changed
from shoecal_core.arrays import FloatArray
from shoecal_core.robot.joint_trajectory import JointTrajectory
from shoecal_core.simulation.joint_friction import BristleFriction, add_bristle
from shoecal_core.simulation.robot import SimulatedRobot
from shoecal_core.simulation.sampled_robot import draw

STATIC, KINETIC, STRIBECK = 0.3, 0.1, 0.05
COMPLIANCE = 0.005
KNEE = "LKneePitch"


class Wheel:
    """A wheel on one joint without gravity, turned by a servo: what it takes is friction alone."""

    def __init__(self) -> None:
        spec = mujoco.MjSpec()
        spec.option.gravity = [0.0, 0.0, 0.0]
        spec.option.timestep = 0.0025
        spec.option.integrator = mujoco.mjtIntegrator.mjINT_DISCRETE
        body = spec.worldbody.add_body(name="wheel", mass=0.1)
        body.inertia, body.explicitinertial = [1e-3, 1e-3, 1e-3], True
        joint = body.add_joint(name="axle", type=mujoco.mjtJoint.mjJNT_HINGE, axis=[0, 1, 0])
        add_bristle(spec, joint, STATIC, None)
        servo = spec.add_actuator(
            name="axle", target="axle", trntype=mujoco.mjtTrn.mjTRN_JOINT,
            gaintype=mujoco.mjtGain.mjGAIN_FIXED, biastype=mujoco.mjtBias.mjBIAS_AFFINE,
        )  # fmt: skip
        servo.gainprm[0], servo.biasprm[1], servo.biasprm[2] = 250.0, -250.0, -7.5
        self.model = spec.compile()
        self.data = mujoco.MjData(self.model)
        friction = np.array([[STATIC, KINETIC]])
        self.friction = BristleFriction(self.model, ("axle",), friction, STRIBECK)

    def turn(self, speed: float, seconds: float, push: float = 0.0) -> float:
        """Torque that it takes in the end [N m]; a push [N m] comes little by little."""
        steps = round(seconds / 0.0025)
        begin = self.data.qfrc_applied[0]
        for step in range(steps):
            self.data.qfrc_applied[0] = begin + (step + 1) / steps * push
            self.data.ctrl[0] += speed * 0.0025
            self.friction.slip(self.data)
            mujoco.mj_step(self.model, self.data)
        # MuJoCo's own figure of the force belongs to the start of a step.
        (_, spring, damping), data = self.model.actuator_biasprm[0, :3], self.data
        return float(spring * (data.qpos[0] - data.ctrl[0]) + damping * data.qvel[0])


@pytest.mark.parametrize("speed", [0.005, 0.05, 0.1, 0.3])
def test_turning_takes_stribecks_torque(speed: float) -> None:
    wheel = Wheel()
    expected = KINETIC + (STATIC - KINETIC) * np.exp(-((speed / STRIBECK) ** 2))
    for way, _ in itertools.product((1.0, -1.0), range(2)):
        torque = way * wheel.turn(way * speed, 1.0)
        assert torque == pytest.approx(expected, rel=0.01)


def test_at_rest_it_holds_against_less_than_static_friction_for_ever() -> None:
    wheel = Wheel()
    # Nothing but friction holds it.
    wheel.model.actuator_gainprm[0] = wheel.model.actuator_biasprm[0] = 0.0
    wheel.turn(0.0, 2.0, push=0.9 * STATIC)
    begin = float(wheel.data.qpos[0])
    assert begin == pytest.approx(0.9e-3, abs=5e-5)
    wheel.turn(0.0, 60.0)
    assert wheel.data.qpos[0] == pytest.approx(begin, abs=1e-6)
    wheel.turn(0.0, 1.0, push=0.2 * STATIC)
    assert wheel.data.qpos[0] > 0.1


def squat(nao: World, friction: float) -> tuple[SimulatedRobot, FloatArray]:
    """Sag (2,) of a knee's gear [rad] on the ways down and up, at the same angle of the knee.

    Args:
        friction: of that knee alone [N m].
    """
    robot = nao.robot
    rules = changed(PERFECT, joints__compliance_rad_per_nm={KNEE: COMPLIANCE})
    drawn = draw(rules, robot, nao.shoe, 1)
    pairs = drawn.body.friction.copy()
    pairs[robot.joint(KNEE)] = friction
    drawn = dataclasses.replace(drawn, body=dataclasses.replace(drawn.body, friction=pairs))
    sim = SimulatedRobot(robot, nao.shoe, drawn, np.random.default_rng(1))
    sim.place(robot.posture)
    low = robot.posture.copy()
    for side in "LR":
        for joint, angle in (("HipPitch", -0.2), ("KneePitch", 0.4), ("AnklePitch", -0.2)):
            low[robot.joint(side + joint)] += angle
    begin, seconds = sim.time, 8.0
    poses = np.stack((robot.posture, low, robot.posture))
    sim.command(JointTrajectory(robot.joint_names, np.arange(3.0) * seconds, poses))
    gear = sim.physics.model.joint(f"gear/{KNEE}").qposadr[0]
    found = []
    for share in (0.5, 1.5):
        sim.step_to(begin + share * seconds)
        found.append(sim.data.qpos[gear])
    return sim, np.array(found)


def test_a_gear_sags_less_on_the_way_down_than_on_the_way_up(nao: World) -> None:
    """By friction times compliance each; legs that share the load otherwise take some of it off."""
    friction = 0.2
    _, plain = squat(nao, 0.0)
    sim, found = squat(nao, friction)
    assert plain[1] == pytest.approx(plain[0], abs=5e-5)
    loop = (found - plain) @ [1.0, -1.0] * np.sign(plain[0])
    assert -2.0 * COMPLIANCE * friction * 1.05 < loop < -0.5 * COMPLIANCE * friction
    # Encoders do not see it: the servo brings them where they are told.
    knee = nao.robot.joint(KNEE)
    torque = sim.joints().efforts[knee]
    gear = sim.physics.model.joint(f"gear/{KNEE}").qposadr[0]
    assert sim.data.qpos[gear] == pytest.approx(-COMPLIANCE * torque, rel=0.1)


def test_a_robot_that_is_put_down_again_is_as_new(nao: World) -> None:
    sim, _ = squat(nao, 0.2)
    sim.place(nao.robot.posture)
    again = sim.snapshot().motor_torque
    fresh = SimulatedRobot(nao.robot, nao.shoe, sim.drawn, np.random.default_rng(1))
    fresh.place(nao.robot.posture)
    assert again == pytest.approx(fresh.snapshot().motor_torque, abs=1e-9)
