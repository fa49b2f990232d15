"""Reading a URDF into a Pinocchio model on a free-flying base, and refusing half of one.

The URDF parser drops an inertial that it cannot read, and links that hang on nothing, with no
more than lines on stderr. The CoM would be wrong, so the masses are counted again here, and what
is wrong is reported in one line instead of the parser's many.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree
from xml.parsers import expat

import numpy as np
import pinocchio as pin

from shoecal_core.arrays import FloatArray
from shoecal_core.errors import FileError, FileSyntaxError
from shoecal_core.file_kinds import XACRO, is_mjcf, is_xacro
from shoecal_core.files import file_kind, read_bytes
from shoecal_core.robot.native_output import caught_stderr
from shoecal_core.robot.symbolic import joint_axis

ROOT_JOINTS = 2
"""Pinocchio's universe and free-flyer stand before the robot's own joints."""
MAX_MASS = 1e4
"""kg; no link of a robot weighs more."""
MAX_INERTIA = 1e6
"""kg m^2, likewise."""
MAX_DISTANCE = 1e3
"""m; no part of a robot is farther from the next."""
DEGREES_FROM = 10.0
"""rad; no part is turned by more against the next, so angles from here on are degrees."""
MAX_DEPTH = 100
"""Elements within each other; a URDF has five, what extends it some more. Trees are walked by
recursion."""
NAMED = 5
"""Links that an error names."""
_PARTS = (["robot", "link"], ["robot", "joint"])


@dataclass(frozen=True)
class Mimic:
    """What a URDF says of a joint that another one's motor turns.

    Attributes:
        leader: name of that other joint.
        multiplier, offset: angle = multiplier * leader's angle + offset [rad].
    """

    leader: str
    multiplier: float
    offset: float


@dataclass(frozen=True)
class Urdf:
    """A URDF that was understood whole.

    Attributes:
        model: on a free-flying base; joints that mimic are joints like all others there.
        mimics: by the name of the joint that follows.
        locked: names of joints whose limits are one angle; they are fixed at it.
    """

    model: pin.Model
    mimics: Mapping[str, Mimic]
    locked: tuple[str, ...]


class UrdfError(FileError):
    """A URDF that no robot can be made of: what is missing, contradicts or is not understood."""


def read_urdf(path: Path) -> Urdf:
    """Model of a URDF on a free-flying base, masses as they stand there.

    Raises:
        UrdfError: for anything that is not understood whole.
        FileSyntaxError: for a file that is no XML.
    """
    text = read_bytes(path).decode("utf-8", errors="replace")
    _check_kind(path, text)
    reader = _Reader(path, text)
    declared = sum(reader.masses.values())
    if declared > 0.0 and reader.unweighed:
        raise UrdfError(
            path,
            f"no <mass> in the <inertial> of {name_links(reader.unweighed)}; give it in kg, or "
            "leave the <inertial> out of a link without mass",
            field="inertial",
        )
    try:
        with caught_stderr() as complaints:
            moving = _bounded(with_joints_plain(text))
            model = pin.buildModelFromXML(moving, pin.JointModelFreeFlyer())
    except (ValueError, RuntimeError, IndexError) as error:
        raise UrdfError(path, f"not a usable URDF: {_reason(complaints, error)}") from error
    understood = sum(inertia.mass for inertia in model.inertias)
    if abs(understood - declared) > 1e-9 * declared:
        raise UrdfError(
            path,
            f"only {understood:g} of the links' {declared:g} kg are understood; check every "
            f"link's inertial, and that every link hangs on the base{_lost(reader, model)}",
            field="inertial",
        )
    if not declared > 0.0:
        missing = f" ({name_links(reader.unweighed)})" if reader.unweighed else ""
        raise UrdfError(path, f"no link has a mass{missing}; the CoM needs them", field="inertial")
    _check_joints(path, model)
    # What does not turn does not follow either; exporters leave its <mimic> where they fix a joint.
    mimics = {one: mimic for one, mimic in reader.mimics.items() if model.existJointName(one)}
    for name, mimic in mimics.items():
        if mimic.leader in reader.locked:
            raise UrdfError(
                path,
                f"follows {mimic.leader}, which is locked; make it fixed, or give it a motor",
                field=f"joint {name}",
            )
    return Urdf(model, mimics, tuple(reader.locked))


def _check_kind(path: Path, text: str) -> None:
    """Refuse what is no URDF, or is one that xacro has still to unfold."""
    if is_mjcf(text):
        raise UrdfError(
            path, "is an MJCF; make a URDF and a robot file of it with `shoecal new robot`"
        )
    if "<robot" not in text:
        if kind := file_kind(path):
            raise UrdfError(path, f"is {kind}, by its keys; name a URDF here")
        raise UrdfError(path, "not a URDF (no <robot> element)")
    if is_xacro(text):
        raise UrdfError(path, XACRO)


def with_joints_plain(text: str) -> str:
    """A URDF's text with joints as everything here takes them.

    A joint whose limits are one angle, or place, is fixed there; one that turns without limits is
    continuous. A base that floats in a world without mass is the root itself.

    The text is XML without a document type.
    """
    root = ElementTree.fromstring(text)  # noqa: S314 - document types have been refused
    joints = list(root.iter("joint"))
    locked = [joint for joint in joints if _is_locked(joint)]
    limitless = [joint for joint in joints if is_limitless(joint)]
    world = _floating(root)
    if not (locked or limitless or world):
        return text
    for joint in locked:
        _fix(joint)
    for joint in limitless:
        joint.set("type", "continuous")
    for element in world:
        root.remove(element)
    return ElementTree.tostring(root, encoding="unicode")


def is_limitless(joint: ElementTree.Element) -> bool:
    """Whether a joint turns without limits of its angle."""
    limit = joint.find("limit")
    neither = limit is not None and not {"lower", "upper"} & set(limit.attrib)
    return joint.get("type") == "continuous" or (joint.get("type") == "revolute" and neither)


def _floating(root: ElementTree.Element) -> list[ElementTree.Element]:
    """The joint on which the whole robot floats, and the link without mass before it."""
    joints = root.findall("joint")
    floating = [joint for joint in joints if joint.get("type") == "floating"]
    if len(floating) != 1:
        return []
    world = _end(floating[0], "parent")
    if sum(world in (_end(one, "parent"), _end(one, "child")) for one in joints) != 1:
        return []
    links = [link for link in root.findall("link") if link.get("name") == world]
    if any(link.find("inertial") is not None for link in links):
        return []
    return [*floating, *links]


def _end(joint: ElementTree.Element, tag: str) -> str | None:
    end = joint.find(tag)
    return None if end is None else end.get("link")


def _is_locked(joint: ElementTree.Element) -> bool:
    limit = joint.find("limit")
    if limit is None or joint.get("type") not in ("revolute", "prismatic"):
        return False
    return limits_are_one(limit.attrib)


def limits_are_one(limit: Mapping[str, str]) -> bool:
    """Whether the attributes of a <limit> lock its joint: both are given, and the same."""
    low, high = (_number(limit.get(key, "")) for key in ("lower", "upper"))
    return low == high


def _fix(joint: ElementTree.Element) -> None:
    """Fix a joint where its limits lock it."""
    limit = joint.find("limit")
    move_zero(joint, 0.0 if limit is None else _number(limit.get("lower", "0")))
    for tag in ("limit", "axis", "mimic"):
        if (part := joint.find(tag)) is not None:
            joint.remove(part)
    joint.set("type", "fixed")


def move_zero(joint: ElementTree.Element, angle: float) -> None:
    """Have a URDF's joint at zero where it was at this angle [rad], or place [m], before."""
    axis, origin = (joint.find(tag) for tag in ("axis", "origin"))
    if origin is None:
        origin = ElementTree.SubElement(joint, "origin")
    direction = _vector("1 0 0" if axis is None else axis.get("xyz", "1 0 0"))
    direction /= max(float(np.linalg.norm(direction)), 1e-12)
    place, rpy = (_vector(origin.get(key, "0 0 0")) for key in ("xyz", "rpy"))
    rotation = pin.rpy.rpyToMatrix(rpy)
    if joint.get("type") == "prismatic":
        origin.set("xyz", written(place + rotation @ direction * angle))
    else:
        rotation = rotation @ pin.AngleAxis(angle, direction).toRotationMatrix()
        origin.set("rpy", written(pin.rpy.matrixToRpy(rotation)))


