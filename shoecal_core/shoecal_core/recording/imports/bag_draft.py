"""A mapping file drafted from bags and written as text, with what to check and to choose."""

from __future__ import annotations

import os
from collections import defaultdict
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import pairwise
from pathlib import Path

import numpy as np
import yaml

from shoecal_core.arrays import FloatArray
from shoecal_core.errors import named_together
from shoecal_core.recording.container import MAX_RECORDS
from shoecal_core.recording.errors import RecordingError
from shoecal_core.recording.imports.bag import Bag
from shoecal_core.recording.imports.bag_fields import WRENCH, table
from shoecal_core.recording.imports.bag_mapping import CHOOSE
from shoecal_core.recording.imports.bag_match import (
    Match,
    TopicContent,
    look_into,
    match_base_pose,
    match_cells,
    match_imu,
    match_joints,
    match_wrench,
    other_types,
    text_of_numbers,
    what_is_there,
)
from shoecal_core.recording.imports.mapping import ANGLE_UNIT, FORMAT
from shoecal_core.recording.imports.named_numbers import named_twice, uneven
from shoecal_core.recording.imports.replayed import describe_replayed
from shoecal_core.recording.imports.standing import find_feet
from shoecal_core.recording.joint_series import (
    JointSeries,
    Series,
    from_pieces,
    in_degrees,
    with_numbers,
    without_zeros,
)
from shoecal_core.recording.schemas import SHOE_VOLTAGES_TYPE
from shoecal_core.robot.double_support import DoubleSupport
from shoecal_core.robot.kinematics import Kinematics
from shoecal_core.robot.robot import JointsMissingError, Robot
from shoecal_core.shoe.shoe import AXES, FEET, Shoe

MAX_CLOCK_OFFSET_S = 0.25
"""Between the stamps of two topics of one clock, by when their messages were received."""
DEGREES = "joint angles are beyond the URDF's limits, but within them as degrees: angle_unit"
FEET_MOVE = (
    "has no base pose, and its feet move: record one, or give 'from_s' and 'to_s' of a part in "
    "which they stand still, and its 'support'"
)
FEET_UNKNOWN = (
    "has no base pose, and its joint angles are not chosen yet: choose their topic, then give "
    "'support', or draft again"
)
FULL = 0.9
"""Of what a run may hold, so much a drafted trial takes."""


@dataclass(frozen=True)
class DraftTrial:
    """One run of a drafted mapping.

    Attributes:
        bag: file or folder.
        span: part of it since its first message [s]; None: all of it.
        support: of feet that stand still; None where they move, or a base pose is there.
        notes: what to check in it, a line each.
    """

    bag: Path
    span: tuple[float, float] | None
    support: DoubleSupport | None
    notes: tuple[str, ...] = ()


@dataclass(frozen=True)
class BagDraft:
    """A mapping drafted from bags; a field that no topic fits is not there.

    Attributes:
        trials: one a bag, several where it is longer than a run may be.
        fields: match by field: `joints`, `cells`, `wrenches.left`, `wrenches.right`, `imu`,
            `base_pose`.
        degrees: joint angles are in degrees.
        received: topics whose stamps are of another clock or missing.
        notes: of the whole.
    """

    trials: tuple[DraftTrial, ...]
    fields: Mapping[str, Match]
    degrees: bool
    received: tuple[str, ...]
    notes: tuple[str, ...]


def draft_mapping(bags: Sequence[Path], robot: Robot, shoe: Shoe) -> BagDraft:
    """Match the topics of bags to a robot and its shoe.

    Args:
        bags: of one robot, with the same topics; the first one is looked into.

    Raises:
        FileError: for a bag that cannot be read, without joint angles or readings.
    """
    with named_together(bags):
        return _draft(bags, robot, shoe)


