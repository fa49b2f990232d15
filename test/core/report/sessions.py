"""Small sessions whose joint angles and readings belong together."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from core.estimation import synthetic
from core.robot import robots
from core.shoe import shoes
from shoecal_core.arrays import FloatArray
from shoecal_core.recording import messages, schemas
from shoecal_core.recording.session import Session
from shoecal_core.robot.double_support import DoubleSupport
from shoecal_core.robot.kinematics import BodyStates
from shoecal_core.shoe.shoe import Shoe
from shoecal_core.shoe.wrench import at_cop, columns_in_left, combined, weight_below

START_NS = 10**9
STEP_NS = 100_000_000
SPREADS = (0.06, 0.12)
"""How far the legs are spread in each run [rad]."""


def swaying_session(folder: Path) -> Session:
    """The NAO sways over legs that it spreads further from run to run; the last one tests.

    It is the first one from its end to its beginning: without noise, the same once more would be
    the same recording.
    """
    robot, shoe = robots.load("nao"), shoes.shoe("nao_shoe")
    parameters = synthetic.truth(shoe, np.random.default_rng(3))
    session = Session.create(folder, robot.path, robot.urdf, shoe.path)
    for number, spread in enumerate((*SPREADS, SPREADS[0]), start=1):
        angles = joint_angles(spread)[:: -1 if number > len(SPREADS) else 1]
        states = robots.kinematics("nao").states(angles)
        forces = cell_forces(shoe, states, robot.weight)
        readings = (forces - parameters.offset) / parameters.gain
        with session.new_run("landmarks", states.support()) as writer:
            for index, (pose, volts) in enumerate(zip(angles, readings, strict=True)):
                stamp = START_NS + STEP_NS * index
                effort = np.full(len(pose), np.nan)
                writer.write(
                    schemas.JOINT_STATES,
                    messages.joint_state(stamp, robot.joint_names, pose, effort),
                    stamp,
                )
                writer.write(
                    schemas.VOLTAGES,
                    messages.shoe_voltages(stamp, index, shoe.names, volts, np.zeros(len(volts))),
                    stamp,
                )
        write_truth(session, number, states, robot.weight)
    session.mark((1, 2), (3,))
    return session


def joint_angles(spread: float, count: int = 120) -> FloatArray:
    """(count, m): both legs lean to the side and to the front alike, so no foot moves."""
    robot = robots.load("nao")
    angles = np.tile(robot.posture, (count, 1))
    phase = np.linspace(0.0, 4.0 * np.pi, count)
    for index, name in enumerate(robot.joint_names):
        side = {"L": 1.0, "R": -1.0}.get(name[0], 0.0)
        sign = {"HipRoll": 1.0, "AnkleRoll": -1.0}.get(name[1:], 0.0)
        angles[:, index] += sign * (side * spread + 0.06 * np.sin(phase))
        lean = {"HipPitch": 1.0, "AnklePitch": -1.0}.get(name[1:], 0.0)
        angles[:, index] += 0.06 * lean * np.cos(1.5 * phase)
    return angles


def cell_forces(shoe: Shoe, states: BodyStates, weight: float) -> FloatArray:
    """(T, n) smallest forces that carry the weight above the modelled CoP."""
    support: DoubleSupport = states.support()
    wanted = at_cop(np.full(len(states.com), weight), states.cop[:, 0])
    carried = wanted - combined(weight_below(shoe), support)
    forces: FloatArray = carried @ np.linalg.pinv(columns_in_left(shoe, support))
    return forces


def write_truth(session: Session, run: int, states: BodyStates, weight: float) -> None:
    """A truth in which the model was right."""
    with session.new_truth(session.runs[run - 1].info) as writer:
        for index, cop in enumerate(states.cop[:, 0]):
            writer.write(
                START_NS + STEP_NS * index, cop, np.stack((cop, cop)), (weight / 2.0, weight / 2.0)
            )