def written(values: FloatArray) -> str:
    """Numbers (n,) as URDF attributes hold them."""
    return " ".join(f"{one:.12g}" for one in values)


def _bounded(text: str) -> str:
    """The URDF with every continuous joint as a revolute one of half a turn either way.

    Pinocchio gives a continuous joint a sine and a cosine; everything here takes one angle a joint.
    Kinematics hold for any angle all the same.
    """
    if '"continuous"' not in text and "'continuous'" not in text:
        return text
    root = ElementTree.fromstring(text)  # noqa: S314 - document types have been refused
    for joint in root.iter("joint"):
        if joint.get("type") == "continuous":
            joint.set("type", "revolute")
            limit = joint.find("limit")
            if limit is None:
                limit = ElementTree.SubElement(joint, "limit", {"effort": "0", "velocity": "0"})
            limit.attrib.update(lower=str(-math.pi), upper=str(math.pi))
    return ElementTree.tostring(root, encoding="unicode")


@dataclass(frozen=True)
class Outline:
    """What a URDF names.

    Attributes:
        joints: those that move.
        frames: links and joints, as messages name frames.
        limits: lower and upper of joints that turn, and by less than a whole turn [rad].
    """

    joints: frozenset[str]
    frames: frozenset[str]
    limits: Mapping[str, tuple[float, float]]


