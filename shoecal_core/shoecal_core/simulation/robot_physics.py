"""The robot as physics: the URDF's links on a free base, servos, gears with play, shoes."""

from __future__ import annotations

import mujoco
import numpy as np
import pinocchio as pin

from shoecal_core.arrays import FloatArray
from shoecal_core.files import read_bytes
from shoecal_core.robot.gravity import GRAVITY
from shoecal_core.robot.robot import Robot
from shoecal_core.robot.urdf import ROOT_JOINTS, UrdfError, with_joints_plain
from shoecal_core.shoe.shoe import Shoe
from shoecal_core.simulation.compiled_robot import RobotPhysics
from shoecal_core.simulation.joint_friction import add_bristle
from shoecal_core.simulation.sampled_robot import SampledRobot
from shoecal_core.simulation.shoe_physics import ShoeBuilder, add_floor

_STIFFEST_GEAR = 1e-5
"""rad/(N m); the compliance of a gear that has play alone."""
_GEAR_DAMPING = 0.2
"""s/rad; damping of a gear over its motor's torque limit."""
_LEAST_MASS, _LEAST_INERTIA = 1e-6, 1e-9
"""kg, kg m^2; of links that the URDF gives no mass."""
_HOLDING = 3.0
"""Torque of a motor whose limit the URDF leaves at zero, over the most that its links need."""
_LEAST_TORQUE = 0.01
"""N m; of such a motor, be its links as light as they may."""
_PAYLOAD_RADIUS = 0.02
"""m."""


def build(robot: Robot, shoe: Shoe, drawn: SampledRobot) -> RobotPhysics:
    """Build a robot that wears shoes, as drawn.

    Args:
        robot: with the shoes on (`load_robot(path, shoe)`).
        shoe: what it wears.
        drawn: as both truly are.

    Raises:
        UrdfError: when MuJoCo refuses the URDF.
        ShoecalError: for a shoe that cannot be simulated.
    """
    try:
        model = build_spec(robot, shoe, drawn).compile()
    except (ValueError, SyntaxError) as error:
        raise UrdfError(robot.urdf, f"not fit for simulation: {error}; correct the link") from error
    leader = np.arange(len(robot.joint_names))
    ratio = np.ones(len(leader))
    for shared in robot.shared:
        leader[shared.joint], ratio[shared.joint] = shared.leader, shared.ratio
    names = robot.joint_names
    motor = np.array([model.actuator(names[joint]).id for joint in leader])
    return RobotPhysics(
        model=model,
        positions=np.array([model.joint(name).qposadr[0] for name in names]),
        motor=motor,
        ratio=ratio,
        torque_limit=model.actuator_forcerange[:, 1].copy(),
    )


def build_spec(robot: Robot, shoe: Shoe, drawn: SampledRobot) -> mujoco.MjSpec:
    """The same before compilation, so that more can be added."""
    spec = _read_urdf(robot)
    _set_masses(spec, drawn)
    spec.worldbody.first_body().add_freejoint()
    _add_motors(spec, robot, drawn)
    add_floor(spec, drawn.rules, drawn.shoes)
    builder = ShoeBuilder(shoe, drawn.rules, drawn.shoes)
    for index, foot in enumerate(robot.feet):
        ankle = spec.joint(robot.model.names[foot.joint]).parent
        sole = foot.placement * _askew(drawn.body.foot_placement[index])
        x, y, z, w = pin.Quaternion(sole.rotation).coeffs()
        builder.add(spec, ankle, index, sole.translation, np.array([w, x, y, z]), foot.outline)
    for effect in drawn.rules.effects:
        effect.on_spec(spec, robot)
    return spec


def _askew(placement: FloatArray) -> pin.SE3:
    """A sole frame that is off where it should be: along x, y [m], turned about z [rad]."""
    dx, dy, dtheta = placement
    return pin.SE3(pin.rpy.rpyToMatrix(0.0, 0.0, dtheta), np.array([dx, dy, 0.0]))


def _read_urdf(robot: Robot) -> mujoco.MjSpec:
    """The URDF's links and joints; shapes are left out, only soles touch anything."""
    text = read_bytes(robot.urdf).decode("utf-8", errors="replace")
    try:
        spec = mujoco.MjSpec.from_string(with_joints_plain(text))
    except (ValueError, SyntaxError) as error:
        raise UrdfError(robot.urdf, f"not fit for simulation: {error}") from error
    for element in (*spec.geoms, *spec.meshes, *spec.equalities):
        spec.delete(element)
    # Links on fixed joints stay bodies of their own, so that each has its mass error.
    spec.compiler.fusestatic = False
    spec.compiler.balanceinertia = True
    spec.compiler.boundmass = _LEAST_MASS
    spec.compiler.boundinertia = _LEAST_INERTIA
    return spec


