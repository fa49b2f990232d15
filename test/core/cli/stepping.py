"""A session of a NAO on ankle sensors that steps on the spot: known weight, gains and zeros."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from core.robot import robots
from core.shoe import shoes
from shoecal_core.recording import messages, schemas
from shoecal_core.recording.session import Session
from shoecal_core.robot.gravity import GRAVITY
from shoecal_core.robot.kinematics import Kinematics
from shoecal_core.robot.robot_file import load_robot
from shoecal_core.samples.momentum import base_in_stance
from shoecal_core.shoe.shoe_file import load_shoe
from shoecal_core.shoe.wrench import at_cop

STEP_NS = 20_000_000
PHASES = ((0.5, 0.5), (1.0, 0.0), (0.5, 0.5), (0.0, 1.0))
"""Shares of the weight."""
PHASE_S = 1.5
LIFT_RAD = 0.25
HEIGHT = 0.05


@dataclass(frozen=True)
class Stepping:
    """What a run of the session holds.

    Attributes:
        zeros: vertical force that the left and the right foot show in the air [N].
        least: share of the weight that no foot falls below; feet that carry some are not lifted.
    """

    zeros: tuple[float, float]
    least: float = 0.0


def stepping_session(folder: Path, runs: Sequence[Stepping], heavier: float = 1.0) -> Session:
    """Twelve phases a run.

    Args:
        folder: of the session.
        runs: of it.
        heavier: the robot is so many times as heavy as its file says.
    """
    source = (shoes.ROOT / "config/shoes/reemc.yaml").read_text()
    sheet = folder.with_name("nao_ankles.yaml")
    sheet.write_text(
        source.replace("name: reemc_feet", "name: nao_ankles").replace("0.12]", f"{HEIGHT}]")
    )
    nao = robots.load("nao", shod=False)
    session = Session.create(folder, nao.path, nao.urdf, sheet)
    kinematics = Kinematics(load_robot(nao.path, load_shoe(sheet), urdf=nao.urdf))
    for number, run in enumerate(runs, start=1):
        _record(session, kinematics, run, heavier, np.random.default_rng(number))
    return session


def _record(
    session: Session,
    kinematics: Kinematics,
    run: Stepping,
    heavier: float,
    rng: np.random.Generator,
) -> None:
    robot = kinematics.robot
    time = np.arange(0.0, 12 * PHASE_S, 1e-9 * STEP_NS)
    phase, within = (time // PHASE_S).astype(int) % len(PHASES), time % PHASE_S / PHASE_S
    shares = np.array(PHASES)[phase]
    up = np.where(shares == 0.0, np.sin(np.pi * within)[:, None] ** 2, 0.0) * (run.least == 0.0)
    angles = np.tile(robot.posture, (len(time), 1))
    for foot, side in enumerate("LR"):
        for joint, part in (("HipPitch", -1.0), ("KneePitch", 2.0), ("AnklePitch", -1.0)):
            angles[:, robot.joint(side + joint)] += part * LIFT_RAD * up[:, foot]
    sway = 0.02 * np.sin(2.0 * np.pi * time / 3.7)
    for side in "LR":
        angles[:, robot.joint(f"{side}AnklePitch")] += sway
        angles[:, robot.joint(f"{side}HipPitch")] -= sway
    states = kinematics.states(angles)
    standing = np.where(shares[:, 0] == 0.0, 1, 0)
    quaternion, place = base_in_stance(states, standing)
    # Where the right foot stands in the left one's frame.
    place = place + np.where(standing[:, None] == 1, np.median(states.translation, axis=0), 0.0)
    shares = run.least + (1.0 - 2.0 * run.least) * shares
    cop = states.cop
    readings = np.zeros((len(time), 2, 6))
    for foot in (0, 1):
        force = heavier * robot.weight * shares[:, foot]
        alone = np.where(shares[:, [foot]] > 0.9, cop[:, foot], 0.0)
        wrench = at_cop(force, alone)
        # Loads sideways between the feet, which the sole's CoP does not show.
        sideways = shares[:, [foot]] * np.stack((3.0 * np.sin(time), 2.0 * np.cos(time)), axis=1)
        readings[:, foot, :2] = sideways
        readings[:, foot, 2] = force + run.zeros[foot]
        readings[:, foot, 3] = wrench[:, 1] + HEIGHT * sideways[:, 1]
        readings[:, foot, 4] = wrench[:, 2] - HEIGHT * sideways[:, 0]
    readings += 0.05 * rng.standard_normal(readings.shape)
    start = 10**9
    with session.new_run("stepping", None) as writer:
        for index, pose in enumerate(angles):
            stamp = start + STEP_NS * index
            writer.write(
                schemas.JOINT_STATES,
                messages.joint_state(stamp, robot.joint_names, pose, np.full(len(pose), np.nan)),
                stamp,
            )
            writer.write(
                schemas.BASE_POSE,
                messages.pose(stamp, "world", place[index], quaternion[index]),
                stamp,
            )
            for foot, topic in enumerate(schemas.FORCE_TORQUE):
                force, torque = np.split(readings[index, foot], 2)
                writer.write(topic, messages.wrench(stamp, "ankle", force, torque), stamp)


WEIGHT_KG = robots.load("nao", shod=False).mass
WEIGHT_N = GRAVITY * WEIGHT_KG