def read_outline(path: Path) -> Outline:
    """What a URDF names, which need not be usable otherwise.

    Raises:
        FileSyntaxError: for a file that is no XML.
        UrdfError: for one that declares a document type.
    """
    joints, frames = set[str](), set[str]()
    limits: dict[str, tuple[float, float]] = {}
    revolute = ""

    def start(tag: str, attributes: dict[str, str]) -> None:
        nonlocal revolute
        name = str(attributes.get("name"))
        if tag in ("link", "joint"):
            frames.add(name)
            revolute = name if attributes.get("type") == "revolute" else ""
        if tag == "joint" and attributes.get("type") != "fixed":
            joints.add(name)
        if tag == "limit" and revolute:
            low, high = (_number(attributes.get(key, "")) for key in ("lower", "upper"))
            if 0.0 < high - low < math.tau:
                limits[revolute] = low, high

    _parse(path, read_bytes(path).decode("utf-8", errors="replace"), start, lambda _: None)
    return Outline(frozenset(joints), frozenset(frames), limits)


def _parse(
    path: Path, text: str, start: Callable[[str, dict[str, str]], None], end: Callable[[str], None]
) -> None:
    """Call back for every element of an XML file."""

    def refuse(*_: object) -> None:
        raise UrdfError(path, "declares a document type; leave <!DOCTYPE> out")

    depth = 0

    def begin(tag: str, attributes: dict[str, str]) -> None:
        nonlocal depth
        depth += 1
        if depth > MAX_DEPTH:
            problem = f"<{tag[:30]}> is within {MAX_DEPTH} other elements"
            raise UrdfError(path, f"{problem}; export the URDF again")
        start(tag, attributes)

    def close(tag: str) -> None:
        nonlocal depth
        depth -= 1
        end(tag)

    parser = expat.ParserCreate()
    parser.StartElementHandler = begin
    parser.EndElementHandler = close
    # Entities can unfold a small file into gigabytes, or name another one.
    parser.StartDoctypeDeclHandler = refuse
    try:
        parser.Parse(text, True)
    except expat.ExpatError as error:
        raise FileSyntaxError(path, f"not valid XML: {error}") from error


