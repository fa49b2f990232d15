"""Readings and joint angles in messages that are no part of ROS's common types, in real bags."""

from __future__ import annotations

import math
import sqlite3
from collections.abc import Mapping, Sequence
from contextlib import closing
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from rosbags.typesys import get_types_from_msg

from core.recording import bags
from core.shoe.shoes import ROOT
from shoecal_core.errors import FileError
from shoecal_core.files import read_yaml, write_yaml
from shoecal_core.recording.imports.bag_draft import draft_mapping, mapping_text
from shoecal_core.recording.imports.bag_fields import (
    LOLA_JOINTS,
    LOLA_POSITIONS,
    cells_by_words,
    number_at,
)
from shoecal_core.recording.imports.bag_import import import_bags
from shoecal_core.recording.schemas import SHOE_VOLTAGES_TYPE, schema_text
from shoecal_core.recording.session import Session
from shoecal_core.robot.robot_file import load_robot
from shoecal_core.shoe.shoe_file import load_shoe

ROBOT, SHOE = ROOT / "config/robots/nao.yaml", ROOT / "config/shoes/nao_shoe.yaml"
COUNT, STEP_S = 120, 0.02
HEADER = "std_msgs/Header header\n"
CORNERS = ("front_left", "front_right", "rear_left", "rear_right")


class Recording:
    """A bag of a NAO that stands, written as its own drivers would."""

    def __init__(self, folder: Path, types: Mapping[str, str]) -> None:
        self.bag = bags.BagWriter(folder, "bag", "mcap")
        for kind, definition in types.items():
            self.bag.store.register(get_types_from_msg(definition, kind))
        self.shoe = load_shoe(SHOE)
        self.robot = load_robot(ROBOT, self.shoe)

    def value(self, cell: str, time: float) -> float:
        """Of a cell at a time: each has its own."""
        return 0.1 * self.shoe.names.index(cell) + 0.01 * math.sin(time)

    def joint_states(self) -> None:
        names = [*self.robot.joint_names]
        angles = [posture(joint) for joint in names]
        for time in times():
            self.bag.joints(time, names, angles)

    def voltages(self, time: float, cell: str) -> None:
        """One reading, in the message of the project's own."""
        message = self.bag.make(
            SHOE_VOLTAGES_TYPE,
            header=self.bag.header(time),
            sequence=0,
            cell=[cell],
            voltage=np.ones(1),
            status=np.zeros(1, dtype=np.uint8),
            temperature=math.nan,
        )
        self.bag.add(time, "/shoe/voltages", message)

    def numbers(self, topic: str, kind: str, fields: Sequence[str], cells: Sequence[str]) -> None:
        """One field a cell, stamped."""
        for time in times():
            values = {
                field: self.value(cell, time) for field, cell in zip(fields, cells, strict=True)
            }
            self.bag.add(time, topic, self.bag.make(kind, header=self.bag.header(time), **values))

    def imported(self, folder: Path) -> Session:
        """Drafted and imported with nothing edited."""
        path = self.bag.close()
        draft = draft_mapping([path], self.robot, self.shoe)
        mapping = folder / "mapping.yaml"
        mapping.write_text(mapping_text(draft, folder, ROBOT, self.robot.urdf, SHOE))
        return import_bags(mapping, folder, folder / "session")

    def assert_arrived(self, session: Session) -> None:
        """All readings by their cells."""
        readings = session.read(1).readings
        assert readings.names == self.shoe.names
        for column, cell in enumerate(self.shoe.names):
            expected = [self.value(cell, time) for time in times()]
            found = readings.value[:, column]
            np.testing.assert_allclose(found[~np.isnan(found)], expected, atol=1e-6)


def times() -> list[float]:
    return [STEP_S * step for step in range(COUNT)]


def posture(joint: str) -> float:
    return float(POSTURE.get(joint, 0.0))


