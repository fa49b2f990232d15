"""Which topics of a bag fit which field of a mapping, by the robot file and the shoe file."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pinocchio as pin

from shoecal_core.arrays import FloatArray
from shoecal_core.recording.errors import RecordingError
from shoecal_core.recording.imports.bag import Bag
from shoecal_core.recording.imports.bag_fields import (
    IMU,
    JOINT_STATE,
    KNOWN,
    LOLA_JOINTS,
    LOLA_POSITIONS,
    POSES,
    SENSORS,
    WRENCH,
    arrays_in,
    cells_by_words,
    foot_in,
    named_numbers,
    numbers_in,
    stamp_ns,
    text_in,
    text_problem,
)
from shoecal_core.recording.imports.names import matched_names, without_prefix
from shoecal_core.recording.imports.replayed import replayed
from shoecal_core.recording.schemas import SHOE_VOLTAGES_TYPE
from shoecal_core.robot.robot import Robot
from shoecal_core.robot.urdf import ROOT_JOINTS
from shoecal_core.shoe.shoe import AXES, FEET, Shoe

SAMPLE = 200
"""Messages of a topic that are looked at."""
BASE = ROOT_JOINTS - 1
"""The free-flyer among the model's joints."""
LOADED_SHARE = 0.1
"""Of the robot's weight, that a foot carries on average."""
PARALLEL = np.cos(np.radians(2.0))
ORDER = "its numbers have no names and are taken in the order of the"
_WORDS = {
    "left": re.compile(r"(^|[^a-z])(left|l)([^a-z]|$)"),
    "right": re.compile(r"(^|[^a-z])(right|r)([^a-z]|$)"),
}
_ANGLES = re.compile(
    r"^(?!.*(temp|torque|current|speed|veloc|command|goal|target)).*(joint|servo|posit)"
)
"""A topic of measured joint angles, by the words of its name."""
_DIGIT = re.compile(r"\d")
_HAND = re.compile(r"hand|wrist|arm|gripper")


@dataclass(frozen=True)
class TopicContent:
    """What the first messages of one topic show.

    Attributes:
        type: of the topic.
        frames: of their headers, in order of appearance.
        children: child frames that they name (odometry, transforms).
        names: joints or cells that they name.
        force: (3,) mean force of wrenches [N].
        offset_s: how much later than stamped they were received, median [s]; None: no stamps.
        numbers: paths of the numbers in a message of a type that is not known.
        named: path of the number that such a message gives for a name, by the name.
        apart_s: by which the stamps of two series in turns differ [s]; None: it is one series.
    """

    type: str
    frames: tuple[str, ...]
    children: tuple[str, ...]
    names: tuple[str, ...]
    force: FloatArray
    offset_s: float | None
    numbers: tuple[str, ...] = ()
    named: Mapping[str, str] = field(default_factory=dict)
    apart_s: float | None = None


@dataclass(frozen=True)
class Match:
    """What one field of the mapping is drafted as.

    Attributes:
        topics: the one that fits; several of which one has to be chosen; or, of joints, all.
        chosen: nothing is left to choose.
        rename: name of robot or shoe by name in the bag.
        extra: further fields.
        notes: what to check, a line each.
        fields: of topics of other types: names of robot or shoe by path, by topic.
    """

    topics: tuple[str, ...]
    chosen: bool = True
    rename: Mapping[str, str] = field(default_factory=dict)
    extra: Mapping[str, object] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    fields: Mapping[str, Mapping[str, str]] = field(default_factory=dict)


def what_is_there(bag: Bag) -> str:
    """Its topics, for who looks for one that is not there."""
    topics = [
        f"{name} ({one.type}, {one.count} messages{'' if one.defined else ', without definition'})"
        for name, one in bag.topics.items()
    ]
    return f"it holds {', '.join(topics) or 'no topics'}"