def _reason(complaints: Sequence[str], error: Exception) -> str:
    """The parser's first complaint; its exception seldom says more than that there is one."""
    for line in (*complaints, *str(error).splitlines()):
        if text := line.removeprefix("Error:").strip():
            return text
    return "rejected by the parser"


def name_links(links: Sequence[str]) -> str:
    """A few of many, and how many more."""
    more = len(links) - NAMED
    names = ", ".join(links[:NAMED])
    return f"link{'s' if len(links) > 1 else ''} {names}{f' and {more} more' if more > 0 else ''}"


def _lost(reader: _Reader, model: pin.Model) -> str:
    """The links whose mass the parser dropped, where that is known."""
    links = [link for link in reader.masses if not model.existFrame(link, pin.FrameType.BODY)]
    return f" ({name_links(links)})" if links else ""


def _check_joints(path: Path, model: pin.Model) -> None:
    lower, upper = model.lowerPositionLimit, model.upperPositionLimit
    for index in range(ROOT_JOINTS, model.njoints):
        field = f"joint {model.names[index]}"
        joint = model.joints[index]
        if joint.nq != 1:
            raise UrdfError(
                path,
                "only revolute, continuous and prismatic joints are understood; make it fixed, or "
                "one of these",
                field=field,
            )
        if not np.linalg.norm(joint_axis(model, index)) > 0.5:
            raise UrdfError(path, "its axis has no direction", field=field)
        low, high = lower[joint.idx_q], upper[joint.idx_q]
        if not (np.isfinite(low) and np.isfinite(high) and low < high):
            raise UrdfError(
                path,
                f"limits {low:g} to {high:g} are missing or crossed; give lower < upper",
                field=field,
            )