POSTURE = {
    str(name): float(value)
    for name, value in read_yaml(ROBOT).value("posture_rad").items()  # type: ignore[attr-defined]
}
FOUR = HEADER + "".join(
    f"float64 {name}\n" for name in ("left_front", "left_back", "right_front", "right_back")
)
EIGHT = HEADER + "".join(
    f"float32 {side}_foot_{place}\n"
    for side in "lr"
    for place in ("front_left", "front_right", "back_left", "back_right")
)


def test_fields_named_by_corner_on_a_topic_a_foot(tmp_path: Path) -> None:
    kind = "team_msgs/msg/FootPressure"
    recording = Recording(tmp_path, {kind: FOUR})
    recording.joint_states()
    for side in ("left", "right"):
        cells = [
            f"{side}/{place}" for place in ("front_left", "rear_left", "front_right", "rear_right")
        ]
        fields = ("left_front", "left_back", "right_front", "right_back")
        recording.numbers(f"/foot_pressure_{side}/raw", kind, fields, cells)
    recording.assert_arrived(recording.imported(tmp_path))


def test_a_message_of_all_cells_and_joints_by_their_order(tmp_path: Path) -> None:
    """As a NAO's own interface sends them: without names, without stamps."""
    readings = "team_msgs/msg/Fsr"
    recording = Recording(
        tmp_path,
        {readings: EIGHT.replace(HEADER, ""), LOLA_POSITIONS: "float32[25] positions\n"},
    )
    fields = [f"{side}_foot_{place.replace('rear', 'back')}" for side in "lr" for place in CORNERS]
    cells = [f"{side}/{place}" for side in ("left", "right") for place in CORNERS]
    angles = np.array([posture(joint) for joint in LOLA_JOINTS], dtype=np.float32)
    make = recording.bag.make
    for time in times():
        values = {
            field: recording.value(cell, time) for field, cell in zip(fields, cells, strict=True)
        }
        recording.bag.add(time, "/sensors/fsr", make(readings, **values))
        recording.bag.add(time, "/sensors/joints", make(LOLA_POSITIONS, positions=angles))
    session = recording.imported(tmp_path)
    recording.assert_arrived(session)
    joints = session.read(1).joints
    for joint in LOLA_JOINTS:
        if joint in joints.names:
            found = joints.position[:, joints.names.index(joint)]
            np.testing.assert_allclose(found, posture(joint), atol=1e-6)


def test_an_array_is_taken_in_the_order_of_the_shoe_file_and_that_is_to_be_checked(
    tmp_path: Path,
) -> None:
    recording = Recording(tmp_path, {})
    recording.joint_states()
    make = recording.bag.make
    layout = make("std_msgs/msg/MultiArrayLayout", dim=[], data_offset=0)
    for time in times():
        data = np.array([recording.value(cell, time) for cell in recording.shoe.names], np.float32)
        message = make("std_msgs/msg/Float32MultiArray", layout=layout, data=data)
        recording.bag.add(time, "/load_cells", message)
    recording.assert_arrived(recording.imported(tmp_path))
    text = (tmp_path / "mapping.yaml").read_text()
    assert "# CHECK: /load_cells: its numbers have no names" in text


INTERFACES = "control_msgs/msg/InterfaceValue"
CONTROL = {
    INTERFACES: "string[] interface_names\nfloat64[] values\n",
    "control_msgs/msg/DynamicJointState": HEADER
    + "string[] joint_names\ncontrol_msgs/InterfaceValue[] interface_values\n",
    "control_msgs/msg/JointTrajectoryControllerState": HEADER
    + "string[] joint_names\n"
    + "".join(
        f"trajectory_msgs/JointTrajectoryPoint {part}\n" for part in ("reference", "feedback")
    ),
}


