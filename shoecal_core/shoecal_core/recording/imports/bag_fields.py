"""Numbers in messages: of known types, or of any by the path of a field such as `data[3]`."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import fields, is_dataclass
from operator import attrgetter
from typing import Any

import numpy as np

from shoecal_core.arrays import FloatArray
from shoecal_core.recording.messages import SECOND_NS
from shoecal_core.recording.schemas import SHOE_VOLTAGES_TYPE

JOINT_STATE = "sensor_msgs/msg/JointState"
WRENCH = "geometry_msgs/msg/WrenchStamped"
IMU = "sensor_msgs/msg/Imu"


def _vectors(*paths: str, quaternion: str = "") -> attrgetter[tuple[float, ...]]:
    """Elements of the vectors at some paths of a message, then those of a quaternion if any."""
    elements = [f"{path}.{axis}" for path in paths for axis in "xyz"]
    turn = [f"{quaternion}.{axis}" for axis in "xyzw"] if quaternion else []
    return attrgetter(*elements, *turn)


POSES = {
    "nav_msgs/msg/Odometry": _vectors("pose.pose.position", quaternion="pose.pose.orientation"),
    "geometry_msgs/msg/PoseStamped": _vectors("pose.position", quaternion="pose.orientation"),
    "geometry_msgs/msg/PoseWithCovarianceStamped": _vectors(
        "pose.pose.position", quaternion="pose.pose.orientation"
    ),
    "geometry_msgs/msg/TransformStamped": _vectors(
        "transform.translation", quaternion="transform.rotation"
    ),
}
"""Position (3,) and quaternion x y z w (4,) of a message, by its type."""
SENSORS = {
    **POSES,
    WRENCH: _vectors("wrench.force", "wrench.torque"),
    IMU: _vectors("angular_velocity", "linear_acceleration", quaternion="orientation"),
}
"""The numbers of a message in the order in which `foreign` takes them, by its type."""
KNOWN = frozenset({JOINT_STATE, SHOE_VOLTAGES_TYPE, *SENSORS})
"""Types that are read for what they mean; of all others the numbers are."""
MOST_ELEMENTS = 64
"""Of an array, that are taken for readings or joint angles; images have more."""
_COMMANDED = re.compile(r"desired|reference|error|output")
"""Parts of a controller's state that are not measured."""
_STEP = re.compile(r"(\w+)((?:\[\d+\])*)\Z")
_SKIPPED = ("header", "layout")
_SIDES = {"left": "left", "l": "left", "right": "right", "r": "right"}
_PLACES = {"back": "rear", "hind": "rear", "heel": "rear", "toe": "front", "fore": "front"}
LOLA_POSITIONS = "nao_lola_sensor_msgs/msg/JointPositions"
LOLA_JOINTS = (
    "HeadYaw", "HeadPitch", "LShoulderPitch", "LShoulderRoll", "LElbowYaw", "LElbowRoll",
    "LWristYaw", "LHipYawPitch", "LHipRoll", "LHipPitch", "LKneePitch", "LAnklePitch",
    "LAnkleRoll", "RHipRoll", "RHipPitch", "RKneePitch", "RAnklePitch", "RAnkleRoll",
    "RShoulderPitch", "RShoulderRoll", "RElbowYaw", "RElbowRoll", "RWristYaw", "LHand", "RHand",
)  # fmt: skip
"""Order of a NAO's joints in its interface to the robot's own computer, LoLA (JointIndexes.msg)."""


def stamp_ns(content: Any) -> int:
    """Stamp of a message's header; 0 where its sender set none, or where it has no header."""
    stamp = getattr(getattr(content, "header", None), "stamp", None)
    if stamp is None or not hasattr(stamp, "sec"):
        return 0
    return int(stamp.sec) * SECOND_NS + int(stamp.nanosec)


def number_at(content: Any, path: str) -> float:
    """The number at a path such as `a.b[2]` of a message, also one written as text.

    Raises:
        LookupError: there is none, or it is of the header or of an array's layout.
    """
    if path.split(".", maxsplit=1)[0] in _SKIPPED:  # a stamp or a layout is no reading
        raise LookupError(path)
    found = content
    for step in path.split("."):
        match = _STEP.match(step)
        if match is None or not hasattr(found, match.group(1)):
            raise LookupError(path)
        found = getattr(found, match.group(1))
        for place in re.findall(r"\d+", match.group(2)):
            if not isinstance(found, list | np.ndarray):
                raise LookupError(path)
            found = found[int(place)]
    if not isinstance(found, int | float | np.number | np.bool_ | str):
        raise LookupError(path)
    try:
        return float(found)
    except ValueError as error:
        raise LookupError(path) from error


def numbers_in(content: Any, prefix: str = "") -> Iterator[str]:
    """Paths of all numbers of a message, without its header."""
    for field in fields(content):
        value, path = getattr(content, field.name), f"{prefix}{field.name}"
        if field.name in _SKIPPED:
            continue
        if is_dataclass(value):
            yield from numbers_in(value, f"{path}.")
        elif isinstance(value, int | float | np.number) and not isinstance(value, bool):
            yield path
        elif isinstance(value, list | np.ndarray) and len(value) <= MOST_ELEMENTS:
            for at, one in enumerate(value):
                if is_dataclass(one):
                    yield from numbers_in(one, f"{path}[{at}].")
                elif isinstance(one, int | float | np.number):
                    yield f"{path}[{at}]"