def _set_masses(spec: mujoco.MjSpec, drawn: SampledRobot) -> None:
    body = drawn.body
    _add_payloads(spec, drawn)
    factors = dict(zip(body.links, body.mass_factor, strict=True))
    shifts = dict(zip(body.links, body.com_error, strict=True))
    links = [link for link in spec.bodies if link.name in factors and link.mass > 0.0]
    scale = body.mass / sum(link.mass * factors[link.name] for link in links)
    for link in links:
        factor = scale * factors[link.name]
        link.mass *= factor
        link.inertia = link.inertia * factor
        link.fullinertia = link.fullinertia * factor
        link.ipos = link.ipos + shifts[link.name]


def _add_payloads(spec: mujoco.MjSpec, drawn: SampledRobot) -> None:
    """Small balls, welded to their links where the model has the links' CoM."""
    for name, mass in zip(drawn.body.links, drawn.body.payload, strict=True):
        if mass > 0.0:
            link = spec.body(name)
            ball = link.add_body(name=f"payload/{name}", pos=link.ipos)
            ball.mass, ball.ipos = mass, np.zeros(3)
            ball.inertia = np.full(3, 0.4 * mass * _PAYLOAD_RADIUS**2)
            ball.explicitinertial = True


def _add_motors(spec: mujoco.MjSpec, robot: Robot, drawn: SampledRobot) -> None:
    """Motors with gears; the URDF's joints become the motors' side."""
    servo, body = drawn.rules.servo, drawn.body
    names, limits = robot.joint_names, _torque_limits(robot) * servo.torque_limit_factor
    leaders = {shared.joint: shared for shared in robot.shared}
    for index, name in enumerate(names):
        limit = float(limits[index])
        joint = spec.joint(name)
        joint.actfrclimited = mujoco.mjtLimited.mjLIMITED_FALSE
        joint.armature = servo.rotor_inertia_kgm2_per_nm * limit
        joint.frictionloss = servo.friction_fraction * limit
        gives = body.play[index] > 0.0 or body.compliance[index] > 0.0
        if gives:
            _add_gear(spec, joint, limit, body.play[index], body.compliance[index])
        if body.friction[index, 0] > 0.0:
            add_bristle(spec, joint, body.friction[index, 0], gear_name(joint) if gives else None)
        if index in leaders:
            shared = leaders[index]
            spec.add_equality(
                type=mujoco.mjtEq.mjEQ_JOINT,
                name1=name,
                name2=names[shared.leader],
                data=[0.0, shared.ratio, *[0.0] * 10],
                solref=[2.0 * drawn.rules.step_s, 1.0],
            )
        else:
            stiffness = limit / servo.full_torque_error_rad
            _add_servo(spec, name, limit, stiffness, stiffness * servo.damping_time_s)


def _torque_limits(robot: Robot) -> FloatArray:
    """(m,) of the motors [N m]; fingers without a limit in the URDF are held nevertheless."""
    model = robot.model
    data = model.createData()
    pin.centerOfMass(model, data, pin.neutral(model), True)
    held = [
        GRAVITY * data.mass[joint] * float(np.linalg.norm(data.com[joint]))
        for joint in range(ROOT_JOINTS, model.njoints)
    ]
    least = np.maximum(_HOLDING * np.array(held), _LEAST_TORQUE)
    return np.where(robot.effort_limit > 0.0, robot.effort_limit, least)


def _add_gear(
    spec: mujoco.MjSpec, motor: mujoco.MjsJoint, limit: float, play: float, compliance: float
) -> None:
    """A second joint about the same axis: free within the play, a spring beyond it."""
    name = gear_name(motor)
    motor.parent.add_joint(
        name=name,
        type=motor.type,
        pos=motor.pos,
        axis=motor.axis,
        damping=[_GEAR_DAMPING * limit, 0.0, 0.0],
    )
    tendon = spec.add_tendon(
        name=name,
        stiffness=[1.0 / max(compliance, _STIFFEST_GEAR), 0.0, 0.0],
        springlength=[-play / 2.0, play / 2.0],
    )
    tendon.wrap_joint(name, 1.0)


def gear_name(motor: mujoco.MjsJoint) -> str:
    """Joint and tendon of a gear that gives."""
    return f"gear/{motor.name}"


def _add_servo(
    spec: mujoco.MjSpec, name: str, limit: float, stiffness: float, damping: float
) -> None:
    """A position servo whose set point moves evenly between two commands.

    Its activation is the set point, its control the set point's speed.
    """
    servo = spec.add_actuator(
        name=name,
        target=name,
        trntype=mujoco.mjtTrn.mjTRN_JOINT,
        dyntype=mujoco.mjtDyn.mjDYN_INTEGRATOR,
        gaintype=mujoco.mjtGain.mjGAIN_FIXED,
        biastype=mujoco.mjtBias.mjBIAS_AFFINE,
        forcelimited=mujoco.mjtLimited.mjLIMITED_TRUE,
        forcerange=[-limit, limit],
    )
    servo.gainprm[0] = stiffness
    servo.biasprm[1:3] = -stiffness, -damping