def controller_state(recording: Recording, kind: str, time: float) -> object:
    """What a controller of ros2_control reports of joints; what it commands is 0.1 rad off."""
    make, names = recording.bag.make, recording.robot.joint_names
    angles = np.array([posture(joint) for joint in names])
    head = {"header": recording.bag.header(time), "joint_names": list(names)}
    if kind.endswith("DynamicJointState"):
        listed = [
            make(INTERFACES, interface_names=["effort", "position"], values=np.array([3.0, angle]))
            for angle in angles
        ]
        return make(kind, **head, interface_values=listed)
    none, start = np.zeros(0), make("builtin_interfaces/msg/Duration", sec=0, nanosec=0)
    reference, feedback = (
        make(
            "trajectory_msgs/msg/JointTrajectoryPoint",
            positions=angles + off,
            velocities=none,
            accelerations=none,
            effort=none,
            time_from_start=start,
        )
        for off in (0.1, 0.0)
    )
    return make(kind, **head, reference=reference, feedback=feedback)


@pytest.mark.parametrize("kind", sorted(set(CONTROL) - {INTERFACES}))
def test_what_controllers_measured(tmp_path: Path, kind: str) -> None:
    """Joint angles by the names that messages list; cells by those of a joint state's efforts."""
    recording = Recording(tmp_path, CONTROL)
    cells = [name.replace("/", "_") for name in recording.shoe.names]
    for time in times():
        efforts = [recording.value(cell, time) for cell in recording.shoe.names]
        recording.bag.add(time, "/fsr", recording.bag.joint_state(time, cells, [], efforts))
        recording.bag.add(time, "/state", controller_state(recording, kind, time))
    session = recording.imported(tmp_path)
    recording.assert_arrived(session)
    joints = session.read(1).joints
    expected = [posture(joint) for joint in joints.names]
    assert set(joints.names) == set(recording.robot.joint_names)
    np.testing.assert_allclose(joints.position, np.tile(expected, (len(joints.time), 1)))


def test_joints_of_another_robot_are_not_taken_in_their_order(tmp_path: Path) -> None:
    recording = Recording(tmp_path, {})
    names = [f"motor_{at}" for at, _ in enumerate(recording.robot.joint_names)]
    for time in times():
        recording.bag.joints(time, names)
    with pytest.raises(FileError, match=r"names motor_0, motor_1.*; check --robot, or write in"):
        recording.imported(tmp_path)


def arrays(recording: Recording, feet: Mapping[str, int]) -> None:
    """An array a topic, of so many of the foot's cells."""
    make = recording.bag.make
    layout = make("std_msgs/msg/MultiArrayLayout", dim=[], data_offset=0)
    for time in times():
        for foot, count in feet.items():
            cells = [name for name in recording.shoe.names if name.startswith(foot)][:count]
            data = np.array([recording.value(cell, time) for cell in cells])
            message = make("std_msgs/msg/Float64MultiArray", layout=layout, data=data)
            recording.bag.add(time, f"/{foot}_foot/cells", message)


def test_an_array_a_foot(tmp_path: Path) -> None:
    recording = Recording(tmp_path, {})
    recording.joint_states()
    arrays(recording, {"right": 4, "left": 4})
    recording.assert_arrived(recording.imported(tmp_path))
    text = (tmp_path / "mapping.yaml").read_text()
    assert "# CHECK: /left_foot/cells: its numbers have no names" in text
    assert "# CHECK: /left_foot/cells: its messages have no stamps" in text


@pytest.mark.parametrize("feet", [{"right": 4}, {"right": 3, "left": 4}])
def test_arrays_that_lack_cells_are_not_guessed(tmp_path: Path, feet: Mapping[str, int]) -> None:
    recording = Recording(tmp_path, {})
    recording.joint_states()
    arrays(recording, feet)
    with pytest.raises(FileError, match=r"has no topic that fits 'nao_shoe'.*which field is which"):
        recording.imported(tmp_path)