def _draft(bags: Sequence[Path], robot: Robot, shoe: Shoe) -> BagDraft:
    with Bag(bags[0]) as bag:
        seen, others = look_into(bag), other_types(bag)
        joints = match_joints(bag, seen, others, robot)
        degrees = joints.chosen and _degrees(_angles(bag, joints, robot), robot)
        there, text = what_is_there(bag), text_of_numbers(bag)
        empty = [name for name, one in bag.topics.items() if not one.count]
    fields = {
        "joints": joints,
        "cells": match_cells(seen, others, shoe),
        **{f"wrenches.{foot}": match_wrench(seen, robot, shoe, foot) for foot in FEET},
        "imu": match_imu(seen, robot),
        "base_pose": match_base_pose(seen, robot),
    }
    found = {key: match for key, match in fields.items() if match is not None}
    if not {"cells", "wrenches.left", "wrenches.right"} & set(found):
        raise RecordingError(bags[0], f"{_no_readings(shoe, seen, text, empty)}; {there}")
    used = [topic for match in found.values() for topic in match.topics]
    for topic in used:
        if topic in seen and (apart := seen[topic].apart_s):
            raise RecordingError(bags[0], describe_replayed(apart), field=topic)
    received = _other_clocks({topic: (seen | others)[topic] for topic in used})
    notes = [f"{topic}: {_why_received((seen | others)[topic])}" for topic in received]
    notes += [DEGREES] if degrees else []
    notes += [
        f"no topic fits the {foot} foot's six-axis sensor, which is left out: record it"
        for foot in FEET
        if f"wrenches.{foot}" not in found and any(f"{foot}/{axis}" in shoe.names for axis in AXES)
    ]
    stands = None if "base_pose" in found else found["joints"]
    stand = None
    if stands is not None:
        stand = partial(_stand, stands, found.get("cells"), Kinematics(robot), shoe)
    trials = [trial for bag in bags for trial in _trials(bag, used, stand)]
    notes += [f"{trial.bag.name}: {note}" for trial in trials for note in trial.notes]
    return BagDraft(tuple(trials), found, degrees, received, tuple(notes))


def _no_readings(
    shoe: Shoe, seen: Mapping[str, TopicContent], text: str, empty: Sequence[str]
) -> str:
    """Why no topic fits a shoe, with the cure: other cells, another kind of sensor, or none.

    Args:
        shoe: that none fits.
        seen: topics of known types.
        text: the problem of topics of text.
        empty: topics without a message.
    """
    problem = f"has no topic that fits '{shoe.name}' ({', '.join(shoe.names)})"
    for topic, one in seen.items():
        if one.type == SHOE_VOLTAGES_TYPE:
            named = ", ".join(one.names) or "no cells"
            return f"{problem}: {topic} names {named}; name the shoe that was recorded (--shoe)"
    wrenches = [topic for topic, one in seen.items() if one.type == WRENCH]
    if wrenches and not any(name.endswith(AXES) for name in shoe.names):
        if len(wrenches) > len(FEET):
            return (
                f"{problem}: {', '.join(wrenches)} have a wrench each; where each is a cell, write "
                "that in the mapping (cells: {TOPIC: {wrench.force.z: CELL}, …}), else name the "
                "shoe that was recorded (--shoe)"
            )
        return (
            f"{problem}: it has six-axis sensors ({', '.join(wrenches)}), '{shoe.name}' has single "
            "cells; name the shoe that was recorded (--shoe)"
        )
    if text:
        return f"{problem}: {text}"
    if empty:
        return f"{problem}: {', '.join(empty)} is there, but holds no message; record it again"
    return (
        f"{problem}; record one, or write in the mapping which field is which (cells: {{TOPIC: "
        "{FIELD: CELL}})"
    )


def _why_received(one: TopicContent) -> str:
    if one.offset_s is None:
        return "its messages have no stamps: they count at the times at which they were received"
    return (
        f"its stamps are {abs(one.offset_s):.1f} s off the times at which they were received, "
        "those of others are not: the latter count"
    )


