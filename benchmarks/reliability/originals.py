"""Whole files of every kind, small: what the mutants are made of."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np

from shoecal_core.estimation.calibration import Calibration
from shoecal_core.recording import messages, schemas
from shoecal_core.recording.session import Session
from shoecal_core.recording.writer import RunWriter
from shoecal_core.robot.double_support import DoubleSupport
from shoecal_core.robot.robot import Robot
from shoecal_core.robot.robot_file import load_robot
from shoecal_core.shoe.correction import POLYNOMIAL, CopCorrection
from shoecal_core.shoe.shoe import Shoe
from shoecal_core.shoe.shoe_file import load_shoe
from shoecal_core.shoe.wrench import ChannelParameters

CONFIG = Path(__file__).parents[2] / "config"
ROBOT = CONFIG / "robots/nao.yaml"
URDF = CONFIG / "robots/nao.urdf"
SHOE = CONFIG / "shoes/nao_shoe.yaml"
START_NS = 1_780_000_000_000_000_000
STEP_NS = 10_000_000
SUPPORT = DoubleSupport(0.02, -0.11, 0.2)


@cache
def shoe() -> Shoe:
    """The NAO's shoes."""
    return load_shoe(SHOE)


@cache
def robot() -> Robot:
    """The NAO on its shoes."""
    return load_robot(ROBOT, shoe())


def session(folder: Path, runs: int = 0, samples: int = 40) -> Session:
    """A session of some short runs."""
    made = Session.create(folder, ROBOT, URDF, SHOE, seed=1)
    for run in range(runs):
        with made.new_run("landmarks", SUPPORT, hint="train" if run else "test") as writer:
            for index in range(samples):
                for topic, data in sample(index).items():
                    writer.write(topic, data, START_NS + index * STEP_NS)
            write_others(writer)
    return made


def angles(index: int) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    """Joint angles (m,) of one sample [rad]; no two are alike, and none is an encoder's zero."""
    return np.sin(index + 0.5 + np.arange(len(robot().joint_names), dtype=np.float64))


def volts(index: int) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    """Readings (n,) of one sample [V]; no two are alike."""
    return np.cos(index + np.arange(len(shoe().names)))


def sample(index: int, stamp_ns: int | None = None) -> dict[str, bytes]:
    """Joint angles and voltages of one time, by topic."""
    stamp = START_NS + index * STEP_NS if stamp_ns is None else stamp_ns
    names = shoe().names
    return {
        schemas.JOINT_STATES: messages.joint_state(stamp, robot().joint_names, angles(index)),
        schemas.VOLTAGES: messages.shoe_voltages(
            stamp, index, names, volts(index), np.zeros(len(names)), temperature=25.0
        ),
    }


def write_others(writer: RunWriter) -> None:
    """One message of every other kind."""
    names = robot().joint_names[:3]
    others = {
        schemas.JOINT_TRAJECTORY: messages.joint_trajectory(
            START_NS, names, [0.0, 1.0], np.zeros((2, len(names)))
        ),
        schemas.BASE_POSE: messages.pose(START_NS, "world", (0, 0, 0.3), (0, 0, 0, 1)),
        schemas.IMU: messages.imu(START_NS, "imu", None, (0, 0, 0), (0, 0, 9.8)),
        schemas.SHOE_TEMPERATURE: messages.temperature(START_NS, "shoe", 25.0),
        schemas.JOINT_TEMPERATURES: messages.temperature(START_NS, names[0], 40.0),
    }
    for topic, data in others.items():
        writer.write(topic, data, START_NS + 10**9)


def calibration(identity: str = "made") -> Calibration:
    """One with all that a calibration may hold."""
    count, rng = len(shoe().names), np.random.default_rng(3)
    of_left = len(shoe().of_foot(0))
    return Calibration(
        id=identity,
        source="self",
        made_ns=START_NS,
        robot=robot().name,
        shoe=shoe().name,
        robot_hash=robot().digest,
        shoe_hash=shoe().digest,
        channels=shoe().names,
        parameters=ChannelParameters(
            shoe().polarity * rng.uniform(8.0, 15.0, count), rng.uniform(-3.0, 3.0, count)
        ),
        covariance=np.diag(rng.uniform(0.1, 1.0, 2 * count)),
        corrections=(
            CopCorrection(
                foot=0,
                x=rng.uniform(-1e-3, 1e-3, POLYNOMIAL + of_left),
                y=rng.uniform(-1e-3, 1e-3, POLYNOMIAL + of_left),
                cop_range=np.array([[-0.05, -0.03], [0.08, 0.03]]),
                output_range=np.array([[0.0] * of_left, [30.0] * of_left]),
            ),
        ),
        weight=robot().weight,
        time_offset=0.004,
        temperature=25.0,
        verdict="PASS",
        reasons=("every check passed",),
        fitted_runs=("0" * 64,),
        columns=shoe().columns,
    )