def text_in(content: Any) -> str:
    """The text of a message that holds no number, its header left out; empty of others."""
    if next(numbers_in(content), None) is not None:
        return ""
    values = [getattr(content, one.name) for one in fields(content) if one.name not in _SKIPPED]
    return " ".join(
        value if isinstance(value, str) else " ".join(value)
        for value in values
        if isinstance(value, str) or _texts(value)
    )


def text_problem(types: Mapping[str, str]) -> str:
    """Why topics of text are not read, with the cure, by their types."""
    kinds = ", ".join(dict.fromkeys(types.values()))
    return (
        f"{', '.join(types)} {'hold' if len(types) > 1 else 'holds'} text ({kinds}), which is not "
        "read: publish numbers, or export it to CSV and use `shoecal import csv`"
    )


def named_numbers(content: Any) -> dict[str, str]:
    """Path by name, where a message lists names and as many numbers.

    Thus do JointState, and what the controllers of ros2_control report (JointTrajectoryController-
    State, DynamicJointState): measured positions where they are there, else what is not zero.
    """
    names = next(
        (list(value) for field in fields(content) if _texts(value := getattr(content, field.name))),
        [],
    )
    if not names:
        return {}
    found = _by_interface(content, len(names))
    arrays = [
        one for one in arrays_in(list(numbers_in(content))).items() if len(one[1]) == len(names)
    ]
    measured = [one for one in arrays if not _COMMANDED.search(one[0])]
    for _, paths in sorted(measured, key=lambda one: "position" not in one[0]):
        if paths and not any(number_at(content, one) for one in found):
            found = paths
    return dict(zip(names, found, strict=True)) if found else {}


def _by_interface(content: Any, count: int) -> list[str]:
    """Paths of the positions, else of the first values, in a DynamicJointState."""
    for field in fields(content):
        listed = getattr(content, field.name)
        if not isinstance(listed, list) or len(listed) != count:
            continue
        kinds = [list(getattr(one, "interface_names", ())) for one in listed]
        for kind in ("position", *kinds[0][:1]):
            if all(kind in own for own in kinds):
                places = [own.index(kind) for own in kinds]
                return [f"{field.name}[{at}].values[{place}]" for at, place in enumerate(places)]
    return []


def _texts(value: object) -> bool:
    return isinstance(value, list) and bool(value) and all(isinstance(one, str) for one in value)


def table(contents: Sequence[Any], paths: Sequence[str]) -> FloatArray:
    """(T, k) numbers at paths of messages; NaN where a message has none.

    Raises:
        LookupError: a path that no message has.
    """
    found = np.full((len(contents), len(paths)), np.nan)
    for column, path in enumerate(paths):
        there = 0
        for row, one in enumerate(contents):
            try:
                found[row, column] = number_at(one, path)
                there += 1
            except LookupError:
                continue
        if not there:
            raise LookupError(path)
    return found


def cells_by_words(topic: str, paths: Sequence[str], cells: Sequence[str]) -> dict[str, str]:
    """Cell by path, where topic and field say foot and place: `l_foot_front_left`, or `left_back`
    on a topic of the left foot.
    """
    places = {
        cell: (foot, set(_words(place)))
        for cell in cells
        for foot, _, place in [cell.partition("/")]
    }
    found: dict[str, str] = {}
    for path in paths:
        words = [*_words(topic), *_words(path)]
        at = next((at for at, word in enumerate(words) if word in _SIDES.values()), None)
        if at is None:
            continue
        rest = set(words[at + 1 :]) | set(words[:at])
        fitting = [
            cell for cell, (foot, own) in places.items() if foot == words[at] and own <= rest
        ]
        longest = max((len(places[cell][1]) for cell in fitting), default=0)
        fitting = [cell for cell in fitting if len(places[cell][1]) == longest]
        if len(fitting) == 1:
            found[path] = fitting[0]
    return found if len(set(found.values())) == len(found) else {}


def foot_in(topic: str, path: str) -> str | None:
    """The foot that the words of topic and field name; None where they name none, or both."""
    sides = {word for word in (*_words(topic), *_words(path)) if word in _SIDES.values()}
    return sides.pop() if len(sides) == 1 else None


def arrays_in(paths: Sequence[str]) -> Mapping[str, list[str]]:
    """Paths of each array of numbers, by the array's path."""
    found: dict[str, list[str]] = {}
    for path in paths:
        name, bracket, place = path.rpartition("[")
        if bracket and place[:-1].isdigit():
            found.setdefault(name, []).append(path)
    return found


def _words(text: str) -> list[str]:
    """Its words, sides and places by their usual names."""
    parts = re.findall(r"[a-z]+", re.sub(r"([a-z])([A-Z])", r"\1 \2", text).lower())
    return [_PLACES.get(word, _SIDES.get(word, word)) for word in parts]