def _other_clocks(seen: Mapping[str, TopicContent]) -> tuple[str, ...]:
    """Topics without stamps, or whose stamps are off the times of receipt, where they differ.

    Stamps of one clock are kept, however far it is off.
    """
    delays = {name: one.offset_s for name, one in seen.items() if one.offset_s is not None}
    if len(delays) == len(seen) and np.ptp(list(delays.values())) <= MAX_CLOCK_OFFSET_S:
        return ()
    return tuple(name for name in seen if not abs(delays.get(name, np.inf)) <= MAX_CLOCK_OFFSET_S)


def _stand(
    joints: Match,
    cells: Match | None,
    kinematics: Kinematics,
    shoe: Shoe,
    bag: Bag,
    span: tuple[float, float] | None,
) -> tuple[DoubleSupport | None, list[str]]:
    """Where the feet stand in a part of a bag, if they do, and what is wrong, a line each."""
    if not joints.chosen:
        return None, [FEET_UNKNOWN]
    robot = kinematics.robot
    angles = _angles(bag, joints, robot, span)
    if _degrees(angles, robot):
        angles = {name: replace(one, angle=np.radians(one.angle)) for name, one in angles.items()}
    angles, lacking = with_numbers(angles, robot.optional)
    angles, jumping = without_zeros(angles)
    notes = [*lacking, *jumping]
    readings = {} if cells is None or not cells.chosen else _series(bag, cells, span)
    try:
        feet = find_feet(kinematics, shoe, angles, readings)
    except JointsMissingError as error:
        return None, [*notes, str(error)]
    wrong = feet.wrong(stand=feet.loaded)
    if wrong:
        return None, [*notes, wrong]
    return (None, [*notes, FEET_MOVE]) if feet.moves else (feet.support, notes)


def _angles(
    bag: Bag, joints: Match, robot: Robot, span: tuple[float, float] | None = None
) -> dict[str, JointSeries]:
    """Of the robot's joints, as `_series`."""
    series = _series(bag, joints, span, robot.joint_names)
    return {name: one for name, one in series.items() if name in robot.joint_names}


def _degrees(angles: Series, robot: Robot) -> bool:
    """Whether joint angles are beyond the robot's limits, but within them as degrees."""
    for name, one in angles.items():
        joint, there = robot.joint(name), one.angle[np.isfinite(one.angle)]
        if len(there) and in_degrees(there, robot.lower[joint], robot.upper[joint]):
            return True
    return False


def _series(
    bag: Bag, match: Match, span: tuple[float, float] | None, known: Sequence[str] = ()
) -> dict[str, JointSeries]:
    """What the messages of some topics name, by when they were received since the bag's start [s].

    Args:
        match: joints or cells, and their topics.
        span: part of the bag since its first message [s]; None: all of it.
        known: names that each message may have once.

    Raises:
        RecordingError: where no message has a number for each of its names, or one has a name
            twice.
    """
    rows: dict[tuple[str, ...], list[tuple[float, FloatArray]]] = defaultdict(list)
    problems: dict[str, str] = {}
    for message in bag.messages(match.topics, *(span or ())):
        content, fields = message.content, match.fields.get(message.topic)
        if fields is not None:
            names, values = tuple(fields.values()), table([content], list(fields))[0]
        else:
            kind = ("cell", "voltage") if hasattr(content, "cell") else ("name", "position")
            named, values = (getattr(content, key) for key in kind)
            names = tuple(match.rename.get(name, name) for name in named)
        if len(values) == len(names):
            rows[names].append((1e-9 * (message.received_ns - bag.start_ns), values))
        elif hasattr(content, "name"):
            problems.setdefault(message.topic, uneven(content))
    if problems and not rows:
        topic, problem = next(iter(problems.items()))
        raise RecordingError(bag.path, problem, field=topic)
    pieces: dict[str, list[tuple[FloatArray, FloatArray]]] = defaultdict(list)
    for names, own in rows.items():
        if problem := named_twice(names, known):
            raise RecordingError(bag.path, problem, field=", ".join(match.topics))
        times, values = (np.array(part, dtype=np.float64) for part in zip(*own, strict=True))
        for name, column in zip(names, values.T, strict=True):
            pieces[name].append((times, column))
    return from_pieces(pieces)


