"""Feet with six-axis sensors: a simulated robot's true wrenches, with something known wrong."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import yaml

from shoecal_core.diagnosis.diagnose import diagnose
from shoecal_core.diagnosis.result import Diagnosis
from shoecal_core.diagnosis.settings import DiagnosisSettings
from shoecal_core.error_sources.effects import places
from shoecal_core.recording import messages, schemas
from shoecal_core.recording.session import ROBOT, SHOE, URDF, Session
from shoecal_core.shoe.shoe import FEET
from shoecal_core.shoe.shoe_file import load_shoe
from shoecal_core.shoe.wrench import ChannelParameters

AXES = ("fz", "mx", "my")
TRAIN, TEST = (1, 2, 3, 4, 5, 6), (7, 8)
RUNS = (*TRAIN, *TEST)
COARSE = DiagnosisSettings(rate_hz=2.0)
NOISE = np.array([0.05, 0.002, 0.002])
"""N, N m, N m."""


def ankles(path: Path, cells: Path) -> Path:
    """The same shoes with a sensor of three axes a foot in the place of the cells."""
    shoe = yaml.safe_load(cells.read_text())
    shoe |= {"name": "ankles", "unit": "N", "converter": {"lowest": -500.0, "highest": 500.0}}
    for foot in shoe["feet"].values():
        foot.pop("cells")
        foot.pop("holes", None)
        axes = [{"axis": axis, "polarity": 1, "nominal_gain": 1.0} for axis in AXES]
        foot["six_axis"] = {"origin_m": [0.0, 0.0, 0.0], "axes": axes}
    path.write_text(yaml.safe_dump(shoe))
    return path


def true_parameters(session: Session) -> ChannelParameters:
    told = yaml.safe_load((session.folder / "truth" / "reality.yaml").read_text())
    names = session.shoe.names
    return ChannelParameters(
        *(np.array([told[key][name] for name in names]) for key in ("gain", "offset"))
    )


def with_ankles(
    session: Session, folder: Path, late: float = 0.0, offset: tuple[str, float] | None = None
) -> Session:
    """What ankle sensors would have told, stamped late, with an encoder that is off."""
    shoe = ankles(folder / "ankles.yaml", session.folder / SHOE)
    made = Session.create(folder / "s", session.folder / ROBOT, session.folder / URDF, shoe)
    cells, parameters = session.shoe, true_parameters(session)
    rng = np.random.default_rng(1)
    for number in RUNS:
        run = session.read(number)
        joints, readings = run.joints, run.readings
        position = joints.position.copy()
        if offset is not None:
            position[:, joints.names.index(offset[0])] += offset[1]
        with made.new_run(run.info.motion, run.info.support) as writer:
            for time, angles in zip(joints.time, position, strict=True):
                stamp = run.start_ns + round(1e9 * time)
                told = messages.joint_state(stamp, joints.names, angles)
                writer.write(schemas.JOINT_STATES, told, stamp)
            outputs = parameters.outputs(readings.value)
            for foot, name in enumerate(FEET):
                own = cells.of_foot(foot)
                wrench = outputs[:, own] @ cells.columns[own]
                wrench += NOISE * rng.normal(size=wrench.shape)
                for time, (f, mx, my) in zip(readings.time + late, wrench, strict=True):
                    stamp = run.start_ns + round(1e9 * time)
                    told = messages.wrench(stamp, name, (0.0, 0.0, f), (mx, my, 0.0))
                    writer.write(schemas.FORCE_TORQUE[foot], told, stamp)
    made.mark(TRAIN, TEST)
    return made


def first_labels(found: Diagnosis) -> set[tuple[str, tuple[str, ...]]]:
    return {(one.effect, one.location) for one in found.ambiguity}


def test_late_sensors_are_late(standard_session: Session, tmp_path: Path) -> None:
    found = diagnose(with_ankles(standard_session, tmp_path, late=0.1), settings=COARSE)
    assert found.verdict in ("explained", "ambiguous")
    (cause,) = found.causes
    # A lag of the same time is nearly the same.
    assert ("latency", ("all",)) in first_labels(found)
    assert cause.location == ("all",)
    (size,) = cause.size.values()
    assert size.value == pytest.approx(0.1, abs=0.02)
    assert cause.shrink.fraction > 0.8


def test_an_encoder_that_is_off(standard_session: Session, tmp_path: Path) -> None:
    session = with_ankles(standard_session, tmp_path, offset=("LHipRoll", 0.03))
    found = diagnose(session, settings=COARSE)
    assert ("joint_offset", ("LHipRoll",)) in first_labels(found)
    assert found.causes[0].shrink.fraction > 0.8


def test_nothing_wrong(standard_session: Session, tmp_path: Path) -> None:
    found = diagnose(with_ankles(standard_session, tmp_path), settings=COARSE)
    assert found.causes == ()


def test_where_effects_can_sit(tmp_path: Path) -> None:
    config = Path(__file__).resolve().parents[3] / "config" / "shoes"
    shoe = load_shoe(config / "reemc.yaml")
    names = np.array(shoe.names)
    assert names[places.vertical(shoe)].tolist() == ["left/fz", "right/fz"]
    assert not len(places.cells(shoe))
    coupled = {(names[receiver], names[donor]) for receiver, donor in places.coupled_axes(shoe)}
    assert ("left/mx", "left/fy") in coupled
    # That is the sensor's place; and no axis hears the other foot's, or itself.
    assert ("left/mx", "left/fz") not in coupled
    assert all(one.split("/")[0] == other.split("/")[0] for one, other in coupled)
    assert all(one != other for one, other in coupled)