def other_types(bag: Bag) -> dict[str, TopicContent]:
    """The topics of all other types that have numbers, by their first messages.

    Those of joint states, too: some drivers report cells in them.
    """
    found = {}
    for name, one in bag.topics.items():
        if one.type in KNOWN - {JOINT_STATE} or not one.count:
            continue
        try:
            message = next(bag.messages((name,)), None)
        except RecordingError:
            # A type without a definition in the bag: what it holds is not known.
            continue
        numbers = () if message is None else tuple(numbers_in(message.content))
        if message is None or not numbers:
            continue
        stamp = stamp_ns(message.content)
        delay = 1e-9 * (message.received_ns - stamp) if stamp else None
        named = named_numbers(message.content)
        found[name] = TopicContent(one.type, (), (), (), np.zeros(3), delay, numbers, named)
    return found


def text_of_numbers(bag: Bag) -> str:
    """The problem of topics whose messages are numbers written as text; empty without one.

    A description of the robot is sent once, a status has no digits.
    """
    found = {
        name: one.type
        for name, one in bag.topics.items()
        if one.count > 1 and _DIGIT.search(first_text(bag, name))
    }
    return text_problem(found) if found else ""


def first_text(bag: Bag, topic: str) -> str:
    """The text of a topic's first message, where that holds text alone; empty of others."""
    one = bag.topics.get(topic)
    if one is None or not one.defined or one.type in KNOWN:
        return ""
    message = next(bag.messages((topic,)), None)
    return "" if message is None else text_in(message.content)


def look_into(bag: Bag) -> dict[str, TopicContent]:
    """The topics of known types."""
    wanted = {name: one for name, one in bag.topics.items() if one.type in KNOWN and one.count}
    contents: dict[str, list[Any]] = {name: [] for name in wanted}
    delays: dict[str, list[float]] = {name: [] for name in wanted}
    open_topics = set(wanted)
    for message in bag.messages(tuple(wanted)):
        found = contents[message.topic]
        if len(found) < SAMPLE:
            found.append(message.content)
            if stamp := stamp_ns(message.content):
                delays[message.topic].append(1e-9 * (message.received_ns - stamp))
        elif message.topic in open_topics:
            open_topics.remove(message.topic)
            if not open_topics:
                break
    return {
        name: _seen(wanted[name].type, contents[name], delays[name])
        for name in wanted
        if contents[name]
    }


def _seen(kind: str, contents: Sequence[Any], delays: Sequence[float]) -> TopicContent:
    names = [
        name for one in contents for name in getattr(one, "name", getattr(one, "cell", []))
    ]  # fmt: skip
    forces = [SENSORS[WRENCH](one)[:3] for one in contents if kind == WRENCH]
    return TopicContent(
        type=kind,
        frames=_distinct(str(one.header.frame_id) for one in contents),
        children=_distinct(str(getattr(one, "child_frame_id", "")) for one in contents),
        names=_distinct(names),
        force=np.mean(forces, axis=0) if forces else np.zeros(3),
        offset_s=float(np.median(delays)) if delays else None,
        apart_s=replayed(delays),
    )


