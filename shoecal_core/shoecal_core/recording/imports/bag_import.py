"""Bags of ROS 1 and ROS 2, made into a session."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import chain, pairwise
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial.transform import Rotation

from shoecal_core.arrays import FloatArray
from shoecal_core.errors import FieldError, named_together
from shoecal_core.recording import messages, schemas
from shoecal_core.recording.errors import RecordingError
from shoecal_core.recording.imports import foreign
from shoecal_core.recording.imports.bag import Bag, BagMessage
from shoecal_core.recording.imports.bag_fields import (
    IMU,
    JOINT_STATE,
    POSES,
    SENSORS,
    WRENCH,
    numbers_in,
    stamp_ns,
    table,
    text_problem,
)
from shoecal_core.recording.imports.bag_mapping import BagMapping, NamedTopics, load_bag_mapping
from shoecal_core.recording.imports.bag_match import first_text
from shoecal_core.recording.imports.foreign import ImportedRun, StampedMessage, Stamps
from shoecal_core.recording.imports.imported_angles import check_angles
from shoecal_core.recording.imports.mapping import BAG, Trial
from shoecal_core.recording.imports.named_numbers import named_twice, uneven
from shoecal_core.recording.imports.names import without_prefix
from shoecal_core.recording.imports.replayed import describe_replayed, replayed
from shoecal_core.recording.join import few_digits, in_order, two_orders, two_orders_text
from shoecal_core.recording.schemas import SHOE_VOLTAGES_TYPE
from shoecal_core.recording.session import Session
from shoecal_core.robot.urdf import ROOT_JOINTS, Outline, read_outline, read_urdf
from shoecal_core.shoe.shoe import Shoe
from shoecal_core.shoe.shoe_file import load_shoe

LISTED = 10
"""Names of joints that a message lists at most."""
TYPES: Mapping[str, Collection[str]] = {
    "joints": (JOINT_STATE,),
    "cells": (SHOE_VOLTAGES_TYPE,),
    "imu": (IMU,),
    "base_pose": tuple(POSES),
    "wrenches": (WRENCH,),
}
"""Types of the topics that a field of the mapping may name, unless it names their fields too."""


def import_bags(mapping_path: Path, folder: Path, out: Path) -> Session:
    """Make a session of bags.

    Args:
        mapping_path: says which topics mean what.
        folder: where the bags are.
        out: the session to make.

    Returns:
        The session. What was left out of a run is in the run's `info.notes`.

    Raises:
        FileError: for the first thing wrong in mapping or bags, naming file and field; nothing is
            made then.
    """
    folder = Path(folder)
    mapping = load_bag_mapping(Path(mapping_path), folder)
    head = mapping.head
    importer = _Importer(mapping, read_outline(head.urdf), load_shoe(head.shoe))
    with named_together(head.recordings(folder)):
        runs = [importer.run(folder / trial.files[BAG], trial) for trial in head.trials]
    return foreign.write_session(out, head, check_angles(head, runs))


@dataclass(frozen=True)
class _Received:
    """Messages of one topic that a trial has in its bag.

    Attributes:
        path: of the bag.
        topic: of the messages.
        stamps: [ns].
        contents: decoded, one for each stamp.
        notes: of the trial, to which what is changed or left out is added.
    """

    path: Path
    topic: str
    stamps: list[int]
    contents: list[Any]
    notes: list[str]

    def note(self, text: str) -> None:
        self.notes.append(f"{self.topic}: {text}")

    def error(self, problem: str) -> RecordingError:
        """The error to raise for this topic."""
        return RecordingError(self.path, problem, field=self.topic)

    def ordered(self, rows: ArrayLike) -> tuple[Stamps, FloatArray]:
        """Stamps (T,) [ns] that increase, and the rows (T, ...) of their messages, as they are."""
        stamps = np.array(self.stamps, dtype=np.int64)
        kept = in_order(stamps)
        return stamps[kept], np.array(rows, dtype=np.float64)[kept]

    def part(self, places: Sequence[int]) -> _Received:
        """Some of its messages."""
        return replace(
            self,
            stamps=[self.stamps[place] for place in places],
            contents=[self.contents[place] for place in places],
        )


class _Importer:
    def __init__(self, mapping: BagMapping, urdf: Outline, shoe: Shoe) -> None:
        self._mapping = mapping
        self._urdf = urdf
        for topic, names in mapping.cells.fields.items():
            for path, name in names.items():
                if name not in shoe.names:
                    raise FieldError(
                        mapping.head.path,
                        f"'{name}' is no channel of '{shoe.name}' ({', '.join(shoe.names)})",
                        field=f"cells.{topic}.{path}",
                    )
        for foot in mapping.wrenches:
            foreign.check_six_axis(mapping.head.path, f"wrenches.{foot}", shoe, foot)
        self._base_T_link = _base_T_link(mapping)

    def run(self, path: Path, trial: Trial) -> ImportedRun:
        """One trial.

        Raises:
            FileError: for a bag that cannot be read or does not hold what the mapping names.
        """
        with Bag(path) as bag:
            self._check_topics(bag)
            by_topic: dict[str, list[BagMessage]] = defaultdict(list)
            wanted = bag.messages(self._mapping.topics, trial.from_s, trial.to_s)
            for count, message in enumerate(wanted, 1):
                foreign.check_length(path, count)
                by_topic[message.topic].append(message)
        notes: list[str] = []
        found: list[StampedMessage] = []
        for topic, own in by_topic.items():
            contents = [message.content for message in own]
            by_receipt = topic in self._mapping.received
            times = [one.received_ns if by_receipt else stamp_ns(one.content) for one in own]
            received = _Received(path, topic, times, contents, notes)
            if not by_receipt:
                _check_stamps(received)
                sent = [(one.received_ns, at) for one, at in zip(own, times, strict=True) if at]
                delays = [1e-9 * (there - at) for there, at in sent]
                if apart := replayed(delays):
                    raise received.error(describe_replayed(apart))
            late = int(np.sum(~in_order(np.array(times))))
            if late:
                _check_digits(received)
                received.note(
                    f"{late} of {len(times)} messages have a stamp that repeats or goes back; they "
                    "are left out"
                )
            found += self._convert(received)
        missing = sorted(self._mapping.topics - set(by_topic))
        if missing:
            raise RecordingError(
                path,
                f"has no message of {', '.join(missing)} in this trial; check from_s and to_s (the "
                f"bag is {bag.length_s:.1f} s long)",
            )
        return ImportedRun(path, trial, found, tuple(notes))

    def _check_topics(self, bag: Bag) -> None:
        mapping = self._mapping
        by_path = {"joints.topics": mapping.joints.fields, "cells.topics": mapping.cells.fields}
        for key, topics in mapping.by_field.items():
            types = TYPES[key.partition(".")[0]]
            for topic in topics:
                if first_text(bag, topic):
                    problem = text_problem({topic: bag.topics[topic].type})
                    raise FieldError(mapping.head.path, problem, field=key)
                if topic in bag.topics and topic in by_path.get(key, {}):
                    continue
                fitting = [name for name, one in bag.topics.items() if one.type in types]
                if topic not in fitting:
                    kind = f"is {bag.topics[topic].type}" if topic in bag.topics else "is missing"
                    raise FieldError(
                        mapping.head.path,
                        f"'{topic}' {kind} in {bag.path.name}; topics of {' or '.join(types)} "
                        f"there: {', '.join(fitting) or 'none'}",
                        field=key,
                    )

    def _convert(self, received: _Received) -> list[StampedMessage]:
        """Messages of a run made of those of one topic of the bag."""
        mapping, topic, contents = self._mapping, received.topic, received.contents
        # One message may hold both.
        by_path = [own for own in (mapping.joints, mapping.cells) if topic in own.fields]
        if by_path:
            return list(chain.from_iterable(self._numbers(received, own) for own in by_path))
        if topic in mapping.joints.topics:
            return self._joint_states(received)
        if topic in mapping.cells.topics:
            return self._voltages(received)
        frame = self._frame(received)
        numbers = SENSORS[contents[0].__msgtype__]
        stamps, rows = received.ordered([numbers(one) for one in contents])
        if topic == mapping.imu:
            # By the message's definition -1 as first element says that there is no orientation;
            # what is no unit quaternion the reader leaves out.
            oriented = contents[0].orientation_covariance[0] != -1.0
            return foreign.imu(stamps, frame, rows if oriented else rows[:, :6])
        if mapping.base_pose is not None and topic == mapping.base_pose.topic:
            good = foreign.whole_poses(received.path, topic, rows, received.notes)
            return foreign.base_poses(stamps[good], frame, self._of_the_base(rows[good]))
        foot, wrench = next(
            (foot, one) for foot, one in mapping.wrenches.items() if one.topic == topic
        )
        turned = [part @ wrench.rotation.T for part in (rows[:, :3], rows[:, 3:])]
        return foreign.wrenches(foot, stamps, frame, np.hstack(turned))

    def _numbers(self, received: _Received, own: NamedTopics) -> list[StampedMessage]:
        """Joint angles or readings in messages of any type, by the paths of their fields."""
        topic, paths = received.topic, list(own.fields[received.topic])
        names = list(own.fields[topic].values())
        try:
            stamps, rows = received.ordered(table(received.contents, paths))
        except LookupError as error:
            listed = ", ".join(numbers_in(received.contents[0])) or "none"
            raise received.error(
                f"its messages have no number '{error}'; there are: {listed}; correct the mapping"
            ) from error
        if own is not self._mapping.joints:
            return foreign.voltages(stamps, names, rows, topic)
        unknown = sorted(set(names) - self._urdf.joints)
        if unknown:
            raise FieldError(
                self._mapping.head.path,
                f"'{unknown[0]}' is no joint of the robot; correct it",
                field=f"joints.{topic}",
            )
        return foreign.joint_states(stamps, names, rows * self._mapping.head.angle_unit)

    def _frame(self, received: _Received) -> str:
        """A frame as the URDF names it; one that it has not stays as it is."""
        frame = str(received.contents[0].header.frame_id)
        known = without_prefix(frame, self._urdf.frames)
        if known is not None and known != frame.lstrip("/"):
            received.note(f"frame '{frame}' is taken as the URDF's '{known}'")
        return known or frame

    def _joint_states(self, received: _Received) -> list[StampedMessage]:
        by_names: dict[tuple[tuple[str, ...], tuple[str, ...]], list[int]] = defaultdict(list)
        without = 0
        for place, one in enumerate(received.contents):
            if len(one.position) != len(one.name):
                without += 1
                continue
            with_effort = len(one.effort) == len(one.name)
            quantities: tuple[str, ...] = ("position", "effort")[: 1 + with_effort]
            by_names[tuple(one.name), quantities].append(place)
        if not by_names:
            raise received.error(uneven(received.contents[0]))
        if without:
            received.note(f"{without} messages without joint angles left out")
        senders = {key: received.part(places) for key, places in by_names.items()}
        groups = [(names, np.array(one.stamps)) for (names, _), one in senders.items()]
        if (twice := two_orders(groups)) is not None:
            raise received.error(two_orders_text(*twice))
        unknown = set[str]()
        found = []
        for (names, quantities), sent in senders.items():
            renamed = [self._mapping.joints.rename.get(name, name) for name in names]
            own = [place for place, name in enumerate(renamed) if name in self._urdf.joints]
            unknown |= set(renamed) - self._urdf.joints
            self._require_once(received, renamed)
            if not own:
                continue
            stamps, rows = sent.ordered(
                [[getattr(one, key) for key in quantities] for one in sent.contents]
            )
            position, *effort = np.moveaxis(rows[..., own], 1, 0)
            position = position * self._mapping.head.angle_unit
            found += foreign.joint_states(stamps, [renamed[at] for at in own], position, *effort)
        if not found:
            raise received.error(
                f"names no joint of the robot (there are: {_few(unknown) or 'none'}); correct "
                "'joints' of the mapping"
            )
        if unknown:
            received.note(f"joints that the robot lacks left out: {_few(unknown)}")
        return found

    def _require_once(self, received: _Received, names: Sequence[str]) -> None:
        """Refuse joints that one message names twice, or a field of another topic gives, too."""
        if problem := named_twice(names, sorted(self._urdf.joints)):
            raise received.error(problem)
        by_path = chain.from_iterable(one.values() for one in self._mapping.joints.fields.values())
        if twice := sorted(set(by_path) & set(names)):
            problem = (
                f"'{twice[0]}' is given by a field and by {received.topic}; leave one of them out"
            )
            raise FieldError(self._mapping.head.path, problem, field="joints")

    def _voltages(self, received: _Received) -> list[StampedMessage]:
        rename = self._mapping.cells.rename
        return [
            StampedMessage(
                stamp,
                schemas.VOLTAGES,
                messages.shoe_voltages(
                    stamp,
                    int(one.sequence),
                    [rename.get(cell, cell) for cell in one.cell],
                    one.voltage,
                    one.status,
                    temperature=float(one.temperature),
                    frame_id=str(one.header.frame_id),
                ),
            )
            for stamp, one in zip(received.stamps, received.contents, strict=True)
        ]

    def _of_the_base(self, poses: FloatArray) -> FloatArray:
        """Poses (T, 7), position and quaternion, of the URDF's root by those of the mapped link."""
        rotation = Rotation.from_quat(poses[:, 3:])
        link_R_base, link_p_base = self._base_T_link
        quaternion = (rotation * Rotation.from_matrix(link_R_base)).as_quat()
        return np.hstack([poses[:, :3] + rotation.apply(link_p_base), quaternion])


