"""URDFs whose masses or lengths contradict each other, each made of a robot that is known."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest

from core.drafting.drafts import ROBOTS, draft, edited
from shoecal_core.drafting.draft import draft_robot
from shoecal_core.drafting.notes import robot_notes
from shoecal_core.errors import FileError
from shoecal_core.robot.plausible_links import Link, check_links, read_links
from shoecal_core.robot.robot_file import load_robot

FRAME = """<link name="{0}"><inertial><mass value="{1}"/><inertia ixx="0.001" ixy="0" ixz="0"
    iyy="0.001" iyz="0" izz="0.001"/></inertial></link><joint name="{0}_mount" type="fixed">
    <parent link="torso"/><child link="{0}"/></joint>"""


def scaled(folder: Path, what: str, factor: float) -> Path:
    """The known robot with all attributes of one pattern multiplied."""

    def times(found: re.Match[str]) -> str:
        values = " ".join(str(factor * float(one)) for one in found.group(2).split())
        return f"{found.group(1)}{values}{found.group(3)}"

    text = (ROBOTS / "wren.urdf").read_text()
    text, count = re.subn(what, times, text)
    assert count
    file = folder / "wren.urdf"
    file.write_text(text)
    return file


def with_frames(folder: Path, *frames: tuple[str, float]) -> Path:
    """The known robot with links that have mass and no shape."""
    text = (ROBOTS / "wren.urdf").read_text()
    parent = re.search(r'<link name="([^"]*)"', text)
    assert parent is not None
    more = "".join(FRAME.format(*one) for one in frames).replace("torso", parent.group(1))
    file = folder / "wren.urdf"
    file.write_text(text.replace("</robot>", f"{more}</robot>"))
    return file


@pytest.mark.parametrize(
    ("what", "factor", "said"),
    [
        (r'(<mass value=")([^"]*)(")', 1e3, r"kg on legs of .* m: are the masses in g\?"),
        (r'(<mass value=")([^"]*)(")', 1e-3, r"kg on legs of .* m: are the masses in t\?"),
        (r'(xyz=")([^"]*)(")', 1e3, r"the legs are .* m long: are the lengths in mm\?"),
        (r'(xyz=")([^"]*)(")', 1e2, r"the legs are .* m long: are the lengths in cm\?"),
    ],
)
def test_wrong_units_are_named(tmp_path: Path, what: str, factor: float, said: str) -> None:
    with pytest.raises(FileError, match=said):
        draft_robot(scaled(tmp_path, what, factor), "wren")


@pytest.mark.parametrize("names", [("imu",), ("imu", "camera")])
def test_frames_with_the_mass_of_the_whole_robot_are_named(
    tmp_path: Path, names: tuple[str, ...]
) -> None:
    whole = draft("wren").mass
    file = with_frames(tmp_path, *((name, whole) for name in names))
    with pytest.raises(FileError, match=f"{', '.join(names)}: no shape, and .* whole robot"):
        draft_robot(file, "wren")


def test_heavy_frames_are_to_be_checked_and_light_ones_are_not(tmp_path: Path) -> None:
    whole = draft("wren").mass
    found = robot_notes(draft_robot(with_frames(tmp_path, ("imu", 0.7 * whole)), "wren"))
    assert any(note.found.startswith("imu has no shape and") for note in found)
    light = robot_notes(draft_robot(with_frames(tmp_path, ("imu", 0.05 * whole)), "wren"))
    assert len(light) == len(robot_notes(draft("wren"))) == len(found) - 1


def test_legs_of_unlike_masses_are_to_be_checked(tmp_path: Path) -> None:
    """One link's mass was written in another unit."""
    text = (ROBOTS / "wren.urdf").read_text()
    start = text.index('<link name="left_thigh">')
    at = text.index('<mass value="', start) + len('<mass value="')
    end = text.index('"', at)
    file, mass = tmp_path / "wren.urdf", float(text[at:end])
    file.write_text(f"{text[:at]}{10.0 * mass}{text[end:]}")
    found = [note.found for note in robot_notes(draft_robot(file, "wren"))]
    said = f"left_thigh and right_thigh are {10.0 * mass:.3g} and {mass:.3g} kg"
    assert any(one.startswith(said) for one in found)


def with_inertial(folder: Path, link: str, what: str, factor: float) -> Path:
    """The known robot with an attribute of one link's inertial multiplied."""
    text = (ROBOTS / "wren.urdf").read_text()
    start = text.index(f'<link name="{link}">')
    end = text.index("</inertial>", start)
    file = folder / "wren.urdf"
    edited, count = re.subn(
        rf'({what}=")([^"]*)',
        lambda found: (
            found.group(1) + " ".join(str(factor * float(one)) for one in found.group(2).split())
        ),
        text[start:end],
    )
    assert count
    file.write_text(text[:start] + edited + text[end:])
    return file