def match_joints(
    bag: Bag,
    seen: Mapping[str, TopicContent],
    others: Mapping[str, TopicContent],
    robot: Robot,
) -> Match:
    """The topics that name the robot's joints: one that has all its legs, or several together.

    Args:
        bag: open.
        seen, others: its topics of known types, and of others.
        robot: whose joints they are.

    Raises:
        RecordingError: where no topic of the bag names any of them.
    """
    renames = {
        name: matched_names(one.names, robot.joint_names)
        for name, one in seen.items()
        if one.type == JOINT_STATE
    }
    renames = {name: rename for name, rename in renames.items() if rename}
    if not renames:
        match = _joints_by_field(others, robot)
        if match is not None:
            return match
        states = {name: one for name, one in bag.topics.items() if one.type == JOINT_STATE}
        named = [name for name in states if name in seen]
        known = ", ".join(robot.joint_names[:5])
        if named:
            own = seen[named[0]].names
            text = f"{', '.join(named)} names {', '.join(own[:5])}, …"
            problem = (
                f"{text}, and none of the joints of '{robot.name}' ({known}, …); check --robot, "
                "or write in the mapping which is which (joints: {topics: [TOPIC], rename: "
                "{NAME: JOINT}})"
                if own
                else f"{', '.join(named)} gives angles without names; write in the mapping which "
                "field is which joint (joints: {TOPIC: {'position[0]': JOINT, ...}})"
            )
        elif states:
            problem = f"{', '.join(states)} is there, but holds no message; record it again"
        else:
            cure = text_of_numbers(bag) or (
                "write in the mapping which field is which joint (joints: {TOPIC: {FIELD: JOINT}})"
            )
            problem = f"has no joint angles ({JOINT_STATE}); {what_is_there(bag)}; {cure}"
        raise RecordingError(bag.path, problem)
    topics, rivals = _apart(renames, set(robot.leg_names))
    if rivals:
        return Match(tuple(sorted({*topics, *rivals})), chosen=False)
    rename = {old: new for name in topics for old, new in renames[name].items() if old != new}
    given = {new for name in topics for new in renames[name].values()}
    lacking = [name for name in robot.joint_names if name not in given | robot.optional]
    notes = []
    if lacking:
        listed = ", ".join(lacking)
        notes.append(
            f"the bag lacks joints of the robot: {listed}; add a topic that has them, or list them "
            "as optional_joints in the robot file where they stand still"
        )
    if rename:
        notes.append("rename: check each pair")
    return Match(tuple(topics), rename=rename, notes=tuple(notes))


def _apart(renames: Mapping[str, Mapping[str, str]], legs: set[str]) -> tuple[list[str], list[str]]:
    """Topics that together name most joints, each joint once, and others as good as one of them.

    Legs and arms, or left and right, may have drivers of their own; but commanded and measured
    angles name the same joints, and only `joint_states` says which are measured.
    """

    def rank(name: str) -> tuple[int, bool]:
        usual = name.rpartition("/")[2] == "joint_states"
        return len(legs & set(renames[name].values())), usual

    topics: list[str] = []
    rivals: list[str] = []
    for name in sorted(renames, key=rank, reverse=True):
        own = set(renames[name].values())
        shared = [other for other in topics if not own.isdisjoint(renames[other].values())]
        if not shared:
            topics.append(name)
        elif any(rank(name) >= rank(other) for other in shared):
            rivals.append(name)
    return topics, rivals


def _joints_by_field(others: Mapping[str, TopicContent], robot: Robot) -> Match | None:
    """The topic whose fields are the robot's joints, by their names or by their usual order."""
    joints = robot.joint_names
    for topic, one in others.items():
        said = matched_names(tuple(one.named), joints)
        if len(said) >= len(robot.leg_names):
            return _by_field({topic: {one.named[name]: joint for name, joint in said.items()}})
        named = matched_names([path.rpartition(".")[2] for path in one.numbers], joints)
        if len(named) >= len(robot.leg_names):
            paths = {path.rpartition(".")[2]: path for path in one.numbers}
            return _by_field({topic: {paths[name]: joint for name, joint in named.items()}})
        # An array next to names that are not the robot's is that of another robot.
        for paths_of in () if one.named else arrays_in(one.numbers).values():
            if one.type == LOLA_POSITIONS and len(paths_of) == len(LOLA_JOINTS):
                order = dict(zip(paths_of, LOLA_JOINTS, strict=True))
                own = {path: joint for path, joint in order.items() if joint in joints}
                return _by_field({topic: own}, f"{topic}: joints in the order of JointIndexes.msg")
            if len(paths_of) == len(joints) and _ANGLES.search(topic.lower()):
                own = dict(zip(paths_of, joints, strict=True))
                return _by_field({topic: own}, f"{topic}: {ORDER} robot file; correct it")
    return None


def _by_field(fields: Mapping[str, Mapping[str, str]], *notes: str) -> Match:
    return Match(tuple(fields), fields=fields, notes=notes)


