"""Who else is on a node's topics, and whether that fits: what does not is reported by name."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from functools import partial
from typing import Any

from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos import QoSCompatibility, qos_check_compatible
from rclpy.subscription import Subscription
from rclpy.topic_endpoint_info import TopicEndpointInfo

from shoecal_ros.common.codes import Code, Problem, joined
from shoecal_ros.common.health import Condition, Level

OTHERS_TOPICS = ("/rosout", "/parameter_events", "/diagnostics")
"""Of all nodes there are."""

UNNAMED = "somebody without a node's name"
"""In place of the name of a node that starts, or of a program that is no ROS node."""
_NO_NAME = "_NODE_NAME_UNKNOWN_"
"""What the middleware says of an end of a topic whose node it does not know."""


class GraphMonitor:
    """Looks at one topic at a time: at a high rate that would hold messages up.

    Attributes:
        alone: resolved names of topics on which no other node may publish.
    """

    def __init__(self, node: Node) -> None:
        self.alone: set[str] = set()
        self._one_sender: set[str] = set()
        self._node = node
        self._turn = 0
        self._found: dict[tuple[str, bool], list[Problem]] = {}
        self._doubtful: dict[tuple[str, bool], Problem] = {}

    @property
    def condition(self) -> Condition:
        """For diagnostics: everybody who does not fit, and the cure."""
        found = [problem for problems in self._found.values() for problem in problems]
        reported = joined([*found, *self._doubtful.values()])
        if reported is not None:
            level = Level.ERROR if found else Level.WARN
            return Condition(level, reported.message, code=reported.code)
        return Condition(Level.OK, "no conflict on this node's topics")

    def watch(self) -> None:
        """Look at the next topic."""
        ends = self._ends()
        keys = [(end.topic_name, isinstance(end, Publisher)) for end in ends]
        for kept in (self._found, self._doubtful):
            for gone in kept.keys() - set(keys):
                del kept[gone]
        if not ends:
            return
        self._turn = (self._turn + 1) % len(ends)
        key, end = keys[self._turn], ends[self._turn]
        self._found[key] = self._look(end)
        self._doubtful.pop(key, None)
        if doubtful := self._doubles(end):
            self._doubtful[key] = doubtful

    def expect_one_sender(self, topic: str) -> Callable[[], list[str]]:
        """Report where several nodes publish what this one hears; gives their full names.

        Args:
            topic: relative name.
        """
        resolved = self._node.resolve_topic_name(topic)
        self._one_sender.add(resolved)
        return partial(self._senders, resolved)

    def _senders(self, topic: str) -> list[str]:
        infos = self._node.get_publishers_info_by_topic(topic)
        return sorted(node_name(info) for info in infos)

    def _ends(self) -> list[Publisher | Subscription]:
        ends: Sequence[Any] = (*self._node.publishers, *self._node.subscriptions)
        return [end for end in ends if end.topic_name not in OTHERS_TOPICS]

    def _look(self, end: Publisher | Subscription) -> list[Problem]:
        """What is wrong with the others at one topic."""
        node, topic = self._node, end.topic_name
        senders = node.get_publishers_info_by_topic(topic)
        hearers = node.get_subscriptions_info_by_topic(topic)
        sends = isinstance(end, Publisher)
        ours, theirs = (senders, hearers) if sends else (hearers, senders)
        own_name = node.get_fully_qualified_name()
        # As the others see it, too: what a node asks for itself leaves out what is not asked for.
        own = next((info for info in ours if node_name(info) == own_name), None)
        if own is None:
            return []
        found = [
            reported for info in theirs if (reported := _misfit(own, info, topic, sends=sends))
        ]
        return found + (self.rivals(topic) if sends and topic in self.alone else [])

    def _doubles(self, end: Publisher | Subscription) -> Problem | None:
        """Several senders of a topic that one should send; None where there are none."""
        if isinstance(end, Publisher) or end.topic_name not in self._one_sender:
            return None
        names = [f"'{name}'" for name in self._senders(end.topic_name)]
        if len(names) < 2:
            return None
        return Problem(
            Code.SEVERAL_SENDERS,
            f"{' and '.join(names)} publish {end.topic_name}; where they send the same joints, "
            "stop all but one",
        )

    def rivals(self, topic: str, allowed: Collection[str] = ()) -> list[Problem]:
        """Other publishers of a topic that is this node's alone.

        Args:
            topic: resolved name.
            allowed: full names of nodes that may publish it, too.
        """
        names = [name for name in self._senders(topic) if name not in allowed]
        own = self._node.get_fully_qualified_name()
        if own in names:
            names.remove(own)
        lines = (
            f"'{name}' publishes {topic}, too; stop one of them"
            if name != own
            else f"another node named '{name}' publishes {topic}, too; stop one of them, or wait "
            "if it was killed just now"
            for name in names
        )
        return [Problem(Code.SECOND_SENDER, line) for line in lines]


def _misfit(
    own: TopicEndpointInfo, other: TopicEndpointInfo, topic: str, *, sends: bool
) -> Problem | None:
    """Why two ends of a topic hear nothing of each other; None where they fit."""
    verb = "listens to" if sends else "publishes"
    if other.topic_type != own.topic_type:
        return Problem(
            Code.TYPE_MISFIT,
            f"'{node_name(other)}' {verb} {topic} as {other.topic_type}; it is "
            f"{own.topic_type}: nothing gets through; build both with one version of the messages",
        )
    offered, requested = (own, other) if sends else (other, own)
    compatible, reason = qos_check_compatible(offered.qos_profile, requested.qos_profile)
    if compatible != QoSCompatibility.ERROR:
        return None
    why = reason.strip().rstrip(";").removeprefix("ERROR: ")
    return Problem(
        Code.QOS_MISFIT,
        f"'{node_name(other)}' {verb} {topic} with another quality of service ({why}): "
        "nothing gets through; give it that of docs/reference/topics.md",
    )


def node_name(info: TopicEndpointInfo) -> str:
    """Of a node; one that starts has none yet, and a program that is no ROS node never has."""
    if info.node_name == _NO_NAME:
        return UNNAMED
    return f"{info.node_namespace.rstrip('/')}/{info.node_name}"