def _trials(
    path: Path,
    topics: Sequence[str],
    stand: Callable[[Bag, tuple[float, float] | None], tuple[DoubleSupport | None, list[str]]]
    | None,
) -> list[DraftTrial]:
    """A bag, in parts that a run can hold.

    Args:
        path: of the bag.
        topics: that are imported.
        stand: finds how the feet stand in a part; None: not needed.
    """
    with Bag(path) as bag:
        count = sum(bag.topics[topic].count for topic in topics if topic in bag.topics)
        parts = max(1, int(np.ceil(count / (FULL * MAX_RECORDS))))
        ends = np.round(np.linspace(0.0, bag.length_s, parts + 1), 3).tolist()
        spans = [None] if parts == 1 else list(pairwise(ends))
        trials = []
        for span in spans:
            support, notes = (None, []) if stand is None else stand(bag, span)
            trials.append(DraftTrial(path, span, support, tuple(notes)))
        return trials


def mapping_text(draft: BagDraft, folder: Path, robot: Path, urdf: Path, shoe: Path) -> str:
    """The mapping file, each field below the comments that say what to check.

    Args:
        folder: in which the mapping will be.
        robot, urdf, shoe: files as they are now; they are named relative to `folder`.
    """
    lines = [
        "# Draft by `shoecal import draft`: which topics of the bags mean what.",
        f"format: {FORMAT}",
        *(
            _line(key, os.path.relpath(path.resolve(), folder.resolve()))
            for key, path in (("robot", robot), ("urdf", urdf), ("shoe", shoe))
        ),
        "",
    ]
    block = ""
    for key, match in draft.fields.items():
        outer, _, inner = key.rpartition(".")
        if outer and outer != block:
            lines.append(f"{outer}:")
        block = outer
        indent = "  " if outer else ""
        lines += [f"{indent}# CHECK: {note}" for note in match.notes]
        lines.append(f"{indent}{_line(inner, _value(key, match))}")
    if draft.degrees:
        lines.append(_line(ANGLE_UNIT, "deg"))
    if draft.received:
        lines.append(_line("received", list(draft.received)))
    lines += ["", *(f"# CHECK: {note}" for note in draft.notes), "trials:"]
    folder_of_bags = draft.trials[0].bag.parent
    for one in draft.trials:
        trial: dict[str, object] = {
            "motion": "walking" if one.support is None else "standing",
            "bag": os.path.relpath(one.bag, folder_of_bags),
        }
        if one.support is not None:
            place = (one.support.dx, one.support.dy, one.support.dtheta)
            trial["support"] = [round(float(value), 5) for value in place]
        if one.span is not None:
            trial |= {"from_s": one.span[0], "to_s": one.span[1]}
        lines.append(f"  - {_flow(trial)}")
    return "\n".join(lines) + "\n"


def _value(key: str, match: Match) -> dict[str, object]:
    """A field of the mapping."""
    topics = [topic for topic in match.topics if topic not in match.fields]
    if not topics:
        return {topic: dict(names) for topic, names in match.fields.items()}
    several = key in ("joints", "cells")
    named: dict[str, object] = {"topics": topics} if several else {"topic": topics[0]}
    value = named if match.chosen else {CHOOSE: topics}
    return {**value, **({"rename": dict(match.rename)} if match.rename else {}), **match.extra}


def _line(key: str, value: object) -> str:
    return f"{key}: {_flow(value)}"


def _flow(value: object) -> str:
    """One value on one line."""
    text = yaml.safe_dump(value, default_flow_style=True, sort_keys=False, width=10**6)
    return text.strip().removesuffix("\n...")
