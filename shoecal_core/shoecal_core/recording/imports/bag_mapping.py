"""Which topics of a bag mean what: the mapping file."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field
from itertools import chain
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from shoecal_core.arrays import FloatArray
from shoecal_core.files import Fields
from shoecal_core.recording.imports.mapping import MappingHead, open_mapping, read_head
from shoecal_core.shoe.shoe import FEET

CHOOSE = "choose"
"""Key of a draft under which several topics fit and one has to be chosen."""


@dataclass(frozen=True)
class NamedTopics:
    """Topics, and other names for what their messages name.

    Attributes:
        topics: one or more.
        rename: name in the robot file or shoe file by name in the bag.
        fields: of topics of whatever type: by topic, name in the robot file or shoe file by the
            path of a number in its messages.
    """

    topics: tuple[str, ...]
    rename: Mapping[str, str]
    fields: Mapping[str, Mapping[str, str]] = field(default_factory=dict)


@dataclass(frozen=True)
class WrenchTopic:
    """A six-axis sensor.

    Attributes:
        topic: of geometry_msgs/WrenchStamped.
        rotation: (3, 3) turns vectors of the sensor's frame to axes parallel to the sole's, or to
            those that the shoe file's polarities are given for.
    """

    topic: str
    rotation: FloatArray


@dataclass(frozen=True)
class BaseTopic:
    """The floating base: a topic of poses, and the link they are of (None: the URDF's root)."""

    topic: str
    link: str | None


@dataclass(frozen=True)
class BagMapping:
    """A whole mapping file of bags.

    Attributes:
        head: what every mapping says.
        wrenches: by foot.
        received: topics whose messages count at the time they were received, not at their stamp.
    """

    head: MappingHead
    joints: NamedTopics
    cells: NamedTopics
    wrenches: Mapping[str, WrenchTopic]
    imu: str | None
    base_pose: BaseTopic | None
    received: frozenset[str]

    @property
    def by_field(self) -> dict[str, tuple[str, ...]]:
        """Topics that are imported, by the field that names them."""
        base = self.base_pose
        return {
            "joints.topics": self.joints.topics,
            "cells.topics": self.cells.topics,
            "imu.topic": () if self.imu is None else (self.imu,),
            "base_pose.topic": () if base is None else (base.topic,),
            **{f"wrenches.{foot}.topic": (one.topic,) for foot, one in self.wrenches.items()},
        }

    @property
    def topics(self) -> frozenset[str]:
        """All that are imported."""
        return frozenset(chain.from_iterable(self.by_field.values()))


def load_bag_mapping(path: Path, folder: Path) -> BagMapping:
    """Read a mapping file of bags.

    Args:
        path: of the mapping.
        folder: of the recordings; the mapping may name files there.

    Raises:
        FileError: for anything missing, mistyped or contradictory, and for a topic that is still
            to be chosen.
    """
    fields = open_mapping(path, "joints", "cells", "wrenches", "imu", "base_pose", "received")
    if "cells" not in fields and "wrenches" not in fields:
        raise fields.error("wrenches", "is missing, and so is 'cells'; a run needs readings")
    wrenches = fields.mapping("wrenches") if "wrenches" in fields else None
    if wrenches is not None:
        wrenches.only(*FEET)
    mapping = BagMapping(
        head=read_head(fields, folder, None),
        joints=_named_topics(fields.mapping("joints")),
        cells=_named_topics(fields.mapping("cells")) if "cells" in fields else NamedTopics((), {}),
        wrenches={}
        if wrenches is None
        else {foot: _wrench(wrenches.mapping(foot)) for foot in FEET if foot in wrenches},
        imu=_topic(fields.mapping("imu"), "topic") if "imu" in fields else None,
        base_pose=_base(fields.mapping("base_pose")) if "base_pose" in fields else None,
        received=frozenset(fields.texts("received") if "received" in fields else []),
    )
    topics = [wrench.topic for wrench in mapping.wrenches.values()]
    for topic in set(topics):
        if topics.count(topic) > 1:
            raise fields.error("wrenches", f"'{topic}' is given for both feet; it is one foot's")
    for topic in mapping.received - mapping.topics:
        raise fields.error("received", f"'{topic}' is not imported; name one that is")
    return mapping


def _named_topics(fields: Fields) -> NamedTopics:
    keys = list(fields.keys())
    own = [key for key in keys if key.startswith("/")]
    fields.only("topics", "rename", CHOOSE, *own)
    _chosen(fields, "topics: [NAME]")
    rename = fields.mapping("rename") if "rename" in fields else None
    given = {topic: fields.mapping(topic) for topic in own}
    by_path = {topic: {path: one.text(path) for path in one.keys()} for topic, one in given.items()}
    for topic, names in by_path.items():
        if not names:
            raise fields.error(topic, "names no field; write {FIELD: NAME, ...}")
    listed = [name for names in by_path.values() for name in names.values()]
    twice = [name for name, count in Counter(listed).items() if count > 1]
    if twice:
        raise fields.error(own[0], f"'{twice[0]}' is given by two fields; leave one of them out")
    topics = tuple(fields.texts("topics")) if "topics" in fields or not own else ()
    if not topics and not own:
        raise fields.error("topics", "is empty; name the topics")
    return NamedTopics(
        (*topics, *own),
        {} if rename is None else {name: rename.text(name) for name in rename.keys()},
        by_path,
    )


def _wrench(fields: Fields) -> WrenchTopic:
    topic = _topic(fields, "topic", "rotation_rpy_rad")
    angles = fields.array("rotation_rpy_rad", (3,)) if "rotation_rpy_rad" in fields else np.zeros(3)
    return WrenchTopic(topic, Rotation.from_euler("xyz", angles).as_matrix())


def _base(fields: Fields) -> BaseTopic:
    topic = _topic(fields, "topic", "link")
    return BaseTopic(topic, fields.text("link") if "link" in fields else None)


def _topic(fields: Fields, *keys: str) -> str:
    fields.only(*keys, CHOOSE)
    _chosen(fields, "topic: NAME")
    return fields.text("topic")


def _chosen(fields: Fields, instead: str) -> None:
    """Refuse a topic that is still to be chosen."""
    if CHOOSE in fields:
        names = ", ".join(fields.texts(CHOOSE))
        raise fields.error(CHOOSE, f"several topics fit ({names}); write '{instead}' instead")