@pytest.mark.parametrize(
    ("what", "said"),
    [
        ("mass value", r"kg of them in link left_shank: is it in g\?"),
        ("xyz", r"the CoM of link left_shank is .* m from .*in mm\?"),
    ],
)
def test_a_link_in_another_unit_is_named(tmp_path: Path, what: str, said: str) -> None:
    with pytest.raises(FileError, match=said):
        draft_robot(with_inertial(tmp_path, "left_shank", what, 1e3), "wren")


@pytest.mark.parametrize(
    ("what", "factor", "said"),
    [
        ("ixx", -1.0, "no body has a moment of inertia below zero, as link left_shank would."),
        ("i(?:xx|yy|zz)", 1e6, "the inertia of link left_shank is that of a larger body"),
    ],
)
def test_a_body_that_cannot_be_is_to_be_checked(
    tmp_path: Path, what: str, factor: float, said: str
) -> None:
    found = robot_notes(draft_robot(with_inertial(tmp_path, "left_shank", what, factor), "wren"))
    assert any(note.found.startswith(said) for note in found)


def test_masses_by_default_are_to_be_checked(tmp_path: Path) -> None:
    text = re.sub(r'(<mass value=")[^"]*', r"\g<1>1.0", (ROBOTS / "wren.urdf").read_text())
    (tmp_path / "wren.urdf").write_text(text)
    found = robot_notes(draft_robot(tmp_path / "wren.urdf", "wren"))
    assert any("links have 1 kg each" in note.found for note in found)


def with_origin(folder: Path, joint: str, step: str) -> Path:
    """The known robot with another <origin> of one joint."""
    return edited(
        folder, "wren", rf'(<joint name="{joint}".*?<origin xyz=")[^"]*', rf"\g<1>{step}", 1
    )


@pytest.mark.parametrize(
    ("step", "said"),
    [
        ("0 0.108 0", "left_ankle_swing is 96 mm from left_knee, right_ankle_swing 108 mm from"),
        ("0 0.096 -0.012", "left_ankle_swing is 96 mm from left_knee, right_ankle_swing 97 mm"),
    ],
)
def test_a_link_that_is_unlike_that_of_the_other_leg(tmp_path: Path, step: str, said: str) -> None:
    """Longer, or bent to the side; a robot file that names this URDF is refused as well."""
    urdf = with_origin(tmp_path, "right_ankle_swing", step)
    with pytest.raises(FileError, match="the legs are no mirror images") as drafted:
        draft_robot(urdf, "wren")
    assert said in str(drafted.value)
    assert "12 mm off its mirror image; measure both" in str(drafted.value)
    with pytest.raises(FileError, match="the legs are no mirror images"):
        load_robot(ROBOTS / "wren.yaml", urdf=urdf)


def test_coms_in_another_unit_are_named_where_the_robot_is_loaded(tmp_path: Path) -> None:
    urdf = with_inertial(tmp_path, "left_shank", "xyz", 1e3)
    with pytest.raises(FileError, match=r"the CoM of link left_shank is .* m from .*in mm\?"):
        load_robot(ROBOTS / "wren.yaml", urdf=urdf)


def test_a_body_without_mass_is_to_be_checked(tmp_path: Path) -> None:
    urdf = with_inertial(tmp_path, "body", "mass value", 0.0)
    found = [note.found for note in robot_notes(draft_robot(urdf, "wren"))]
    assert "link body has a shape and no mass." in found
    assert not any("no mass" in note.found for note in robot_notes(draft("wren")))


def test_a_model_without_shapes_may_have_a_trunk_of_half_its_mass() -> None:
    masses = {"trunk": 2.0, "left": 1.0, "right": 1.0}
    links = [
        Link(name, shaped=False, mass=mass, com=np.zeros(3), inertia=np.eye(3))
        for name, mass in masses.items()
    ]
    check_links(Path("robot.urdf"), links, 0.4)
    drawn = replace(links[1], shaped=True)
    with pytest.raises(FileError, match="trunk: no shape, and 2 kg, as much as all other links"):
        check_links(Path("robot.urdf"), [links[0], drawn, links[2]], 0.4)


@pytest.mark.parametrize("broken", ['value="{}"', "", 'value="1,5"'])
def test_a_link_whose_mass_is_no_number_has_none(broken: str) -> None:
    """As in the parser of URDFs, whose reader says so; nothing ends in a traceback."""
    inertial = '<inertial><mass {}/><origin xyz="0 0 0.1"/></inertial>'
    robot = "".join(
        f'<link name="{name}">{inertial.format(mass)}</link>'
        for name, mass in (("trunk", 'value="2.0"'), ("shank", broken))
    )
    root = ElementTree.fromstring(f"<robot>{robot}</robot>")
    assert [link.name for link in read_links(root)] == ["trunk"]
