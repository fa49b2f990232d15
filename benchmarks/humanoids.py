"""Humanoids whose descriptions are public, and a simulated reality of their size."""

from __future__ import annotations

from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, distribution
from pathlib import Path

from shoecal_core.model.robot import Robot
from shoecal_core.sensing.shoe import Shoe

PACKAGE = "example-robot-data"
FOLDER = "cmeel.prefix/share/example-robot-data/robots"
NAO_KG = 5.3
NAO_HEIGHT_M = 0.3
"""Of its CoM above the soles: the default reality is one of this size."""
ENCODER_RAD = 1e-4
"""16 bits a turn; a NAO's have 12."""
PLAY_RAD = 0.001
GIVE = 0.0015
"""rad/(N m) of a gear on a robot as large as a NAO; robots of tens of kilograms have finer gears
than the NAO, which has 0.0045 of both."""


@dataclass(frozen=True)
class Humanoid:
    """One public description.

    Attributes:
        name: short.
        title: the robot, and whose.
        urdf: under the package's folder of robots.
        six_axis: it has six-axis sensors in the ankles that the URDF does not name.
    """

    name: str
    title: str
    urdf: str
    six_axis: bool = False


HUMANOIDS = (
    Humanoid("icub", "iCub (IIT)", "icub_description/robots/icub_reduced.urdf"),
    Humanoid("g1", "G1 (Unitree)", "g1_description/urdf/g1_29dof_rev_1_0.urdf"),
    Humanoid("romeo", "Romeo (Aldebaran)", "romeo_description/urdf/romeo_small.urdf"),
    Humanoid(
        "talos", "TALOS (PAL Robotics)", "talos_data/robots/talos_full_v2.urdf", six_axis=True
    ),
)


def descriptions() -> Path | None:
    """The folder of the installed package; None where it is not installed."""
    try:
        found = distribution(PACKAGE)
    except PackageNotFoundError:
        return None
    return Path(str(found.locate_file(FOLDER)))


def icubs() -> list[Path]:
    """URDFs of whole iCubs in the package icub-models; none where it is not installed."""
    try:
        files = distribution("icub-models").files or []
    except PackageNotFoundError:
        return []
    found = (Path(str(file.locate())).resolve() for file in files if file.name == "model.urdf")
    return sorted(urdf for urdf in found if urdf.parent.name.startswith("iCub"))


def scaled_reality(robot: Robot, shoe: Shoe, com_height: float) -> dict[str, object]:
    """What of the default reality must grow with a robot that is larger than a NAO.

    Shares of masses, offsets and spreads stay; forces grow with the weight, gears are finer, and
    stiffer as the torques that bend them grow. Six-axis sensors are ten times stiffer than a
    shoe's cells, and come calibrated by their maker.

    Args:
        robot: its weight.
        shoe: its sensors.
        com_height: of its CoM above the soles [m].
    """
    weight = robot.mass / NAO_KG
    torque = weight * com_height / NAO_HEIGHT_M
    cells: dict[str, object] = {
        "stiffness_n_per_m": 1e5 * weight,
        "noise_std_n": 0.01 * weight,
        "noise_std_nm": 0.0005 * torque,
    }
    if all(channel.nominal_gain is None for channel in shoe.channels):
        cells |= {"full_scale_n": 60.0 * weight, "full_scale_nm": 3.0 * torque}
    else:
        half_span = max(channel.highest for channel in shoe.channels)
        cells |= {"full_scale_n": half_span, "full_scale_nm": half_span}
        cells |= {"gain_spread_fraction": 0.05, "offset_std_fraction": 0.001}
        cells["stiffness_n_per_m"] = 1e6 * weight
    return {
        "format": 1,
        "name": f"{robot.name}, with finer joints than a NAO's",
        "body": {"weight_error_n": 0.19 * weight},
        "joints": {
            "encoder_resolution_rad": ENCODER_RAD,
            "play_rad": {"all": PLAY_RAD},
            "compliance_rad_per_nm": {"all": GIVE / torque},
        },
        "cells": cells,
    }