class _Reader:
    """What is in a URDF and the parser does not report, or does not report where.

    Attributes:
        masses: of each link as it is written down [kg].
        unweighed: links whose <inertial> has no <mass>, which the parser leaves out.
        mimics: by the name of the joint that follows.
        locked: joints whose limits are one.
    """

    def __init__(self, path: Path, text: str) -> None:
        self.masses: dict[str, float] = {}
        self.unweighed: list[str] = []
        self.mimics: dict[str, Mimic] = {}
        self.locked: list[str] = []
        self._path = path
        self._place: list[str] = []
        self._hangs_on: dict[str, str] = {}
        self._name = ""
        self._kind = ""
        self._limitless = False
        _parse(path, text, self._start, self._end)

    def _start(self, tag: str, attributes: dict[str, str]) -> None:
        self._place.append(tag)
        if tag == "origin" and self._place[:2] in _PARTS:
            self._check_origin(attributes)
        if self._place in _PARTS:
            self._name = attributes.get("name", "")
            self._kind = attributes.get("type", "")
            self._limitless = self._kind in ("revolute", "prismatic")
        elif self._place[:-1] == ["robot", "link", "inertial"]:
            self._start_of_inertial(tag, attributes)
        elif self._place == ["robot", "joint", "limit"]:
            self._limitless = False
            for key in ("effort", "velocity"):
                self._joint_number(attributes, key, "", minimum=0.0)
            for key in ("lower", "upper"):
                self._joint_number(attributes, key, "0")
            if self._kind in ("revolute", "prismatic") and limits_are_one(attributes):
                self.locked.append(self._name)
        elif self._place == ["robot", "joint", "child"]:
            self._hang(attributes.get("link", ""))
        elif self._place == ["robot", "joint", "mimic"]:
            self.mimics[self._name] = Mimic(
                leader=attributes.get("joint", ""),
                multiplier=self._joint_number(attributes, "multiplier", "1"),
                offset=self._joint_number(attributes, "offset", "0"),
            )

    def _hang(self, link: str) -> None:
        other = self._hangs_on.setdefault(link, self._name)
        if other != self._name:
            raise UrdfError(
                self._path,
                f"hangs on two joints ({other} and {self._name}), and a URDF is a tree; take one "
                "out, or close the chain by a <loop_joint> between two links",
                field=f"link {link}",
            )

    def _start_of_inertial(self, tag: str, attributes: dict[str, str]) -> None:
        if tag == "mass":
            self.masses[self._name] = _mass(self._path, self._name, attributes.get("value", ""))
        elif tag == "inertia":
            for key, text in attributes.items():
                self._check_inertia(key, text)

    def _end(self, _: str) -> None:
        if self._place == ["robot", "joint"] and self._limitless:
            raise self._joint_error("has no <limit>; give lower, upper, effort and velocity")
        if self._place == ["robot", "link", "inertial"] and self._name not in self.masses:
            self.unweighed.append(self._name)
        self._place.pop()

    def _joint_number(
        self, attributes: dict[str, str], key: str, default: str, minimum: float = -math.inf
    ) -> float:
        text = attributes.get(key, default)
        number = _number(text)
        if not (math.isfinite(number) and number >= minimum):
            tag, least = self._place[-1], " of zero or more" if minimum == 0.0 else ""
            raise self._joint_error(
                f'{key}="{text[:30]}" of its <{tag}> is not a number{least}; give one'
            )
        return number

    def _check_origin(self, attributes: Mapping[str, str]) -> None:
        field = f"{self._place[1]} {self._name}"
        for key, unit, most in (("xyz", "metres", MAX_DISTANCE), ("rpy", "rad", DEGREES_FROM)):
            text = attributes.get(key, "0 0 0")
            given = f'{key}="{text[:90]}" of its {self._where()}'
            # Shapes may be wrong: neither kinematics nor masses need them.
            moves = self._place[2] in ("inertial", "origin")
            if moves and not _is_vector(text):
                raise UrdfError(
                    self._path, f"{given} is not three numbers; give three, in {unit}", field=field
                )
            if not any(most < abs(_number(part)) < math.inf for part in text.split()):
                continue
            if key == "xyz":
                raise UrdfError(
                    self._path, f"{given} is farther than {most:g} m; give metres", field=field
                )
            if moves:
                raise UrdfError(
                    self._path, f"{given} is more than a turn: in degrees? Give rad", field=field
                )

    def _where(self) -> str:
        """The element that is read, and what it is in within its link or joint."""
        return " in ".join(f"<{tag}>" for tag in self._place[:1:-1])

    def _check_inertia(self, key: str, text: str) -> None:
        # What is no number the parser drops with the whole inertial, which is noticed there.
        if abs(_number(text)) > MAX_INERTIA:
            problem = f'{key}="{text[:30]}" is not a moment of inertia in kg m^2'
            raise UrdfError(self._path, problem, field=f"link {self._name}")

    def _joint_error(self, problem: str) -> UrdfError:
        return UrdfError(self._path, problem, field=f"joint {self._name}")


def _number(text: str) -> float:
    """A number, or NaN where the text is none."""
    try:
        return float(text)
    except ValueError:
        return math.nan


def _is_vector(text: str) -> bool:
    """Three numbers."""
    numbers = [_number(part) for part in text.split()]
    return len(numbers) == 3 and all(map(math.isfinite, numbers))


def _vector(text: str) -> FloatArray:
    """(3,) numbers; NaN where the text has none, which the parser refuses."""
    return np.array([_number(part) for part in text.split()])


def _mass(path: Path, link: str, text: str) -> float:
    mass = _number(text)
    if not 0.0 <= mass <= MAX_MASS:
        raise UrdfError(
            path, f"mass '{text[:30]}' is not a number of kg, zero or more", field=f"link {link}"
        )
    return mass