def _check_stamps(received: _Received) -> None:
    """Refuse stamps that cannot be, and messages without any."""
    stamps = received.stamps
    if min(stamps) < 0 or max(stamps) >= foreign.LATEST_NS:
        raise received.error(
            "has stamps before 1970 or after 2038; correct its sender, or list it under "
            "'received' of the mapping"
        )
    if not any(stamps):
        raise received.error(
            "its messages carry no stamp; list it under 'received' of the mapping to take the "
            "times they were received"
        )


def _check_digits(received: _Received) -> None:
    """Refuse stamps that many messages of one sender share, unless a message is only sent again.

    Senders that share a topic differ in the names that they give.
    """
    senders: dict[tuple[str, ...], list[int]] = defaultdict(list)
    for at, content in enumerate(received.contents):
        lists = (getattr(content, key, None) for key in ("name", "cell"))
        names = tuple(chain.from_iterable(one for one in lists if isinstance(one, list)))
        senders[names].append(at)
    for places in senders.values():
        own = received.part(places)
        # With another content under the same stamp, it is another sample.
        fresh = [True, *(not _equal(*pair) for pair in pairwise(own.contents))]
        times = np.array(own.stamps)[fresh]
        if few_digits(times):
            raise received.error(
                f"{int((np.diff(times) == 0).sum())} of {len(times)} messages have the stamp of "
                "the one before: their sender rounds its stamps; let it stamp to a millisecond or "
                "better, or list the topic under 'received' of the mapping to take the times that "
                "the messages were received"
            )


