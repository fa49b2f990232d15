"""What a viewer's layout shows: topics, their types and the fields that are drawn."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import yaml

from shoecal_core.errors import FileSyntaxError
from shoecal_core.files import read_bytes

RVIZ_TYPES = {
    "rviz_default_plugins/MarkerArray": "visualization_msgs/msg/MarkerArray",
    "rviz_default_plugins/PointStamped": "geometry_msgs/msg/PointStamped",
    "rviz_default_plugins/RobotModel": "std_msgs/msg/String",
    "rviz_default_plugins/Wrench": "geometry_msgs/msg/WrenchStamped",
}
"""What each of RViz's displays draws; of others only the topic is known."""

MAX_BYTES = 10_000_000
_NOT_A_LAYOUT = (
    ValueError, KeyError, TypeError, AttributeError, yaml.YAMLError, ElementTree.ParseError,
)  # fmt: skip
_STEP = re.compile(r"[A-Za-z_]\w*|\[\d*:?\d*\]")


@dataclass(frozen=True)
class Shown:
    """One thing that a layout draws.

    Attributes:
        topic: its absolute name.
        fields: from the message down, without indices; empty: the message as a whole.
        kind: type of message that the viewer takes it for; empty where it takes any.
        plain: how it is written in the layout, for messages.
    """

    topic: str
    fields: tuple[str, ...]
    kind: str
    plain: str


def shown_by(file: Path) -> list[Shown]:
    """Everything that a layout draws.

    Args:
        file: `.rviz` of RViz, `.json` of Foxglove, `.xml` of PlotJuggler.

    Raises:
        FileError: for a file that is no such layout.
    """
    read = {".rviz": _rviz, ".json": _foxglove, ".xml": _plotjuggler}.get(file.suffix)
    if read is None:
        problem = "is no layout: expected .rviz, .json (Foxglove), .xml (PlotJuggler)"
        raise FileSyntaxError(file, problem)
    try:
        found = list(dict.fromkeys(read(read_bytes(file, MAX_BYTES).decode())))
    except _NOT_A_LAYOUT as error:
        reported = " ".join(str(error).split())
        raise FileSyntaxError(
            file, f"is no layout of its viewer ({reported}); save it again"
        ) from error
    if not found:
        raise FileSyntaxError(file, "shows no topic; save the layout with something in it")
    return found


def _rviz(text: str) -> Iterator[Shown]:
    for display in yaml.safe_load(text)["Visualization Manager"]["Displays"]:
        kind = RVIZ_TYPES.get(display["Class"], "")
        for key in ("Topic", "Description Topic"):
            if key in display:
                topic = display[key]["Value"]
                yield Shown(topic, (), kind, f"{display['Name']}: {topic}")


def _foxglove(text: str) -> Iterator[Shown]:
    for name, panel in json.loads(text)["configById"].items():
        title = panel.get("foxglovePanelTitle", name)
        for topic in panel.get("topics", {}):
            yield Shown(topic, (), "", f"{title}: {topic}")
        if "topicToRender" in panel:
            topic = panel["topicToRender"]
            yield Shown(topic, (), "diagnostic_msgs/msg/DiagnosticArray", f"{title}: {topic}")
        for path in panel.get("paths", []):
            topic, _, rest = path["value"].partition(".")
            yield Shown(topic, _fields(rest), "", f"{title}: {path['value']}")


def _plotjuggler(text: str) -> Iterator[Shown]:
    root = ElementTree.fromstring(text)
    for plot in root.iter("DockArea"):
        title = plot.get("name", "plot")
        for curve in plot.iter("curve"):
            names = [curve.get(axis) for axis in ("curve_x", "curve_y") if curve.get(axis)]
            for name in names or [curve.attrib["name"]]:
                yield Shown(str(name), (), "", f"{title}: {name}")
    for selected in root.iter("selected_topics"):
        for topic in filter(None, selected.attrib["value"].split(";")):
            yield Shown(topic, (), "", f"chosen topics: {topic}")


def _fields(text: str) -> tuple[str, ...]:
    return tuple(step for step in _STEP.findall(text) if not step.startswith("["))


def split_path(shown: Shown, topics: dict[str, Any]) -> Shown:
    """PlotJuggler writes topic and fields alike: the longest topic that there is, is meant."""
    if shown.fields or shown.topic in topics:
        return shown
    parts = shown.topic.split("/")
    for count in range(len(parts) - 1, 1, -1):
        topic = "/".join(parts[:count])
        if topic in topics:
            rest = ".".join(parts[count:])
            return Shown(topic, _fields(rest), shown.kind, shown.plain)
    return shown
