"""Humanoids whose descriptions are public."""

from __future__ import annotations

from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, distribution
from pathlib import Path

PACKAGE = "example-robot-data"
FOLDER = "cmeel.prefix/share/example-robot-data/robots"


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
