"""What each node makes when it starts, told by the calls that make it.

Every node is started once, in this process, without a robot; the calls that create publishers,
subscriptions, services, actions and parameters are listened to. So no page can name a topic, a
type or a quality of service that the nodes do not have.
"""

from __future__ import annotations

import importlib
import inspect
import os
import tempfile
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from unittest.mock import MagicMock, patch

import rclpy
from rclpy.action import ActionClient, ActionServer
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy

from shoecal_core.settings import Settings
from shoecal_ros import nodes
from shoecal_ros.common.node import ShoecalNode

NOT_SHOWN = ("/rosout", "/parameter_events", "/tf")
"""What every node of ROS has, and what is there only where tf2_msgs is installed."""
NOT_SHOWN_KINDS = ("rcl_interfaces", "type_description_interfaces")
"""Packages of the services that every node of ROS has."""


@dataclass(frozen=True)
class Link:
    """A node's end of a topic, service or action.

    Attributes:
        node: its name.
        role: publishes, subscribes, serves, calls, executes, asks.
        name: absolute, under the empty namespace.
        kind: for example `sensor_msgs/JointState`.
        quality: of service; empty for services and actions.
    """

    node: str
    role: str
    name: str
    kind: str
    quality: str = ""


@dataclass
class Made:
    """What one node has made.

    Attributes:
        node: its name.
        doc: first line of its module.
        links: in the order they were made.
        settings: section prefix and class of its parameters.
    """

    node: str
    doc: str
    links: list[Link] = field(default_factory=list)
    settings: list[tuple[str, type[Settings]]] = field(default_factory=list)


class Foreign:
    """Stands for a type of a package that is not installed here: nothing is made of it."""


def foreign(package: str, kind: str, name: str) -> type[Foreign]:
    """In place of `shoecal_ros.adapters.foreign.foreign`."""
    return type(name, (Foreign,), {"__module__": f"{package}.{kind}"})


def node_names() -> list[str]:
    """Every node of shoecal_ros."""
    folder = Path(nodes.__path__[0])
    return sorted(file.stem for file in folder.glob("*.py") if file.stem != "__init__")


def made_by(name: str) -> Made:
    """Start a node and tell what it made."""
    module = importlib.import_module(f"shoecal_ros.nodes.{name}")
    doc = (module.__doc__ or "").strip().splitlines()[0].removeprefix(f"Node `{name}`: ")
    (cls,) = (
        kind
        for _, kind in inspect.getmembers(module, inspect.isclass)
        if issubclass(kind, ShoecalNode) and kind.__module__ == module.__name__
    )
    made = Made(name, doc)
    with tempfile.TemporaryDirectory() as folder:
        rclpy.init(args=["--ros-args", "--log-level", "fatal", *_parameters(name, folder)])
        try:
            with _listened(made), patch.object(module, "foreign", foreign, create=True):
                node = cls()  # type: ignore[call-arg] # every node names itself
            node.end()
        finally:
            rclpy.try_shutdown()
    return made


def _parameters(name: str, folder: str) -> list[str]:
    values: Mapping[str, Mapping[str, object]] = {
        "shoe_driver": {"port": f"{folder}/port"},
        "planner": {"steps": True},
        "calibrator": {"state_dir": f"{folder}/state", "sessions_dir": f"{folder}/sessions"},
        "simulator": {"port": f"{folder}/port"},
    }
    pairs = [f"{key}:={value}" for key, value in values.get(name, {}).items()]
    return [part for pair in pairs for part in ("-p", pair)]


@contextmanager
def _listened(made: Made) -> Iterator[None]:
    """Note what nodes create while this is open."""

    def note(role: str, node: Node, kind: object, name: str, profile: object = None) -> None:
        quality = quality_of(profile) if isinstance(profile, QoSProfile) else ""
        known, kind_told = name if name.startswith("/") else f"/{name}", kind_name(kind)
        if known not in NOT_SHOWN and not kind_told.startswith(NOT_SHOWN_KINDS):
            made.links.append(Link(node.get_name(), role, known, kind_told, quality))

    def around(role: str, call: Callable[..., Any], *, quality: bool) -> Callable[..., Any]:
        def made_it(node: Node, kind: Any, name: str, *rest: Any, **named: Any) -> Any:
            profile = (*rest, *named.values()) if quality else ()
            found = next((one for one in profile if isinstance(one, QoSProfile)), None)
            note(role, node, kind, name, found)
            if _is_foreign(kind):
                return MagicMock()
            return call(node, kind, name, *rest, **named)

        return made_it

    def action(role: str, start: Callable[..., None]) -> Callable[..., None]:
        def made_it(self: Any, node: Node, kind: Any, name: str, *rest: Any, **named: Any) -> None:
            note(role, node, kind, name)
            if not _is_foreign(kind):
                start(self, node, kind, name, *rest, **named)

        return made_it

    settings = ShoecalNode.settings

    def declared(node: ShoecalNode, cls: type[Settings], section: str = "") -> Settings:
        made.settings.append((section, cls))
        return settings(node, cls, section)

    with (
        patch.object(
            Node, "create_publisher", around("publishes", Node.create_publisher, quality=True)
        ),
        patch.object(
            Node,
            "create_subscription",
            around("subscribes", Node.create_subscription, quality=True),
        ),
        patch.object(Node, "create_service", around("serves", Node.create_service, quality=False)),
        patch.object(Node, "create_client", around("calls", Node.create_client, quality=False)),
        patch.object(ActionServer, "__init__", action("executes", ActionServer.__init__)),
        patch.object(ActionClient, "__init__", action("asks", ActionClient.__init__)),
        patch.object(ShoecalNode, "settings", declared),
    ):
        yield


def _is_foreign(kind: object) -> bool:
    return isinstance(kind, type) and issubclass(kind, Foreign)


def quality_of(profile: QoSProfile) -> str:
    """In words."""
    words = [
        "reliable" if profile.reliability is ReliabilityPolicy.RELIABLE else "best effort",
        "keep all" if profile.history is HistoryPolicy.KEEP_ALL else f"keep last {profile.depth}",
    ]
    if profile.durability is DurabilityPolicy.TRANSIENT_LOCAL:
        words.append("latched")
    return ", ".join(words)


def kind_name(kind: Any) -> str:
    """`package/Name` of a message, service or action."""
    return f"{kind.__module__.split('.')[0]}/{kind.__name__}"


def all_made() -> list[Made]:
    """Every node, started one after the other; nobody else hears them."""
    os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "OFF"
    return [made_by(name) for name in node_names()]