def match_cells(
    seen: Mapping[str, TopicContent], others: Mapping[str, TopicContent], shoe: Shoe
) -> Match | None:
    """The topics that name the shoe's cells, or whose fields do, or one array of as many."""
    fitting = {
        name: matched_names(one.names, shoe.names)
        for name, one in seen.items()
        if one.type == SHOE_VOLTAGES_TYPE
    }
    fitting = {name: rename for name, rename in fitting.items() if rename}
    if fitting:
        rename = {old: new for one in fitting.values() for old, new in one.items() if old != new}
        return Match(tuple(fitting), rename=rename)
    by_words = {
        topic: names for topic, one in others.items() if (names := _cells_named(topic, one, shoe))
    }
    if by_words:
        given = {name for names in by_words.values() for name in names.values()}
        lacking = ", ".join(name for name in shoe.names if name not in given)
        notes = ["which field is which cell, by their words"]
        notes += [f"no field is {lacking}; add it"] if lacking else []
        return _by_field(by_words, *notes)
    arrays = [
        (topic, path, paths)
        for topic, one in others.items()
        if not one.named
        for path, paths in arrays_in(one.numbers).items()
    ]
    whole = [(topic, paths) for topic, _, paths in arrays if len(paths) == len(shoe.names)]
    if len(whole) == 1:
        topic, paths = whole[0]
        own = dict(zip(paths, shoe.names, strict=True))
        return _by_field({topic: own}, f"{topic}: {ORDER} shoe file; correct it")
    fields = dict[str, dict[str, str]]()
    for foot in FEET:
        cells = [name for name in shoe.names if name.startswith(f"{foot}/")]
        own_arrays = [
            (topic, paths)
            for topic, path, paths in arrays
            if len(paths) == len(cells) and foot_in(topic, path) == foot
        ]
        if len(own_arrays) != 1:
            return None
        topic, paths = own_arrays[0]
        fields.setdefault(topic, {}).update(zip(paths, cells, strict=True))
    return _by_field(fields, *(f"{topic}: {ORDER} shoe file; correct it" for topic in fields))


def _cells_named(topic: str, one: TopicContent, shoe: Shoe) -> dict[str, str]:
    """Cell by path, where messages list its name with a number, or fields have its words."""
    names = tuple(one.named)
    cells = matched_names(names, shoe.names) or cells_by_words("", names, shoe.names)
    # Joints may share a word with a cell, but not with all cells of a foot.
    for foot in FEET:
        if {name for name in shoe.names if name.startswith(f"{foot}/")} <= set(cells.values()):
            return {one.named[name]: cell for name, cell in cells.items()}
    return {} if names else cells_by_words(topic, one.numbers, shoe.names)


def match_wrench(
    seen: Mapping[str, TopicContent], robot: Robot, shoe: Shoe, foot: str
) -> Match | None:
    """The topic whose frame turns with the foot, else those whose names say so."""
    axes = [axis for axis in AXES if f"{foot}/{axis}" in shoe.names]
    wrenches = {name: one for name, one in seen.items() if one.type == WRENCH}
    if not axes or not wrenches:
        return None
    index = FEET.index(foot)
    joint = robot.feet[index].joint
    on_foot = [
        name for name, one in wrenches.items() if _parent_joint(robot, one.frames[0]) == joint
    ]
    framed = [name for name in wrenches if name not in on_foot]
    framed = [name for name in framed if _parent_joint(robot, wrenches[name].frames[0]) is None]
    text = {name: f"{name} {wrenches[name].frames[0]}".lower() for name in framed}
    said = {side: [name for name in framed if _WORDS[side].search(text[name])] for side in FEET}
    named = [name for name in said[foot] if not _HAND.search(text[name])]
    # What says that it is the other foot's is not this one's, for want of a better.
    unsaid = [name for name in framed if not any(name in said[side] for side in FEET)]
    fitting = on_foot or named or unsaid
    if not fitting:
        return None
    if len(fitting) > 1:
        return Match(tuple(fitting), chosen=False)
    one = wrenches[fitting[0]]
    frame = _frame(robot.model, one.frames[0])
    extra, notes, turn = dict[str, object](), list[str](), np.eye(3)
    rotation = _sole_R_sensor(robot, index, frame)
    if rotation is None:
        why = f"frame '{frame}' is not on the foot" if frame else "its messages name no frame"
        notes.append(f"{why}: axes are taken as parallel to the sole's; else give rotation_rpy_rad")
    elif np.abs(np.diag(rotation)).min() < PARALLEL:
        # Axes along or against the sole's are left to the polarities of the shoe file.
        turn = rotation
        extra["rotation_rpy_rad"] = np.round(pin.rpy.matrixToRpy(rotation), 9).tolist()
        notes.append(
            f"rotation_rpy_rad turns frame '{frame}' of the URDF to axes parallel to the sole's"
        )
    if "fz" in axes:
        force = float((turn @ one.force)[2])
        polarity = int(shoe.polarity[shoe.names.index(f"{foot}/fz")])
        if polarity * force < -LOADED_SHARE * robot.weight:
            notes.append(
                f"fz is {force:.0f} N on average, but the shoe file gives {foot}/fz the polarity "
                f"{polarity:+d}: check it"
            )
    return Match((fitting[0],), extra=extra, notes=tuple(notes))