def test_why_no_topic_fits(tmp_path: Path) -> None:
    """Another kind of sensor, other cells: the shoe file is another one's; or a wrench a cell."""
    other = r".*name the shoe that was recorded \(--shoe\)"
    for name, told in (
        ("wrenches", f"six-axis sensors{other}"),
        ("voltages", f"names left/toe{other}"),
        ("cells", r"where each is a cell, write that in the mapping .*wrench\.force\.z"),
    ):
        folder = tmp_path / name
        folder.mkdir()
        text = schema_text(SHOE_VOLTAGES_TYPE).decode().split("=====", maxsplit=1)[0]
        recording = Recording(folder, {SHOE_VOLTAGES_TYPE: text})
        recording.joint_states()
        for time in times():
            if name == "wrenches":
                recording.bag.feet(time)
            elif name == "cells":
                recording.bag.feet(time, ("left_toe", "left_heel", "right_toe", "right_heel"))
            else:
                recording.voltages(time, "left/toe")
        with pytest.raises(FileError, match=told):
            recording.imported(folder)


@pytest.mark.parametrize(
    ("cells", "problem"),
    [
        ({"/load_cells": {"data[9]": "left/front_left"}}, r"have no number 'data\[9\]'; there are"),
        ({"/load_cells": {"datum": "left/front_left"}}, "have no number 'datum'; there are"),
        ({"/load_cells": {"layout.data_offset": "left/front_left"}}, "have no number 'layout"),
        ({"/load_cells": {"data[0][0]": "left/front_left"}}, r"have no number 'data\[0\]\[0\]'"),
        (
            {"/load_cells": {"data[0]": "left/front_left", "data[1]": "left/front_left"}},
            "'left/front_left' is given by two fields",
        ),
        ({"/load_cells": {"data[0]": "left/toe"}}, "'left/toe' is no channel of 'nao_shoe'"),
        ({"/load_cells": {}}, "names no field"),
        ({"/cells": {"data[0]": "left/front_left"}}, "'/cells' is missing in"),
    ],
)
def test_a_wrong_field_is_one_line(tmp_path: Path, cells: object, problem: str) -> None:
    test_an_array_is_taken_in_the_order_of_the_shoe_file_and_that_is_to_be_checked(tmp_path)
    mapping = tmp_path / "mapping.yaml"
    fields = read_yaml(mapping)
    values = {key: fields.value(key) for key in fields.keys()} | {"cells": cells}
    if "/cells" in str(cells):
        values.pop("received")
    write_yaml(mapping, values)
    with pytest.raises(FileError, match=problem):
        import_bags(mapping, tmp_path, tmp_path / "again")


@pytest.mark.parametrize(("text", "number"), [(" 0.512", 0.512), ("-3", -3.0), ("OK", None)])
def test_numbers_written_as_text_are_numbers(text: str, number: float | None) -> None:
    """As a status lists its values: `diagnostic_msgs/DiagnosticArray`."""
    status = SimpleNamespace(values=[SimpleNamespace(key="load", value=text)])
    message = SimpleNamespace(status=[status])
    if number is None:
        with pytest.raises(LookupError, match=r"status\[0\].values\[0\].value"):
            number_at(message, "status[0].values[0].value")
    else:
        assert number_at(message, "status[0].values[0].value") == number


def test_topics_that_fit_nothing_are_listed(tmp_path: Path) -> None:
    recording = Recording(tmp_path, {"team_msgs/msg/Odd": "float64 speed\n"})
    recording.joint_states()
    recording.bag.add(0.0, "/odd", recording.bag.make("team_msgs/msg/Odd", speed=1.0))
    with pytest.raises(FileError, match=r"it holds .*/odd \(team_msgs/msg/Odd, 1 messages\)"):
        recording.imported(tmp_path)


