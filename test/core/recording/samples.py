"""Runs made up for the tests of recording."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np

from shoecal_core.arrays import FloatArray, IntArray
from shoecal_core.recording import messages, schemas
from shoecal_core.recording.info import RunInfo
from shoecal_core.recording.writer import RunWriter
from shoecal_core.robot.double_support import DoubleSupport

START_NS = 1_700_000_000_123_456_789
STEP_NS = 10_000_000
JOINTS = ("LHipYawPitch", "LHipRoll", "LKneePitch")
SUPPORT = DoubleSupport(0.02, -0.1, 0.3)
INFO = RunInfo(
    run=1,
    motion="landmarks",
    support=SUPPORT,
    robot="nao",
    shoe="test_shoe",
    robot_hash="1" * 64,
    shoe_hash="2" * 64,
    urdf_hash="3" * 64,
)

SHOE_YAML = """\
format: 1
name: test_shoe
unit: V
height_m: 0.02
converter: {lowest: -5.0, highest: 5.0}
feet:
  left:
    plates: {mass_above_kg: 0, com_above_m: [0, 0, 0], mass_below_kg: 0, com_below_m: [0, 0, 0]}
    cells:
      - {name: front, position_m: [0.08, 0.0]}
      - {name: rear_left, position_m: [-0.04, 0.03]}
      - {name: rear_right, position_m: [-0.04, -0.03]}
  right:
    plates: {mass_above_kg: 0, com_above_m: [0, 0, 0], mass_below_kg: 0, com_below_m: [0, 0, 0]}
    cells:
      - {name: front, position_m: [0.08, 0.0]}
      - {name: rear_left, position_m: [-0.04, 0.03]}
      - {name: rear_right, position_m: [-0.04, -0.03]}
"""

ANKLE_YAML = """\
format: 1
name: ankles
unit: N
height_m: 0.0
converter: {lowest: -2000.0, highest: 2000.0}
feet:
  left:
    plates: {mass_above_kg: 0, com_above_m: [0, 0, 0], mass_below_kg: 0, com_below_m: [0, 0, 0]}
    six_axis:
      origin_m: [0.0, 0.0, 0.1]
      axes: [{axis: fx}, {axis: fy}, {axis: fz}, {axis: mx}, {axis: my}]
  right:
    plates: {mass_above_kg: 0, com_above_m: [0, 0, 0], mass_below_kg: 0, com_below_m: [0, 0, 0]}
    six_axis:
      origin_m: [0.0, 0.0, 0.1]
      axes: [{axis: fz}, {axis: mx}, {axis: my}]
"""

ROBOT_YAML = "format: 1\nname: nao\n"
URDF = """\
<robot name="nao">
  <link name="a"/><link name="b"/><link name="c"/>
  <joint name="LHipRoll" type="revolute"><parent link="a"/><child link="b"/></joint>
  <joint name="LKneePitch" type="revolute"><parent link="b"/><child link="c"/></joint>
  <joint name="mount" type="fixed"><parent link="c"/><child link="d"/></joint>
</robot>
"""


class Sources(NamedTuple):
    """The files a session is made of."""

    robot_yaml: Path
    robot_urdf: Path
    shoe_yaml: Path


@dataclass(frozen=True)
class Sample:
    """What a made-up run holds: stamps (T,) [ns], angles and efforts (T, m), volts (T, n)."""

    stamps: IntArray
    angles: FloatArray
    efforts: FloatArray
    volts: FloatArray


def make_sample(count: int, channels: int = 6, seed: int = 1) -> Sample:
    rng = np.random.default_rng(seed)
    return Sample(
        stamps=START_NS + STEP_NS * np.arange(count),
        angles=rng.normal(size=(count, len(JOINTS))),
        efforts=rng.normal(size=(count, len(JOINTS))),
        volts=rng.normal(size=(count, channels)),
    )


def write_sample(writer: RunWriter, sample: Sample, cells: tuple[str, ...]) -> None:
    for index, stamp in enumerate(sample.stamps.tolist()):
        joints = messages.joint_state(stamp, JOINTS, sample.angles[index], sample.efforts[index])
        writer.write(schemas.JOINT_STATES, joints, stamp)
        status = np.zeros(len(cells))
        volts = messages.shoe_voltages(stamp, index, cells, sample.volts[index], status)
        writer.write(schemas.VOLTAGES, volts, stamp)


def write_run(path: Path, sample: Sample, cells: tuple[str, ...]) -> Path:
    with RunWriter(path, INFO) as writer:
        write_sample(writer, sample, cells)
    return path
