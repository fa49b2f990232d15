"""The robot, its shoe, a calibration, and frames whose number can be read from the CoP."""

from __future__ import annotations

import time
from functools import cache

import numpy as np

from shoecal_core.arrays import FloatArray, IntArray
from shoecal_core.estimation.calibration import Calibration
from shoecal_core.planning.posture import stance
from shoecal_core.robot.double_support import DoubleSupport
from shoecal_core.robot.robot import Robot
from shoecal_core.robot.robot_file import load_robot
from shoecal_core.shoe.shoe import Shoe
from shoecal_core.shoe.shoe_file import load_shoe
from shoecal_core.shoe.wrench import ChannelParameters
from shoecal_core.workspace import config_dir

SUPPORT = DoubleSupport(0.0, -0.112, 0.0)
NUMBERS = 1024
"""Frames that can be told apart."""
ON_LEFT = 20.0
"""Force that is shifted from the left foot's rear to its front [N]."""


@cache
def shoe() -> Shoe:
    return load_shoe(config_dir() / "shoes" / "nao_shoe.yaml")


@cache
def robot() -> Robot:
    return load_robot(config_dir() / "robots" / "nao.yaml", shoe())


def standing() -> FloatArray:
    """(m,) joint angles [rad]."""
    return robot().from_legs(stance(robot(), SUPPORT))


def calibration() -> Calibration:
    """One that passes: gains and offsets of some cells."""
    count = len(shoe().names)
    sign = np.where(shoe().polarity == 0, 1, shoe().polarity)
    gain = sign * np.linspace(9.0, 14.0, count)
    return Calibration(
        id="bench", source="self", made_ns=time.time_ns(),
        robot=robot().name, shoe=shoe().name,
        robot_hash=robot().digest, shoe_hash=shoe().digest,
        channels=shoe().names, parameters=ChannelParameters(gain, np.linspace(-1.0, 1.0, count)),
        covariance=None, corrections=(), weight=robot().weight, time_offset=0.0,
        temperature=21.5, verdict="PASS", reasons=("made for a benchmark",), fitted_runs=(),
    )  # fmt: skip


def numbered_counts(volts_per_count: float) -> IntArray:
    """(NUMBERS, n) counts of the cells, one row a number."""
    names, law = shoe().names, calibration().parameters
    outputs = np.full((NUMBERS, len(names)), 6.0)
    share = np.arange(NUMBERS) / NUMBERS
    for name, force in (("left/front_left", share), ("left/rear_left", 1.0 - share)):
        outputs[:, names.index(name)] += ON_LEFT * force
    return np.rint((outputs - law.offset) / law.gain / volts_per_count).astype(np.int64)


def cop_of(counts: IntArray, volts_per_count: float) -> FloatArray:
    """(NUMBERS,) x of the CoP that such frames give [m]."""
    volts: FloatArray = counts.astype(np.float64) * volts_per_count
    measured = calibration().sensing(shoe()).measure(volts)
    return measured.combined_cop(SUPPORT)[..., 0]


def numbers_of(x: FloatArray, of_numbers: FloatArray) -> IntArray:
    """Numbers, modulo NUMBERS, of CoPs."""
    slope, begin = np.polyfit(np.arange(NUMBERS), of_numbers, 1)
    found: IntArray = np.rint((x - begin) / slope).astype(np.int64) % NUMBERS
    return found