def _sole_R_sensor(robot: Robot, foot: int, frame: str) -> FloatArray | None:
    """(3, 3) turns vectors of a sensor's frame into the sole's; None where not on the foot."""
    if _parent_joint(robot, frame) != robot.feet[foot].joint:
        return None
    model = robot.model
    placement = model.frames[model.getFrameId(_frame(model, frame))].placement
    return np.asarray(robot.feet[foot].placement.rotation.T @ placement.rotation)


def match_imu(seen: Mapping[str, TopicContent], robot: Robot) -> Match | None:
    """The IMU on the base, where frames say so."""
    names = [name for name, one in seen.items() if one.type == IMU]
    on_base = [name for name in names if _parent_joint(robot, seen[name].frames[0]) == BASE]
    fitting = _plain(on_base or names, "imu")
    return Match(tuple(fitting), chosen=len(fitting) == 1) if fitting else None


def match_base_pose(seen: Mapping[str, TopicContent], robot: Robot) -> Match | None:
    """Odometry or poses of a link that is fixed to the base, else any."""
    names = [name for name, one in seen.items() if one.type in POSES]
    framed = [name for name in names if _parent_joint(robot, _child(seen[name])) == BASE]
    # A pose without a child frame may be anything's: a foot's, a ball's.
    open_ended = [name for name in names if not _child(seen[name])]
    fitting = framed or open_ended
    if len(fitting) != 1:
        return Match(tuple(fitting), chosen=False) if fitting else None
    link = _frame(robot.model, _child(seen[fitting[0]]))
    root = str(robot.model.frames[ROOT_JOINTS].name)
    if link in ("", root):
        note = () if link else (f"its poses are taken as those of '{root}'; else add 'link'",)
        return Match(tuple(fitting), notes=note)
    return Match(tuple(fitting), extra={"link": link})


def _plain(names: list[str], last: str) -> list[str]:
    """The one of several topics whose last word is the usual one; all where it is not one."""
    usual = [name for name in names if name.rpartition("/")[2] in (last, "data")]
    return usual if len(usual) == 1 else names


def _parent_joint(robot: Robot, frame: str) -> int | None:
    """Joint that carries a link or fixed joint of the URDF; None where it has no such frame."""
    model: pin.Model = robot.model
    name = _frame(model, frame)
    return int(model.frames[model.getFrameId(name)].parentJoint) if model.existFrame(name) else None


def _frame(model: pin.Model, frame: str) -> str:
    """The URDF's name of a frame, without a robot's prefix."""
    return without_prefix(frame, {str(one.name) for one in model.frames}) or frame.lstrip("/")


def _child(one: TopicContent) -> str:
    return one.children[0] if one.children else ""


def _distinct(texts: Iterable[str]) -> tuple[str, ...]:
    return tuple(dict.fromkeys(texts))
