"""The SROS2 policy file, and what a running node makes, in the same terms."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from xml.etree import ElementTree as ET

from rclpy.node import Node, NodeNameNonExistentError

POLICY = Path(__file__).parents[2] / "config/security/shoecal.policy.xml"
ACTION = "/_action/"
ACTION_TOPICS = ("feedback", "status")

RULES = {
    ("topics", "publish"): "publish",
    ("topics", "subscribe"): "subscribe",
    ("services", "reply"): "reply",
    ("services", "request"): "request",
    ("actions", "execute"): "execute",
    ("actions", "call"): "call",
}


@dataclass
class Rights:
    """Absolute names that a node may use, or uses."""

    publish: set[str] = field(default_factory=set)
    subscribe: set[str] = field(default_factory=set)
    reply: set[str] = field(default_factory=set)
    request: set[str] = field(default_factory=set)
    execute: set[str] = field(default_factory=set)
    call: set[str] = field(default_factory=set)

    def allow(self, rule: str) -> set[str]:
        names: set[str] = getattr(self, rule)
        return names


def policy() -> ET.Element:
    return ET.parse(POLICY).getroot()


def allowed() -> dict[str, Rights]:
    """By node."""
    found = {}
    for profile in policy().iter("profile"):
        node, rights = profile.attrib["node"], Rights()
        for rules in profile:
            for qualifier in rules.attrib:
                names = rights.allow(RULES[rules.tag, qualifier])
                names |= {_absolute(rule.text or "", node) for rule in rules}
        found[node] = rights
    return found


def used(tester: Node, node: str) -> Rights:
    """What a running node has made, as others see it; nothing while it is not known."""
    rights = Rights()
    try:
        for topic, _ in tester.get_publisher_names_and_types_by_node(node, "/"):
            _sort(topic, rights.publish, rights.execute)
        for topic, _ in tester.get_subscriber_names_and_types_by_node(node, "/"):
            _sort(topic, rights.subscribe, rights.call)
        for service, _ in tester.get_service_names_and_types_by_node(node, "/"):
            _sort(service, rights.reply, rights.execute)
        for service, _ in tester.get_client_names_and_types_by_node(node, "/"):
            _sort(service, rights.request, rights.call)
    except NodeNameNonExistentError:
        return Rights()
    return rights


def _sort(name: str, plain: set[str], actions: set[str]) -> None:
    action, found, _ = name.partition(ACTION)
    (actions if found else plain).add(action)


def _absolute(name: str, node: str) -> str:
    if name.startswith("/"):
        return name
    return f"/{node}{name[1:]}" if name.startswith("~/") else f"/{name}"
