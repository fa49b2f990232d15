"""Files of another kind and mistyped keys are told as what they are."""

from __future__ import annotations

from pathlib import Path

import pytest

from core.recording import samples
from core.shoe.shoes import FILES, ROOT
from shoecal_core.errors import FileError
from shoecal_core.estimation.calibration import load_calibration
from shoecal_core.files import Fields, read_yaml
from shoecal_core.parameter_file import load_settings
from shoecal_core.planning.settings import PlannerSettings
from shoecal_core.recording.container import read_container
from shoecal_core.recording.imports.bag_mapping import load_bag_mapping
from shoecal_core.recording.imports.csv_mapping import load_csv_mapping
from shoecal_core.recording.recover import recover
from shoecal_core.recording.session import Session
from shoecal_core.robot.robot_file import load_robot, shoe_file_of
from shoecal_core.robot.urdf import read_urdf
from shoecal_core.shoe.shoe_file import load_shoe

ROBOT = ROOT / "config/robots/nao.yaml"
SHOE = FILES["nao_shoe"]
PLANNER = ROOT / "config/nodes/planner.yaml"
TABLES = ROOT / "config/imports/reemc.yaml"


def planning(path: Path) -> PlannerSettings:
    """Settings of a parameter file."""
    return load_settings(PlannerSettings, path, "planner", "planning")


@pytest.mark.parametrize(
    ("read", "file", "kind"),
    [
        (load_robot, SHOE, "is a shoe file, by its keys; name a robot file here"),
        (load_robot, PLANNER, "is a parameter file of nodes, by its keys; name the"),
        (shoe_file_of, SHOE, "is a shoe file, by its keys; name a robot file here"),
        (planning, SHOE, r"is a shoe file, by its keys; name a parameter file of nodes here"),
        (load_shoe, ROBOT, "is a robot file"),
        (load_calibration, ROBOT, "is a robot file"),
        (read_urdf, ROBOT, "is a robot file, by its keys; name a URDF here"),
        (load_calibration, SHOE, "is a shoe file"),
        (lambda path: load_bag_mapping(path, ROOT), TABLES, "is a mapping of tables"),
        (lambda path: load_csv_mapping(path, ROOT), ROBOT, "is a robot file"),
    ],
)  # fmt: skip
def test_a_file_of_another_kind_is_named(read, file: Path, kind: str) -> None:  # type: ignore[no-untyped-def]
    with pytest.raises(FileError, match=kind):
        read(file)


@pytest.mark.parametrize(
    ("content", "told"),
    [
        ("", "is empty"),
        ("\n \n", "is empty"),
        ('<?xml version="1.0"?>\n<robot name="a"/>', "is a URDF; draft a robot file"),
        ('<robot xmlns:xacro="x"><xacro:leg/></robot>', "is xacro: make a URDF of it"),
        ('<robot name="a"><mass value="${m}"/></robot>', "is xacro: make a URDF of it"),
        ('<robot xmlns:xacro="x"/><!-- of <xacro:leg> -->', "is a URDF; draft a robot file"),
        ("a:\n\tb: 1", "line 2 (found character '\\t' that cannot start any token); indent with"),
        ("a: [1", "correct it there"),
        ("time,left,right\n1,2,3", "is a table (CSV), no YAML file; name the file of keys and"),
        ("just a text", "expected a mapping of keys to values"),
    ],
)
def test_what_is_no_yaml(content: str, told: str, tmp_path: Path) -> None:
    file = tmp_path / "some.yaml"
    file.write_text(content)
    with pytest.raises(FileError) as caught:
        read_yaml(file)
    assert told in str(caught.value)


def test_mistyped_keys() -> None:
    fields = Fields(Path("a.yaml"), "", {"wieght": 1})
    with pytest.raises(FileError, match="wieght: unknown key; did you mean 'weight'\\?"):
        fields.only("name", "weight")
    with pytest.raises(FileError, match="unknown key; known: name, legs"):
        fields.only("name", "legs")


def read_mass(file: Path) -> float:
    weight = read_yaml(file).mapping("weight")
    weight.only("mass_kg", "std_kg")
    return weight.number("mass_kg")


def test_decimal_commas(tmp_path: Path) -> None:
    """YAML reads them as two things in a row, or as a text."""
    for text in ("weight: {mass_kg: 5,305, std_kg: 0.03}", "weight: {mass_kg: '5,305'}"):
        file = tmp_path / "robot.yaml"
        file.write_text(text)
        with pytest.raises(FileError, match="write a decimal point, not a comma"):
            read_mass(file)