def test_one_message_holds_joints_and_cells(tmp_path: Path) -> None:
    kind, names = "team_msgs/msg/All", load_robot(ROBOT, load_shoe(SHOE)).joint_names
    cells = [f"{side}/{place}" for side in ("left", "right") for place in CORNERS]
    fields = [cell.replace("/", "_") for cell in cells]
    joints = "".join(f"float64 {name.lower()}\n" for name in names)
    recording = Recording(
        tmp_path, {kind: HEADER + joints + "".join(f"float64 {field}\n" for field in fields)}
    )
    for time in times():
        angles = {name.lower(): posture(name) for name in names}
        readings = {f: recording.value(cell, time) for f, cell in zip(fields, cells, strict=True)}
        values = {"header": recording.bag.header(time), **angles, **readings}
        recording.bag.add(time, "/all", recording.bag.make(kind, **values))
    session = recording.imported(tmp_path)
    recording.assert_arrived(session)
    assert set(session.read(1).joints.names) == set(names)


@pytest.mark.parametrize("format_", ["mcap", "sqlite3"])
@pytest.mark.parametrize("header", ["uint32 header", "std_msgs/Header header", "float64 header"])
def test_what_the_bag_does_not_define_is_named(tmp_path: Path, format_: str, header: str) -> None:
    """As recorders write messages whose package is not installed; and headers of another kind."""
    kind = "team_msgs/msg/Fsr"
    recording = Recording(tmp_path, {})
    recording.bag = bags.BagWriter(tmp_path, "bag", format_)
    recording.bag.store.register(get_types_from_msg(f"{header}\nfloat64[8] data\n", kind))
    recording.joint_states()
    for time in times():
        own = recording.bag.header(time) if "Header" in header else 1
        message = recording.bag.make(kind, header=own, data=np.arange(8.0))
        recording.bag.add(time, "/fsr", message)
    session = recording.imported(tmp_path)
    np.testing.assert_allclose(np.nanmax(session.read(1).readings.value, axis=0), np.arange(8.0))
    _without_definitions(tmp_path / "bag", "team_msgs")
    with pytest.raises(FileError, match=r"/fsr \(.* messages, without definition\)"):
        draft_mapping([tmp_path / "bag"], recording.robot, recording.shoe)
    with pytest.raises(FileError, match=f"/fsr is of {kind}, which the bag does not define"):
        import_bags(tmp_path / "mapping.yaml", tmp_path, tmp_path / "again")


def _without_definitions(folder: Path, package: str) -> None:
    """Take a package's definitions out of a bag."""
    for database in folder.glob("*.db3"):
        with closing(sqlite3.connect(database)) as connection, connection:
            connection.execute("DELETE FROM message_definitions")
    for path in folder.glob("*.mcap"):
        bags.rewritten(path, path, undefined=package)


def test_a_joint_by_a_field_and_by_a_topic_is_refused(tmp_path: Path) -> None:
    test_an_array_is_taken_in_the_order_of_the_shoe_file_and_that_is_to_be_checked(tmp_path)
    mapping = tmp_path / "mapping.yaml"
    fields = read_yaml(mapping)
    values = {key: fields.value(key) for key in fields.keys()}
    joints = {"topics": ["/joint_states"], "/load_cells": {"data[0]": "HeadYaw"}}
    write_yaml(mapping, values | {"joints": joints})
    with pytest.raises(FileError, match="'HeadYaw' is given by a field and by /joint_states"):
        import_bags(mapping, tmp_path, tmp_path / "again")
    write_yaml(mapping, values | {"imu": {"topic": "/load_cells"}})
    with pytest.raises(FileError, match=r"imu\.topic: '/load_cells' is std_msgs"):
        import_bags(mapping, tmp_path, tmp_path / "again")


@given(st.permutations(range(4)), st.sampled_from(["{0}/{1}", "{1}_{0}", "cell_{0}_{1}.value"]))
def test_words_name_cells_in_any_order(order: list[int], form: str) -> None:
    cells = tuple(f"{side}/{place}" for side in ("left", "right") for place in CORNERS)
    paths = [form.format(*CORNERS[at].split("_")).replace("/", "_") for at in order]
    found = cells_by_words("/left_foot", paths, cells)
    assert found == {path: f"left/{CORNERS[at]}" for path, at in zip(paths, order, strict=True)}
    assert cells_by_words("/imu", ["x", "y"], cells) == {}