def _equal(one: Any, other: Any) -> bool:
    """Whether two messages of one type are the same, field by field but for the header."""
    if hasattr(one, "__dataclass_fields__"):
        fields = [name for name in one.__dataclass_fields__ if name != "header"]
        return all(_equal(getattr(one, name), getattr(other, name)) for name in fields)
    return bool(np.array_equal(one, other))


def _base_T_link(mapping: BagMapping) -> tuple[FloatArray, FloatArray]:
    """Rotation (3, 3) and place (3,) [m] of the URDF's root in the link that the poses are of."""
    link = None if mapping.base_pose is None else mapping.base_pose.link
    if link is None:
        return np.eye(3), np.zeros(3)
    model = read_urdf(mapping.head.urdf).model
    fixed = [str(frame.name) for frame in model.frames if frame.parentJoint == ROOT_JOINTS - 1]
    if link not in fixed:
        raise FieldError(
            mapping.head.path,
            f"'{link}' is no link that is fixed to the robot's base; it must be one of: "
            f"{', '.join(fixed)}",
            field="base_pose.link",
        )
    base_in_link = model.frames[model.getFrameId(link)].placement.inverse()
    return base_in_link.rotation, base_in_link.translation


def _few(names: Iterable[str]) -> str:
    ordered = sorted(names)
    more = f" and {len(ordered) - LISTED} more" if len(ordered) > LISTED else ""
    return ", ".join(ordered[:LISTED]) + more