@pytest.mark.parametrize(
    ("content", "told"),
    [
        (b"a text file", "is no MCAP file"),
        (b"\x28\xb5\x2f\xfd" + bytes(20), "is compressed as a whole: unpack it"),
        (b"PK\x03\x04" + bytes(20), "is compressed as a whole: unpack it"),
    ],
)
def test_runs_that_are_none(content: bytes, told: str, tmp_path: Path) -> None:
    file = tmp_path / "run_001.mcap"
    file.write_bytes(content)
    with pytest.raises(FileError, match=told):
        read_container(file, {})
    with pytest.raises(FileError, match="is no MCAP file, or its record"):
        recover(file, tmp_path / "out.mcap")


def test_a_run_in_place_of_its_session(tmp_path: Path) -> None:
    file = samples.write_run(tmp_path / "run_001.mcap", samples.make_sample(60, 2), ("a", "b"))
    with pytest.raises(FileError, match=r"is a file; name a session's folder$"):
        Session.open(file)
    (tmp_path / "session.yaml").write_text("format: 1")
    with pytest.raises(FileError, match=f"its session is {tmp_path}"):
        Session.open(file)


def test_feet_exchanged(tmp_path: Path) -> None:
    robot = read_yaml(ROBOT)
    text = ROBOT.read_text()
    left, right = (robot.mapping("feet").mapping(foot).text("link") for foot in ("left", "right"))
    for link, other in ((left, "@"), (right, left), ("@", right)):
        text = text.replace(f"link: {link}", f"link: {other}")
    (tmp_path / "nao.yaml").write_text(text)
    urdf = robot.text("urdf")
    (tmp_path / urdf).write_bytes((ROBOT.parent / urdf).read_bytes())
    with pytest.raises(FileError, match="left and right are exchanged"):
        load_robot(tmp_path / "nao.yaml")


def test_xacro_far_down_is_named_too(tmp_path: Path) -> None:
    file = tmp_path / "some.urdf"
    links = "".join(f'<link name="link_{index}"/>' for index in range(500))
    file.write_text(f'<robot name="a">{links}<joint name="${{side}}_knee"/></robot>')
    with pytest.raises(FileError, match="is xacro: make a URDF of it"):
        read_urdf(file)


def test_a_urdf_that_is_elsewhere(tmp_path: Path) -> None:
    robot = tmp_path / "robots" / "nao.yaml"
    robot.parent.mkdir()
    robot.write_text(ROBOT.read_text().replace("urdf: nao.urdf", "urdf: ../nao.urdf"))
    where = tmp_path / "nao.urdf"
    with pytest.raises(FileError, match=rf"nao\.yaml: urdf: there is no URDF at {where}; give its"):
        load_robot(robot)
    robot.with_suffix(".urdf").touch()
    with pytest.raises(FileError, match=r"did you mean 'nao\.urdf'\? give its path as seen from"):
        load_robot(robot)


def test_a_posture_in_degrees(tmp_path: Path) -> None:
    robot = tmp_path / "nao.yaml"
    robot.with_suffix(".urdf").write_bytes(ROBOT.with_suffix(".urdf").read_bytes())
    robot.write_text(ROBOT.read_text().replace("LKneePitch: 0.80", "LKneePitch: 46"))
    with pytest.raises(
        FileError, match=r"posture_rad\.LKneePitch: .*; give rad, not deg.*: 0\.803"
    ):
        load_robot(robot)
    robot.write_text(ROBOT.read_text().replace("LKneePitch: 0.80", "LKneePitch: 2.5"))
    with pytest.raises(FileError, match=r"posture_rad\.LKneePitch: .* to 2\.11255 rad$"):
        load_robot(robot)


def test_a_folder_that_holds_sessions(tmp_path: Path) -> None:
    for name in ("a", "b"):
        made = tmp_path / name
        Session.create(made, ROBOT, ROBOT.with_suffix(".urdf"), SHOE)
        held = "name the one that it holds: .*a$" if name == "a" else "one that it holds: .*a, .*b$"
        with pytest.raises(
            FileError, match=rf"is no session \(it has no session\.yaml\); .*{held}"
        ):
            Session.open(tmp_path)
